// SPDX-License-Identifier: MIT
// What `penumbra view` makes of hands, files, plans and numbers; no device and no window.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <map>
#include <set>

#include "app/pipeline_file.h"
#include "app/session.h"
#include "app/shipped_files.h"
#include "app/view/controls.h"
#include "app/view/cost_mean.h"
#include "app/view/dataflow.h"
#include "app/view/file_watch.h"
#include "app/view/flight.h"
#include "app/view/flight_record.h"
#include "app/view/picture.h"
#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/shipped.h"
#include "tests/test_folder.h"

namespace penumbra::viewer {
namespace {

namespace fs = std::filesystem;

constexpr const char* shot_text = R"({
  "penumbra_shot": 1, "scene": "models/a.glb", "size": [64, 36], "frames": 9, "fps": 30, "cuts": [4],
  "camera": { "vertical_fov_deg": 50, "keys": [
    { "frame": 0, "position": [1, 2, 3], "target": [4, 1, -2], "up": [0.3, 1, 0.1] },
    { "frame": 8, "position": [2, 2, 3], "target": [4, 1, -2], "up": [0.3, 1, 0.1] } ] },
  "sun": { "keys": [ { "frame": 0, "to_sun": [1, 2, 0.5] } ] },
  "origin": [1000, 0, 0]
})";

Shot flown_shot() {
    Diagnostics diagnostics;
    const auto shot = parse_shot(shot_text, "/somewhere/fly.shot.json", diagnostics);
    EXPECT_TRUE(shot) << diagnostics.text();
    return shot.value_or(Shot{});
}

Camera seen(const Shot& shot, const Stance& stance) {
    Shot held = shot;
    held.camera = {stance.camera};
    return camera_at(held, 0, 1);
}

void expect_same(const Camera& a, const Camera& b, double tolerance) {
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(a.position[i], b.position[i], tolerance);
    for (size_t i = 0; i < 9; ++i) EXPECT_NEAR(a.world_from_view[i], b.world_from_view[i], tolerance);
}

TEST(ViewFlight, FollowsTheShotsCourseUntilHandsTakeOver) {
    const Shot shot = flown_shot();
    Flight flight(shot);
    for (int frame = 0; frame < 9; ++frame, flight.tick())  // its roll and its origin among it
        expect_same(seen(shot, flight.stance()), camera_at(shot, frame, 1), 1e-12);
    EXPECT_EQ(flight.stance().moment, 0) << "it begins again at its end";
    flight.tick();
    FlightInput sun;
    sun.sun = {0.1, 0};
    flight.steer(sun);
    expect_same(seen(shot, flight.stance()), camera_at(shot, 1, 1), 1e-12);  // the sun is no camera
    FlightInput look;
    look.look = {0.2, 0};
    flight.steer(look);
    const Stance held = flight.stance();
    flight.tick();
    EXPECT_EQ(flight.stance().camera.position, held.camera.position) << "the camera is in hands";
    EXPECT_EQ(flight.stance().moment, 2) << "and the shot plays on";
    flight.start_over();
    expect_same(seen(shot, flight.stance()), camera_at(shot, 0, 1), 1e-12);
}

// Whoever takes the camera into his hands sees no jump, but for the roll.
TEST(ViewFlight, TakingOverDoesNotTurnTheHead) {
    const Shot shot = flown_shot();
    Flight flight(shot);
    const Stance before = flight.stance();
    FlightInput nothing_much;
    nothing_much.look = {1e-9, 0};
    flight.steer(nothing_much);
    const glm::dvec3 a = glm::normalize(before.camera.target - before.camera.position),
                     b = glm::normalize(flight.stance().camera.target - flight.stance().camera.position);
    EXPECT_LT(glm::length(a - b), 1e-8);
    EXPECT_EQ(before.camera.position, flight.stance().camera.position);
}

TEST(ViewFlight, DistanceDependsOnTimeAloneAndDirectionsAreTheCameras) {
    const Shot shot = flown_shot();
    const auto fly = [&](int steps, glm::dvec3 move) {
        Flight flight(shot);
        FlightInput turn;
        turn.look = {0.7, 0.2};
        flight.steer(turn);
        const glm::dvec3 from = flight.stance().camera.position;
        FlightInput input;
        input.move = move;
        input.seconds = 1.0 / steps;
        for (int i = 0; i < steps; ++i) flight.steer(input);
        return std::pair(flight.stance().camera.position - from, flight.speed_m_per_s());
    };
    const auto [slow, speed] = fly(3, {0, 0, 1});
    EXPECT_LT(glm::length(slow - fly(60, {0, 0, 1}).first), 1e-9);
    EXPECT_NEAR(glm::length(slow), speed, 1e-9);
    EXPECT_NEAR(glm::length(fly(60, {1, 1, 1}).first), speed, 1e-9) << "no faster at an angle";
    Flight flight(shot);
    FlightInput turn;
    turn.look = {0.7, 0.2};
    flight.steer(turn);
    const Camera camera = seen(shot, flight.stance());
    const glm::dvec3 right = glm::make_vec3(camera.world_from_view.data());
    EXPECT_NEAR(glm::dot(glm::normalize(fly(1, {1, 0, 0}).first), right), 1, 1e-9);
    const glm::dvec3 back = glm::make_vec3(camera.world_from_view.data() + 6);
    EXPECT_NEAR(glm::dot(glm::normalize(slow), back), -1, 1e-9);
}

TEST(ViewFlight, NeitherHeadNorSunGoesOverTheTop) {
    const Shot shot = flown_shot();
    Flight flight(shot);
    FlightInput up;
    up.look = {0, 1};
    up.sun = {0, -1};
    for (int i = 0; i < 10; ++i) {
        flight.steer(up);
        const Camera camera = seen(shot, flight.stance());
        for (const double v : camera.world_from_view) ASSERT_TRUE(std::isfinite(v));
        ASSERT_GT(camera.world_from_view[4], 0) << "upside down";
    }
    EXPECT_NEAR(glm::length(flight.stance().sun.to_sun), 1, 1e-12);
    EXPECT_LT(flight.stance().sun.to_sun.y, -0.99) << "the sun may set";
}

// Recorded at uneven times, played at the shot's own.
TEST(ViewFlight, ARecordedFlightIsAShot) {
    const Shot shot = flown_shot();
    FlightRecord record;
    const auto at = [](double t) {
        Stance s;
        s.camera.position = {5 * std::cos(0.3 * t), 1 + t, 5 * std::sin(0.3 * t)};
        s.camera.target = s.camera.position + glm::dvec3(-std::cos(0.3 * t), 0.1, -std::sin(0.3 * t));
        s.sun.to_sun = t < 1 ? glm::dvec3(0.6, 0.8, 0) : glm::normalize(glm::dvec3(0.6, 0.8, 0.5 * (t - 1)));
        return s;
    };
    for (double t = 0; t < 2; t += 0.004 + 0.003 * std::sin(40 * t)) record.add(at(t), t);
    const fs::path folder = "/somewhere/else/far";
    const std::string text = record.shot_text(shot_text, shot, folder);
    Diagnostics diagnostics;
    const auto flown = parse_shot(text, folder / "flight.shot.json", diagnostics);
    ASSERT_TRUE(flown) << diagnostics.text() << text;
    EXPECT_EQ(fs::weakly_canonical(flown->model), "/somewhere/models/a.glb") << "seen from the new folder";
    EXPECT_EQ(flown->frames, static_cast<uint32_t>(record.seconds() * 30) + 1);
    EXPECT_TRUE(flown->cuts.empty());
    EXPECT_EQ(flown->vertical_fov_deg, 50);
    EXPECT_EQ(flown->origin, shot.origin);
    for (uint32_t frame = 0; frame < flown->frames; ++frame) {
        const double t = frame / 30.0;
        expect_same(camera_at(*flown, frame, 1), seen(*flown, at(t)), 2e-3);
        EXPECT_LT(glm::length(sun_at(*flown, frame).to_sun - at(t).sun.to_sun), 2e-3);
    }
    EXPECT_LT(flown->camera.size(), flown->frames) << "a key where the course bends, not per frame";
    EXPECT_GT(flown->camera.size(), 4u);
}

TEST(ViewFlight, AStraightFlightTakesTwoKeysAndAStandOne) {
    const Shot shot = flown_shot();
    FlightRecord straight, still;
    Stance s;
    s.camera.target = {0, 0, -1};
    s.sun.to_sun = {0, 1, 0};
    still.add(s, 0);
    for (int i = 0; i <= 30; ++i) {
        s.camera.position.x = s.camera.target.x = 0.1 * i;
        straight.add(s, i / 30.0);
    }
    Diagnostics diagnostics;
    const auto a =
        parse_shot(straight.shot_text(shot_text, shot, "/somewhere"), "/somewhere/a.shot.json", diagnostics);
    const auto b =
        parse_shot(still.shot_text(shot_text, shot, "/somewhere"), "/somewhere/b.shot.json", diagnostics);
    ASSERT_TRUE(a && b) << diagnostics.text();
    EXPECT_EQ(a->camera.size(), 2u);
    EXPECT_EQ(a->frames, 31u);
    EXPECT_EQ(a->sun.size(), 2u);
    EXPECT_EQ(b->frames, 1u);
    EXPECT_EQ(b->camera.size(), 1u);
}

// However near to a small model: a metre ahead, where hands look, is far beyond it.
TEST(ViewFlight, ASmallScenesFlightKeepsToItsCourse) {
    Shot shot = flown_shot();
    shot.camera.front().target = shot.camera.front().position + glm::dvec3(0, 0, -0.01);
    FlightRecord record;
    const auto at = [](double t) {
        Stance s;
        s.camera.position = 0.005 * glm::dvec3(std::cos(3 * t), 0, std::sin(3 * t));
        s.camera.target = s.camera.position + glm::dvec3(0, 0, -1);
        s.sun.to_sun = {0, 1, 0};
        return s;
    };
    for (int frame = 0; frame <= 60; ++frame) record.add(at(frame / 30.0), frame / 30.0);
    Diagnostics diagnostics;
    const auto flown =
        parse_shot(record.shot_text(shot_text, shot, "/somewhere"), "/somewhere/a.shot.json", diagnostics);
    ASSERT_TRUE(flown) << diagnostics.text();
    for (uint32_t frame = 0; frame < flown->frames; ++frame)
        EXPECT_LT(glm::distance(glm::make_vec3(camera_at(*flown, frame, 1).position.data()),
                                glm::make_vec3(seen(*flown, at(frame / 30.0)).position.data())),
                  2e-5);
}

TEST(ViewFlight, ALongFlightIsAShotOfAsManyFramesAsThereMayBe) {
    FlightRecord record;
    Stance s;
    s.camera.target = {0, 0, -1};
    s.sun.to_sun = {0, 1, 0};
    record.add(s, 0);
    record.add(s, 99'999 / 30.0);
    EXPECT_FALSE(record.has_more(30));
    record.add(s, 4000);
    EXPECT_TRUE(record.has_more(30));
    Diagnostics diagnostics;
    const auto flown = parse_shot(record.shot_text(shot_text, flown_shot(), "/somewhere"),
                                  "/somewhere/a.shot.json", diagnostics);
    ASSERT_TRUE(flown) << diagnostics.text();
    EXPECT_EQ(flown->frames, FlightRecord::most_frames);
}

class ViewFiles : public ::testing::Test {
  protected:
    void SetUp() override { fs::create_directories(folder_ / "nodes/shared"); }
    fs::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
        // Coarse clocks would else give two writes the same time.
        static int tick = 0;
        fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() + std::chrono::seconds(++tick));
        return folder_ / name;
    }
    test::TestFolder folder_;
};

TEST_F(ViewFiles, EveryKindOfChangeIsNoticedOnce) {
    const fs::path a = write("a.json", "one");
    write("nodes/n.comp", "two");
    FileWatch watch;
    watch.watch({a}, {folder_ / "nodes"});
    EXPECT_FALSE(watch.changed());
    const auto once = [&](const char* what) {
        EXPECT_TRUE(watch.changed()) << what;
        EXPECT_FALSE(watch.changed()) << what;
    };
    write("a.json", "eno");
    once("of the same length");
    write("beside", "new");
    EXPECT_FALSE(watch.changed()) << "not one of them";
    fs::rename(folder_ / "beside", a);
    once("an editor's rename");
    write("nodes/shared/more.glsl", "x");
    once("a new file in a folder of the folder");
    fs::remove(folder_ / "nodes/n.comp");
    once("gone");
    fs::remove(a);
    once("the pipeline itself gone");
    write("a.json", "back");
    once("and back");
}

TEST_F(ViewFiles, APipelineIsReadFromAllThatItExtends) {
    const fs::path a = write("a.json", R"({"extends": "b.json"})"),
                   b = write("b.json", R"({"extends": "c.json"})"),
                   c = write("c.json", R"({"extends": "a.json"})");
    EXPECT_EQ(files_of_pipeline(a), (std::set<fs::path>{a, b, c}));  // and a circle ends
    write("b.json", "{ broken");
    EXPECT_EQ(files_of_pipeline(a), (std::set<fs::path>{a, b}));
}

Plan plan_of(const std::string& name, const std::vector<std::string>& settings = {}) {
    const CheckedPipeline checked = test::shipped_pipeline(name, settings);
    Diagnostics diagnostics;
    auto plan =
        compile(checked, standalone_target(checked, reference_device(true), {640, 360}, {}), {}, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

// A node that is several passes has one control; the seed, which is the shot's, has none.
TEST(ViewControls, AreThoseOfTheDeclarationsWithTheirValues) {
    const NodeSet nodes = shadow_nodes();
    size_t count = 0;
    for (const char* name : {"hybrid_shadows", "shadows", "fidelityfx", "one_ray", "sigma", "reflections"}) {
        SCOPED_TRACE(name);
        const Plan plan = plan_of(name);
        std::map<std::string, const Param*> declared;
        for (const PlanPass& pass : plan.passes)
            for (const Param& param : nodes.find(pass.type)->type.params)
                if (!param.constant && param.name != "seed") declared[pass.node + "." + param.name] = &param;
        const std::vector<Control> controls = controls_of(plan);
        EXPECT_EQ(controls.size(), declared.size());
        count += controls.size();
        for (const Control& c : controls) {
            ASSERT_TRUE(declared.count(c.name())) << c.name();
            const Param& param = *declared[c.name()];
            EXPECT_EQ(c.param.doc, param.doc);
            EXPECT_EQ(c.param.unit, param.unit);
            EXPECT_EQ(c.param.range, param.range);
            EXPECT_EQ(c.value.index(), param.default_value.index()) << c.name() << " is of another type";
            EXPECT_FALSE(c.changed());
            for (const auto& [pass, i] : c.places)
                EXPECT_EQ(plan.passes[pass].params[i].param.name, param.name);
        }
    }
    EXPECT_GT(count, 20u);
}

// What the view says a control's setting is, is what --set makes of it.
TEST(ViewControls, TheirSettingsAreWhatSetTakes) {
    const Plan plain = plan_of("hybrid_shadows");
    std::vector<std::string> settings;
    std::map<std::string, ParamValue> wanted;
    for (Control c : controls_of(plain)) {
        if (auto* real = std::get_if<float>(&c.value))
            *real = c.param.range ? static_cast<float>(0.3 * (*c.param.range)[0] + 0.7 * (*c.param.range)[1])
                                  : 1.0f / 3;
        if (auto* list = std::get_if<std::vector<float>>(&c.value))
            for (float& v : *list) v = v * 0.5f + 0.1f;
        EXPECT_TRUE(c.changed()) << c.name();
        settings.push_back(setting_of(c));
        wanted[c.name()] = c.value;
    }
    ASSERT_GT(wanted.size(), 3u);
    for (const Control& c : controls_of(plan_of("hybrid_shadows", settings)))
        EXPECT_EQ(c.value, wanted.at(c.name())) << c.name();
}

TEST(ViewDataflow, BoxesLieApartAndLinesAreTheReads) {
    for (const char* name : {"hybrid_shadows", "shadows", "fidelityfx", "reflections", "raw"}) {
        SCOPED_TRACE(name);
        const Plan plan = plan_of(name);
        const Dataflow flow = dataflow_of(plan, 0.5);
        std::set<std::pair<std::string, std::string>> drawn, wanted;
        for (const FlowLine& line : flow.lines) {
            const FlowBox &from = flow.boxes[line.from], &to = flow.boxes[line.to];
            drawn.emplace(from.rows.at(line.row), to.title);
            EXPECT_LT(from.x + from.width, to.x + (from.kind == FlowBox::Kind::pass ? 0 : 1e9))
                << from.rows[line.row] << " into " << to.title << " goes backwards";
        }
        for (const PlanPass& pass : plan.passes)
            for (const std::string& read : pass.reads) wanted.emplace(read, pass.node);
        EXPECT_EQ(drawn, wanted);
        for (size_t i = 0; i < flow.boxes.size(); ++i)
            for (size_t j = 0; j < i; ++j) {
                const FlowBox &a = flow.boxes[i], &b = flow.boxes[j];
                const bool apart = a.x + a.width <= b.x || b.x + b.width <= a.x ||
                                   a.y + a.height <= b.y + 1e-6 || b.y + b.height <= a.y + 1e-6;
                EXPECT_TRUE(apart) << a.title << " and " << b.title;
            }
    }
}

PlanarImage image_of(const std::vector<std::pair<const char*, std::vector<float>>>& planes) {
    PlanarImage image{static_cast<uint32_t>(planes[0].second.size()), 1, {}};
    for (const auto& [name, values] : planes) image.planes.push_back({name, PlaneType::real, values, {}});
    return image;
}

std::array<int, 3> texel(const Picture& p, uint32_t x) {
    return {p.rgba[4 * x], p.rgba[4 * x + 1], p.rgba[4 * x + 2]};
}

using Rgb = std::array<int, 3>;

// A mean from the first frame on would show seconds of compiling for a dozen frames more.
TEST(ViewCosts, TheFrameThatCompilesIsForgotten) {
    CostMean mean;
    mean.add({{"trace", "trace", 900, 950}}, 2000);
    EXPECT_EQ(mean.cpu_ms(), 2000) << "better than nothing";
    for (int frame = 0; frame < 4; ++frame) mean.add({{"trace", "trace", 4, {}}}, 5);
    EXPECT_NEAR(mean.cpu_ms(), 5, 1e-9);
    EXPECT_NEAR(*mean.passes()[0].ms, 4, 1e-9);
    mean.add({{"trace", "trace", 14, 3}}, 15);
    EXPECT_NEAR(mean.cpu_ms(), 6.5, 1e-9) << "a frame is a part of it";
    EXPECT_NEAR(*mean.passes()[0].ms, 5.5, 1e-9);
    EXPECT_EQ(mean.passes()[0].cpu_ms, 3) << "of what is known";
}

TEST(ViewPicture, NumbersOfEveryKindAreSeen) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Picture mask = picture_of(image_of({{"Y", {0, 0.5f, 1, nan}}}));
    EXPECT_EQ(mask.note, "");
    EXPECT_EQ(texel(mask, 1), (Rgb{128, 128, 128})) << "a mask has no transfer curve";
    EXPECT_EQ(texel(mask, 3), (Rgb{255, 0, 255}));
    // Metres would all be white: they are stretched, and it is said how far.
    const Picture metres = picture_of(image_of({{"Y", {2, 4, 10, std::numeric_limits<float>::infinity()}}}));
    EXPECT_EQ(texel(metres, 0), (Rgb{0, 0, 0}));
    EXPECT_EQ(texel(metres, 1), (Rgb{64, 64, 64}));
    EXPECT_EQ(texel(metres, 3), (Rgb{255, 255, 255}));
    EXPECT_NE(metres.note.find("10"), std::string::npos) << metres.note;
    const Picture flat = picture_of(image_of({{"Y", {7, 7}}}));
    EXPECT_EQ(texel(flat, 0), (Rgb{255, 255, 255}));
    const Picture color = picture_of(image_of({{"R", {0.5f}}, {"G", {0}}, {"B", {9}}}));
    EXPECT_EQ(texel(color, 0), (Rgb{188, 0, 255}));
    PlanarImage light = image_of({{"R", {0.01f, 2, 4}}, {"G", {0.01f, 2, 4}}, {"B", {0.01f, 2, 4}}});
    light.light = true;
    const Picture bright = picture_of(light);
    EXPECT_EQ(texel(bright, 0)[0], 25) << "what is dark is as it is";
    EXPECT_LT(texel(bright, 1)[0] + 8, texel(bright, 2)[0]) << "and what is bright is not cut off";
    const Picture vectors = picture_of(image_of({{"X", {-1}}, {"Y", {1}}, {"Z", {0}}}));
    EXPECT_EQ(texel(vectors, 0), (Rgb{0, 255, 128}));
    PlanarImage words{2, 1, {{"W", PlaneType::uint, {}, {0xffffffffu, 0x1u}}}};
    EXPECT_EQ(texel(picture_of(words), 0), (Rgb{255, 255, 255}));
    EXPECT_EQ(texel(picture_of(words), 1), (Rgb{8, 8, 8}));
}

TEST(ViewPicture, ErrorsHaveASignAndTheUnknownIsNoGrey) {
    const std::vector<float> mask{0.5f, 0.5f, 0.5f, 0.5f}, truth{0.25f, 0.75f, 0.5f, 0}, known{1, 1, 1, 0};
    const Picture error = error_picture(4, 1, mask, truth, known);
    EXPECT_GT(texel(error, 0)[0], texel(error, 0)[2] + 100) << "too light is red";
    EXPECT_GT(texel(error, 1)[2], texel(error, 1)[0] + 100) << "too dark is blue";
    EXPECT_EQ(texel(error, 2)[0], texel(error, 2)[2]);
    EXPECT_NE(texel(error, 3)[0], texel(error, 3)[2]);
    const Picture right = mask_picture(4, 1, truth, known);
    EXPECT_EQ(texel(right, 1), (Rgb{191, 191, 191}));
    EXPECT_NE(texel(right, 3)[0], texel(right, 3)[2]);
    const Picture both = split(mask_picture(4, 1, mask), right, 0.5);
    EXPECT_EQ(texel(both, 1), (Rgb{128, 128, 128}));
    EXPECT_EQ(texel(both, 3), texel(right, 3));
    EXPECT_NE(texel(both, 2), texel(right, 2)) << "the line";
    EXPECT_EQ(split(mask_picture(4, 1, mask), right, 1).rgba, mask_picture(4, 1, mask).rgba);
    EXPECT_EQ(split(mask_picture(4, 1, mask), right, 0).rgba, right.rgba);
}

}  // namespace
}  // namespace penumbra::viewer
