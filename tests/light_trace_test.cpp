// SPDX-License-Identifier: MIT
// Lights that are near, on a floor below a plate that hangs: the truth by rays is the closed form, the rays
// of trace are samples of it, what the light cannot reach is no receiver, and what knows the sun alone says
// so.
#include <unistd.h>

#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "app/light_truth.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/models/shapes.h"
#include "host/truth/light_visibility.h"
#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;
constexpr double plate_m = 1;  // its height

struct File {
    fs::path path = fs::temp_directory_path() / ("penumbra_plate_" + std::to_string(getpid()) + ".glb");
    File() {
        Model model;
        model.materials = {{{0.8f, 0.8f, 0.8f, 1}, -1}};
        for (const bool plate : {false, true}) {
            Mesh mesh;
            mesh.parts.push_back(to_part(plate ? ground(0.4, 0.3, 1, 1) : ground(10, 10, 4, 4), 0));
            model.meshes.push_back(std::move(mesh));
            Node node;
            node.name = plate ? "plate" : "floor";
            node.mesh = plate;
            node.translation = {0, plate ? plate_m : 0, 0};
            model.nodes.push_back(node);
        }
        write_file(path, to_glb(model));
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
};

const std::array<glm::dvec3, 4> plate{
    glm::dvec3(-0.4, plate_m, -0.3), {0.4, plate_m, -0.3}, {0.4, plate_m, 0.3}, {-0.4, plate_m, 0.3}};

Shot shot_with(LightKind kind, std::array<uint32_t, 2> size) {
    static const File file;
    ShotLight light;
    light.kind = kind;
    light.radius = kind == LightKind::tube ? 0.1 : 0.4;
    light.length = kind == LightKind::rectangle ? 1 : 1.5;
    light.height = 0.5;
    light.outer_deg = 60;
    light.range = 3.4;
    light.keys = {{0, {0.2, 2.6, 0.1}, {0.1, -1, 0.1}, {1, 0.1, 0.3}, 1, 1}};
    Shot shot;
    shot.name = "plate";
    shot.model = file.path;
    shot.size = size;
    shot.frames = 4;
    shot.camera = {{0, {0, 0.9, 2.6}, {0, 0, 0}, {0, 1, 0}}};
    shot.has_sun = false;
    shot.sun = {{0, {0, 1, 0}}};
    shot.lights["lamp"] = light;
    return shot;
}

// What each pixel shows of the floor; nothing elsewhere.
std::vector<std::optional<glm::dvec3>> floor_points(const Shot& shot) {
    const Camera camera = camera_at(shot, 0, double(shot.size[0]) / shot.size[1]);
    const glm::dmat3 axes = glm::make_mat3(camera.world_from_view.data());
    const glm::dvec3 eye = glm::make_vec3(camera.position.data());
    std::vector<std::optional<glm::dvec3>> points;
    for (uint32_t y = 0; y < shot.size[1]; ++y)
        for (uint32_t x = 0; x < shot.size[0]; ++x) {
            const double u = 2 * (x + 0.5) / shot.size[0] - 1, v = 2 * (y + 0.5) / shot.size[1] - 1;
            const glm::dvec3 way =
                axes * glm::dvec3(u / camera.clip_from_view[0], v / camera.clip_from_view[5], -1);
            const double t = -eye.y / way.y, at_plate = (plate_m - eye.y) / way.y;
            const glm::dvec3 p = eye + t * way, q = eye + at_plate * way;
            const bool behind = at_plate > 0 && at_plate < t && std::abs(q.x) < 0.41 && std::abs(q.z) < 0.31;
            const bool floor = t > 0 && std::abs(p.x) < 9 && std::abs(p.z) < 9 && !behind;
            points.push_back(floor ? std::optional(p) : std::nullopt);
        }
    return points;
}

class NearLights : public GpuTest, public ::testing::WithParamInterface<LightKind> {};

TEST_P(NearLights, TheTruthIsTheClosedForm) {
    const Shot shot = shot_with(GetParam(), {40, 24});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_light_truth(gpu(), shot, "lamp", diagnostics, warnings, false);
    ASSERT_TRUE(session) << diagnostics.text();
    const Truth truth = counted_light_truth(*session, 0, 16384);
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    double sum = 0, squares = 0;
    size_t soft = 0, unreached = 0, lit = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points[i]) continue;
        const bool reached = light.reaches(*points[i]);
        unreached += !reached;
        if (std::abs(glm::length(*points[i] - light.centre()) - 3.4) > 0.01 &&
            GetParam() != LightKind::spot) {
            EXPECT_EQ(truth.receiver[i] > 0, reached) << i;
        }
        if (!reached || truth.receiver[i] == 0) continue;
        const double exact = light.visibility(*points[i], plate), error = double(truth.visibility[i]) - exact;
        if (exact == 1) {
            ++lit;
            EXPECT_EQ(truth.visibility[i], 1) << i;
        }
        if (!(exact > 0.02 && exact < 0.98)) continue;
        ++soft;
        sum += error;
        squares += error * error;
    }
    std::printf("%s: %zu soft pixels, bias %.6f, RMSE %.6f, %zu unreached\n", name_of(GetParam()), soft,
                sum / double(soft), std::sqrt(squares / double(soft)), unreached);
    EXPECT_GT(soft, 20u);
    EXPECT_GT(lit, 50u);
    EXPECT_GT(unreached, 50u);
    EXPECT_LT(std::abs(sum) / double(soft), 2e-4);
    EXPECT_LT(std::sqrt(squares / double(soft)), 8e-4);
}

std::unique_ptr<Session> open(const Shot& shot, const char* name, const std::vector<std::string>& settings,
                              Diagnostics& diagnostics) {
    const auto pipeline = load_pipeline(
        fs::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (std::string(name) + ".json"), settings, diagnostics);
    const auto checked = pipeline ? check(*pipeline, test_nodes(), diagnostics) : std::nullopt;
    if (!checked) return nullptr;
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.optimum = false;
    options.captures = checked->output_names();
    options.light = "lamp";
    std::vector<std::string> warnings;
    return Session::open(gpu(), test_nodes(), *checked, shot, options, diagnostics, warnings);
}

// One ray is one sample: its mean square error is v (1 - v), and its mean is v.
TEST_P(NearLights, ARayIsASampleOfIt) {
    const Shot shot = shot_with(GetParam(), {192, 108});
    Diagnostics diagnostics;
    const auto session = open(shot, "light_raw", {}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    const NearLight light(light_block(shot.lights.at("lamp"), 0, glm::dvec3(0)));
    const auto points = floor_points(shot);
    double expected = 0, squares = 0, sum = 0, soft = 0;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        session->run_frame(frame, frame == 0);
        const std::vector<float> v = captured_planes(session->view(), "visibility")[0];
        for (size_t i = 0; i < points.size(); ++i) {
            if (!points[i] || !light.reaches(*points[i])) continue;
            const double exact = light.visibility(*points[i], plate), error = double(v[i]) - exact;
            if (exact == 1) {
                EXPECT_EQ(v[i], 1) << i;
            }
            if (!(exact > 0.02 && exact < 0.98)) continue;
            expected += exact * (1 - exact);
            squares += error * error;
            sum += error;
            ++soft;
        }
    }
    std::printf("%s: N_eff %.3f, bias %.4f of %.0f\n", name_of(GetParam()), expected / squares, sum / soft,
                soft);
    EXPECT_GT(soft, 1000);
    EXPECT_NEAR(expected / squares, 1, 0.08);
    EXPECT_LT(std::abs(sum / soft), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Kinds, NearLights,
                         ::testing::Values(LightKind::point, LightKind::sphere, LightKind::disc,
                                           LightKind::rectangle, LightKind::tube, LightKind::spot),
                         [](const auto& test) { return std::string(name_of(test.param)); });

class NearLightsRefused : public GpuTest {};

TEST_F(NearLightsRefused, ByWhatKnowsTheSunAlone) {
    const Shot shot = shot_with(LightKind::rectangle, {32, 18});
    Diagnostics whole, node;
    EXPECT_EQ(open(shot, "raw", {}, whole), nullptr);
    EXPECT_NE(whole.text().find("\"raw\" knows the sun alone, and the shot's light is \"lamp\", a rectangle"),
              std::string::npos)
        << whole.text();
    EXPECT_EQ(open(shot, "one_ray", {"inputs.light={}"}, node), nullptr);
    EXPECT_NE(node.text().find("nodes.gather: \"gather\" knows the sun alone"), std::string::npos)
        << node.text();
}

TEST_F(NearLightsRefused, OffIsNoRayAndNoShadow) {
    Shot shot = shot_with(LightKind::rectangle, {96, 54});
    shot.lights["lamp"].keys[0].power = 0;
    Diagnostics diagnostics;
    const auto session = open(shot, "light_raw", {}, diagnostics);
    ASSERT_TRUE(session) << diagnostics.text();
    session->run_frame(0, true);
    const auto planes = captured_planes(session->view(), "visibility");
    for (const float v : planes.at(0)) ASSERT_EQ(v, 1);
    EXPECT_EQ(counters_of(session->view(), "trace").at("rays"), 0u);
    EXPECT_EQ(counters_of(session->view(), "classify").at("receivers"), 0u);
}

}  // namespace
}  // namespace penumbra::test
