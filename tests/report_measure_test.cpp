// SPDX-License-Identifier: MIT
// What `penumbra report` measures, on small images: brute force does what brute force must, figures are those
// of render, reference and compare, and mistakes leave no page behind.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/commands.h"
#include "app/report/measure.h"
#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/test_folder.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

constexpr size_t contender_count = 2 + (brute_force_rays.size() - 1) + proved_rays.size();  // raw is one ray

class ReportMeasure : public test::GpuTest {
  protected:
    void SetUp() override {
        GpuTest::SetUp();
        fs::create_directories(folder_ / "images");
        fs::create_directories(folder_ / "shots");
        Diagnostics diagnostics;
        auto contenders =
            open_contenders({pipeline("raw"), pipeline("one_ray")}, PENUMBRA_SOURCE_DIR, nodes_, diagnostics);
        ASSERT_TRUE(contenders) << diagnostics.text();
        results_.contenders = std::move(contenders->list);
        results_.device = test::gpu().info();
        Study& study = results_.study;
        study.size = study.edge_size = {64, 48};
        study.seeds = study.rounds = 2;
        study.rays = 256;
        study.after_cut = {1, 4};
        study.moving_frames = 8;
        study.moving_every = 4;
        study.settling = 0;
        study.edge_frame = 3;
        study.analytic_border_px = 4;
    }

    static std::string pipeline(const std::string& name) {
        return PENUMBRA_SOURCE_DIR "/pipelines/" + name + ".json";
    }
    size_t contender(const std::string& id) const {
        for (size_t c = 0; c < results_.contenders.size(); ++c)
            if (results_.contenders[c].id == id) return c;
        ADD_FAILURE() << id;
        return 0;
    }
    Bench bench() {
        return {test::gpu(), nodes_, folder_, [this](uint64_t work) { work_ += work; },
                [this](const std::string& text) { said_ += text; }};
    }

    test::TestFolder folder_;
    NodeSet nodes_ = shadow_nodes();
    Results results_;
    uint64_t work_ = 0;
    std::string said_;
};

// Every number of plain rays competes once, whether its pipeline was asked for or not.
TEST_F(ReportMeasure, PlainRaysAreContendersOnce) {
    Diagnostics diagnostics;
    for (const bool all : {false, true}) {
        const std::vector<std::string> wanted =
            all ? std::vector<std::string>{} : std::vector{pipeline("one_ray")};
        const auto contenders = open_contenders(wanted, PENUMBRA_SOURCE_DIR, nodes_, diagnostics, true);
        ASSERT_TRUE(contenders) << diagnostics.text();
        std::multiset<std::pair<bool, uint32_t>> plain, every;
        std::set<std::string> ids;
        for (const Contender& c : contenders->list) {
            EXPECT_TRUE(ids.insert(c.id).second) << c.id;
            EXPECT_EQ(std::ranges::count(c.pipeline.inputs, "cascade_maps", &HostInput::name), 0) << c.id;
            if (c.plain) plain.emplace(c.plain->proofs, c.plain->per_pixel);
        }
        for (const uint32_t rays : brute_force_rays) every.emplace(false, rays);
        for (const uint32_t rays : proved_rays) every.emplace(true, rays);
        EXPECT_EQ(plain, every);
        EXPECT_EQ(ids.contains("raw") && ids.contains("many_rays"), all);
        EXPECT_EQ(ids.contains("rays_1") && ids.contains("many_rays_16"), !all);
        std::set<std::string> left_out;
        for (const LeftOut& left : contenders->left_out) left_out.insert(fs::path(left.file).filename());
        EXPECT_EQ(left_out.contains("hybrid_cascades.json"), all);
    }
}

// Of a lamp: pipelines for lamps alone compete, and are judged by the lamp's truth, of which one ray is one.
TEST_F(ReportMeasure, ALampIsMeasuredAsTheSunIs) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto contenders = open_contenders({pipeline("light"), pipeline("light_raw")}, PENUMBRA_SOURCE_DIR, nodes_,
                                      diagnostics, true, true);
    ASSERT_TRUE(contenders) << diagnostics.text();
    EXPECT_EQ(contenders->list.size(), 1 + std::size(brute_force_rays));
    std::erase_if(contenders->list, [](const Contender& c) { return c.plain && c.plain->per_pixel > 1; });
    results_.contenders = std::move(contenders->list);
    results_.study.light = "panel";
    results_.study.after_cut = {};
    auto shot = open_report_shot(PENUMBRA_SOURCE_DIR "/scenes/lights/interior.shot.json", folder_ / "shots",
                                 0, diagnostics);
    ASSERT_TRUE(shot && keep_light_alone("panel", *shot, diagnostics)) << diagnostics.text();
    ASSERT_TRUE(measure_shot(bench(), *shot, results_, diagnostics, warnings)) << diagnostics.text();
    for (const Row& row : results_.rows) {
        const bool raw = results_.contenders[row.contender].id == "light_raw";
        ASSERT_TRUE(row.moving.n_eff);
        EXPECT_FALSE(row.flip) << "the lit picture is the sun's";
        if (raw)
            EXPECT_NEAR(*row.moving.n_eff, 1, 0.15);
        else
            EXPECT_GT(*row.moving.n_eff, 50);
    }
    EXPECT_FALSE(keep_light_alone("panle", *shot, diagnostics));
    EXPECT_FALSE(open_contenders({pipeline("raw")}, PENUMBRA_SOURCE_DIR, nodes_, diagnostics, true, true));
}

TEST_F(ReportMeasure, BruteForceGainsWithEveryRayAndIsChargedForIt) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const EdgeShot edge = make_edge_shot(16, 1, results_.study.edge_frame, folder_ / "shots", diagnostics);
    ASSERT_TRUE(measure_edge(bench(), edge, results_, diagnostics, warnings)) << diagnostics.text();
    ASSERT_EQ(results_.edge.size(), contender_count);
    EXPECT_EQ(work_, work_of_edge(results_.study));
    const auto n_eff = [&](const std::string& id) { return *results_.edge[contender(id)].metrics.n_eff; };
    EXPECT_NEAR(n_eff("raw"), 1,
                0.12);  // one ray is one ray: about 1500 pixels and two seeds say so within 5 %
    // A pixel's rays are spread evenly: N rays are worth more than N. Proofs change none of them.
    for (const uint32_t rays : {2u, 4u, 8u, 16u, 32u, 64u}) {
        const std::string id = "rays_" + std::to_string(rays);
        EXPECT_GT(n_eff(id), rays);
        EXPECT_EQ(n_eff(id), n_eff("many_" + id));
    }
}

// What a shot leaves to its models, and names from where it stands, is the same for the one that stands
// still elsewhere.
TEST_F(ReportMeasure, AShotOfSeveralModelsStandsStill) {
    fs::create_directories(folder_ / "scenes");
    const std::string lamp = PENUMBRA_SOURCE_DIR "/scenes/lamp.glb";
    fs::create_symlink(lamp, folder_ / "scenes/a.glb");
    std::ofstream(folder_ / "scenes/two.shot.json")
        << R"({"penumbra_shot": 1, "scene": [{"file": "a.glb", "name": "a"},
               {"file": "a.glb", "name": "b", "translation": [9, 0, 0]}], "frames": 5,
               "objects": {"b": {"keys": [{"frame": 0}, {"frame": 4, "translation": [1, 0, 0]}]}}})";
    Diagnostics diagnostics;
    const auto shot = open_report_shot(folder_ / "scenes/two.shot.json", folder_ / "shots", 4, diagnostics);
    ASSERT_TRUE(shot && shot->still) << diagnostics.text();
    EXPECT_EQ(shot->moving.camera.size(), 1u);
    EXPECT_EQ(shot->still->camera.front().position, shot->moving.camera.front().position);
    ASSERT_EQ(shot->still->models.size(), 2u);
    for (const PlacedModel& model : shot->still->models) EXPECT_TRUE(fs::is_regular_file(model.file));
    EXPECT_TRUE(objects_move(shot->moving));
    EXPECT_FALSE(objects_move(*shot->still));
}

TEST_F(ReportMeasure, RowsAreWhatRenderReferenceAndCompareSay) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const EdgeShot edge = make_edge_shot(8, 0.5, 7, folder_ / "shots", diagnostics);
    const auto shot = open_report_shot(edge.shot.file, folder_ / "shots", 4, diagnostics);
    ASSERT_TRUE(shot) << diagnostics.text();
    ASSERT_TRUE(measure_shot(bench(), *shot, results_, diagnostics, warnings)) << diagnostics.text();
    EXPECT_EQ(work_, work_of_shot(results_.study));
    ASSERT_EQ(results_.rows.size(), contender_count);
    EXPECT_NE(said_.find("14 contenders in 2 rounds, besides the truth of 2 frames"), std::string::npos)
        << said_;
    EXPECT_TRUE(fs::is_regular_file(folder_ / results_.shots[0].motion_image));
    for (const Row& row : results_.rows) {
        EXPECT_EQ(row.after_cut.size(), 2u);
        EXPECT_EQ(row.over_time.size(), 2u);
        const bool cpu = results_.device.is_cpu;
        ASSERT_TRUE(row.mask_cost(cpu)) << "no timestamps";
        EXPECT_LE(row.mask_cost(cpu)->median, (cpu ? row.frame_cpu_ms : row.frame_ms)->median);
        for (const std::string& image : row.images)
            EXPECT_TRUE(fs::is_regular_file(folder_ / image)) << image;
        const std::optional<PlainRays>& plain = results_.contenders[row.contender].plain;
        if (plain && plain->proofs) {
            EXPECT_LT(*row.rays_per_pixel, 0.9 * plain->per_pixel);  // some tiles are decided
            EXPECT_EQ(row.same_as, contender("rays_" + std::to_string(plain->per_pixel)));
            EXPECT_FALSE(row.passes.empty());  // its cost is its own
        } else {
            EXPECT_NEAR(*row.rays_per_pixel, plain ? plain->per_pixel : 1, 1e-6);  // all pixels are undecided
        }
    }

    for (const auto& [file, frames, every, id, setting, still] :
         {std::tuple(shot->moving.file, "3..7", 4u, "one_ray", "", false),
          std::tuple(shot->still->file, "3", 1u, "one_ray", "", true),
          std::tuple(shot->still->file, "3", 1u, "raw", "", true),
          std::tuple(shot->moving.file, "3..7", 4u, "raw", "", false),
          std::tuple(shot->moving.file, "3..7", 4u, "rays_4", "nodes.trace.params.rays_per_pixel=4",
                     false)}) {
        testing::internal::CaptureStdout();
        ReferenceArguments reference;
        reference.view.shot = file.string();
        reference.out = (folder_ / "truth").string();
        reference.frames = frames;
        reference.size = "64x48";
        ASSERT_EQ(run_reference(reference), exit_good);
        CompareArguments compare;
        compare.image = (folder_ / "1").string();
        compare.reference = reference.out;
        compare.also = {(folder_ / "2").string()};
        compare.border = results_.study.analytic_border_px;
        compare.json = true;
        for (const uint32_t seed : {1u, 2u}) {
            RenderArguments render;
            render.files = {pipeline(*setting ? "raw" : id)};
            if (*setting) render.settings = {setting};
            render.view.shot = reference.view.shot;
            render.out = (folder_ / std::to_string(seed)).string();
            render.frames = frames;
            render.every = every;
            render.size = reference.size;
            render.seed = seed;
            render.no_jitter = true;
            ASSERT_EQ(run_render(render), exit_good);
        }
        std::fflush(stdout);
        testing::internal::GetCapturedStdout();
        testing::internal::CaptureStdout();
        ASSERT_EQ(run_compare(compare), exit_good);
        std::fflush(stdout);
        const auto said = nlohmann::json::parse(testing::internal::GetCapturedStdout());
        const Row& row = *results_.row(0, contender(id));
        const MaskMetrics& metrics = still ? *row.after(4) : row.moving;
        EXPECT_DOUBLE_EQ(*metrics.n_eff, said["n_eff"]["value"].get<double>()) << file;
        EXPECT_DOUBLE_EQ(*metrics.rmse_all, said["rmse"]["all"].get<double>()) << file;
        EXPECT_EQ(nlohmann::json(metrics.n_eff_ci95.value()), said["n_eff"]["ci95"]) << file;
        for (const char* folder : {"truth", "1", "2"}) fs::remove_all(folder_ / folder);
    }
}

// A pipeline with another name and nothing else runs its own frames under the first seed, for its cost, and
// has the other's figures; one that differs in its seed alone does not.
TEST_F(ReportMeasure, TheSameMasksAreJudgedOnceAndOthersAreNot) {
    const auto variant = [&](const std::string& name, const std::string& rest) {
        const fs::path file = folder_ / (name + ".json");
        std::ofstream(file) << R"({"penumbra": 1, "extends": ")" << pipeline("raw") << R"(", "name": ")"
                            << name << "\"" << rest << "}";
        return file.string();
    };
    Diagnostics diagnostics;
    auto contenders =
        open_contenders({variant("copy", R"(, "nodes": {"again": {"type": "shade", "out": {"lit": "lit2"}}},
                                              "outputs": ["visibility", "lit", "lit2"])"),
                         pipeline("raw"), variant("proofs", R"(, "inputs": {"neighbours": {}}, "nodes": {
                             "classify": {"out": {"tile_list": "facing", "trace_args": "facing_args", "preloaded_hits": "facing_hits"}},
                             "beams": {"type": "beams", "in": {"candidates": "facing", "candidate_args": "facing_args",
                                       "candidate_hits": "facing_hits", "proved_before": "proved@-1"}, "out": {"proved": "proved"}}})"),
                         variant("other", R"(, "nodes": {"trace": {"params": {"sampling": "published"}}})")},
                        {}, nodes_, diagnostics);
    ASSERT_TRUE(contenders) << diagnostics.text();
    results_.contenders = std::move(contenders->list);
    std::vector<std::string> warnings;
    const EdgeShot edge = make_edge_shot(8, 0.5, 6, folder_ / "shots", diagnostics);
    const auto shot = open_report_shot(edge.shot.file, folder_ / "shots", 4, diagnostics);
    ASSERT_TRUE(measure_shot(bench(), *shot, results_, diagnostics, warnings)) << diagnostics.text();
    const Row &copy = *results_.row(0, contender("copy")), &raw = *results_.row(0, contender("raw")),
              &other = *results_.row(0, contender("other")), &proofs = *results_.row(0, contender("proofs"));
    EXPECT_EQ(copy.same_as, contender("raw"));    // the one with fewer passes
    EXPECT_EQ(proofs.same_as, contender("raw"));  // though it remembers what it proved
    EXPECT_FALSE(raw.same_as);
    EXPECT_FALSE(other.same_as);
    EXPECT_EQ(copy.moving.n_eff, raw.moving.n_eff);
    EXPECT_EQ(copy.after(4)->n_eff, raw.after(4)->n_eff);
    EXPECT_NE(other.moving.n_eff, raw.moving.n_eff);
    EXPECT_EQ(copy.passes.size(), raw.passes.size() + 1);  // its costs are its own
    ASSERT_TRUE(measure_edge(bench(), edge, results_, diagnostics, warnings)) << diagnostics.text();
    ASSERT_EQ(results_.edge.size(), results_.contenders.size());
    EXPECT_EQ(results_.edge[contender("copy")].metrics.n_eff, results_.edge[contender("raw")].metrics.n_eff);
    EXPECT_NE(results_.edge[contender("other")].metrics.n_eff, results_.edge[contender("raw")].metrics.n_eff);
}

// What memos promise: without the other kinds of history a frame's mask is the same after others as after a
// reset, in every shipped pipeline.
TEST_F(ReportMeasure, AMaskWithoutHistoryDoesNotKnowItsPast) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto contenders = open_contenders({}, PENUMBRA_SOURCE_DIR, nodes_, diagnostics);
    const auto shot = read_shot(PENUMBRA_SOURCE_DIR "/scenes/fan.shot.json", diagnostics);
    ASSERT_TRUE(contenders && shot) << diagnostics.text();
    std::map<CostMemory, std::set<std::string>> without;
    std::set<std::string> with;
    KeptScene scene;
    for (const Contender& contender : contenders->list) {
        SCOPED_TRACE(contender.id);
        const auto open = [&] {
            return Runner::open(test::gpu(), nodes_, contender, *shot, {64, 36}, false, scene, diagnostics,
                                warnings);
        };
        const auto goes_on = open(), starts = open();
        ASSERT_TRUE(goes_on && starts) << diagnostics.text();
        if (contender.variant()) continue;
        if (goes_on->has_history()) {
            with.insert(contender.id);
            continue;
        }
        without[goes_on->cost_memory()].insert(contender.id);
        for (uint32_t frame = 0; frame < 3; ++frame) {
            const Sample sample = goes_on->run(frame, frame == 0, true);
            EXPECT_EQ(sample.visibility, starts->run(frame, true, true).visibility);
            EXPECT_EQ(sample.true_cost, frame > 0 || goes_on->cost_memory() != CostMemory::frame_before);
        }
        EXPECT_EQ(goes_on->run(4, false, true).true_cost, goes_on->cost_memory() == CostMemory::none);
    }
    using Names = std::set<std::string>;
    // hybrid_shadows and its presets remember which tiles were left to rays.
    EXPECT_EQ(with, (Names{"fidelityfx", "hybrid_cascades", "hybrid_fidelityfx", "hybrid_shadows",
                           "hybrid_shadows_best", "hybrid_shadows_fast", "one_ray", "shadows", "shadows_best",
                           "shadows_fast", "shadows_still", "sigma"}));
    EXPECT_EQ(without[CostMemory::all], (Names{"covered", "many_rays"}));
    EXPECT_EQ(without[CostMemory::frame_before], (Names{"cascades_only"}));
}

TEST_F(ReportMeasure, AnInterruptedRunGoesOnWhereItWas) {
    Diagnostics diagnostics;
    ReportArguments arguments;
    arguments.out = (folder_ / "out").string();
    arguments.quick = true;
    arguments.size = "64x48";
    arguments.seeds = 1;
    arguments.pipelines = {pipeline("raw")};
    arguments.shots = {make_edge_shot(8, 0.5, 39, folder_ / "shots", diagnostics).shot.file.string()};
    const auto run = [&] {
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        EXPECT_EQ(run_report(arguments), exit_good);
        testing::internal::GetCapturedStdout();
        std::ifstream stream(folder_ / "out/results.json");
        const std::string results((std::istreambuf_iterator<char>(stream)), {});
        return std::pair(results, testing::internal::GetCapturedStderr());
    };
    const auto [first, measured_first] = run();
    EXPECT_NE(measured_first.find("shot.edge_8px_+0.5: 1 of 8 parts"), std::string::npos) << measured_first;
    // What is whole is not measured again, or the times would differ; what is not gives the same masks.
    fs::remove(folder_ / "out/parts/edge.16px_-1.json");
    fs::remove(folder_ / "out/index.html");
    const auto [second, measured_second] = run();
    EXPECT_EQ(second, first);
    EXPECT_EQ(measured_second.find("shot."), std::string::npos) << measured_second;
    EXPECT_NE(measured_second.find("edge.16px_-1: 3 of 8 parts"), std::string::npos) << measured_second;
    EXPECT_TRUE(fs::exists(folder_ / "out/index.html"));
    arguments.again = true;
    EXPECT_NE(run().second.find("shot.edge_8px_+0.5: 1 of 8 parts"), std::string::npos);
}

// At an odd size, with what a front has and without what it has not.
TEST_F(ReportMeasure, AFrontIsMeasuredInMotionAlone) {
    Diagnostics diagnostics;
    ReportArguments arguments;
    arguments.out = (folder_ / "out").string();
    arguments.front = true;
    arguments.size = "99x77";
    arguments.rounds = 1;
    arguments.rays = 64;
    arguments.pipelines = {pipeline("one_ray")};
    arguments.shots = {make_edge_shot(8, 0.5, 15, folder_ / "shots", diagnostics).shot.file.string()};
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    ASSERT_EQ(run_report(arguments), exit_good);
    testing::internal::GetCapturedStdout();
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("14 contenders at 99x77: about "), std::string::npos) << said;
    EXPECT_NE(said.find("1 of 1 parts"), std::string::npos) << said;
    std::ifstream stream(folder_ / "out/results.json");
    const auto json = nlohmann::json::parse(stream);
    ASSERT_EQ(json["results"].size(), 14u);
    EXPECT_TRUE(json["edge"].empty());
    EXPECT_TRUE(json["shots"][0]["still_file"].is_null());
    size_t on_front = 0;
    for (const auto& row : json["results"]) {
        EXPECT_TRUE(row["after_cut"].empty());
        ASSERT_EQ(row["over_time"].size(), 1u);
        EXPECT_EQ(row["over_time"][0]["frame"], 15);
        EXPECT_FALSE(row["mask_ms"]["median"].is_null() && row["mask_cpu_ms"]["median"].is_null());
        EXPECT_GT(row["front"]["n_eff_over_plain"]["value"], 0);
        on_front += row["front"]["on_front"].get<bool>();
    }
    EXPECT_GE(on_front, 1u);
    EXPECT_TRUE(fs::exists(folder_ / "out/index.html"));
}

TEST_F(ReportMeasure, AQuickReportOfALampTakesPipelinesForLamps) {
    ReportArguments arguments;
    arguments.out = (folder_ / "out").string();
    arguments.quick = true;
    arguments.light = "spot";
    arguments.size = "48x32";
    arguments.seeds = arguments.rounds = 1;
    arguments.rays = 16;
    arguments.shots = {PENUMBRA_SOURCE_DIR "/scenes/lights/grating.shot.json"};
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = run_report(arguments);
    testing::internal::GetCapturedStdout();
    EXPECT_EQ(code, exit_good) << testing::internal::GetCapturedStderr();
    std::ifstream stream(folder_ / "out/results.json");
    const auto json = nlohmann::json::parse(stream);
    EXPECT_EQ(json["results"].size(), 3 + brute_force_rays.size() - 1);
}

TEST_F(ReportMeasure, MistakesAreFoundFirstAndLeaveNoPage) {
    ReportArguments arguments;
    arguments.out = (folder_ / "out").string();
    arguments.quick = true;
    const auto says = [&](const char* what) {
        testing::internal::CaptureStderr();
        EXPECT_EQ(run_report(arguments), exit_wrong);
        const std::string err = testing::internal::GetCapturedStderr();
        EXPECT_NE(err.find(what), std::string::npos) << err;
        EXPECT_FALSE(fs::exists(folder_ / "out/index.html"));
    };
    arguments.pipelines = {pipeline("denoise")};
    says("takes \"hits\", which only an engine can bring");
    arguments.pipelines = {pipeline("raw"), pipeline("raw")};
    says("is the name of");
    arguments.pipelines = {pipeline("raw")};
    arguments.shots = {"nowhere"};
    says("nowhere: no such file, and no shot of that name is shipped");
    arguments.light = "sun";
    says("--light: names a lamp of the shots");
    arguments.light.clear();

    // What is wrong with a shot's own text leaves an old page where it is.
    fs::create_directories(folder_ / "out");
    std::ofstream(folder_ / "out/index.html") << "an old page";
    const fs::path broken = folder_ / "broken.shot.json";
    std::ofstream(broken) << "{}";
    arguments.shots = {broken.string()};
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_report(arguments), exit_wrong);
    testing::internal::GetCapturedStderr();
    EXPECT_TRUE(fs::exists(folder_ / "out/index.html"));

    // An object that the scene does not have shows only when the scene is opened: by then an old page is
    // gone.
    const fs::path shot = folder_ / "wrong.shot.json";
    std::ifstream original(PENUMBRA_SOURCE_DIR "/scenes/colonnade.shot.json");
    auto json = nlohmann::json::parse(original);
    json["scene"] = PENUMBRA_SOURCE_DIR "/scenes/colonnade.glb";
    json["objects"] = {{"gatf", json["objects"]["gate"]}};
    std::ofstream(shot) << json;
    arguments.shots = {shot.string()};
    says("gatf");
}

}  // namespace
}  // namespace penumbra::report
