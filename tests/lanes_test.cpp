// SPDX-License-Identifier: MIT
// Nodes put out the same however a device groups lanes: with the shapes of either class of device, with a
// subgroup per tile, as on a CPU, with several that share one, and with subgroups of another size. What is
// decided per tile must not be decided per subgroup.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>

#include "app/session.h"
#include "penumbra/shadow_nodes.h"
#include "tests/cli_run.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;

struct Case {
    const char* pipeline;
    std::vector<std::string> settings;
    std::vector<std::string> captures;  // besides the outputs
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.pipeline;
}

struct Images {
    std::vector<std::string> names;                // of a frame's images
    std::vector<std::vector<std::byte>> frames;    // images, frame by frame
    std::vector<std::vector<uint32_t>> constants;  // of the passes
};

// `width`: lanes of a workgroup of trace and cover; 0: as shipped for the device.
Images run(const Case& c, const Shot& shot, uint32_t width, std::optional<bool> cpu = {}) {
    NodeSet nodes = shadow_nodes();
    for (const char* name : {"trace", "cover"}) {
        NodeEntry entry = *nodes.find(name);
        if (width == 0) continue;
        entry.type.cpu.group = entry.type.gpu.group = std::array{width, 1u, 1u};
        nodes.add(std::move(entry));
    }
    const CheckedPipeline checked = shipped_pipeline(c.pipeline, c.settings, nodes);
    SessionOptions options;
    options.size = shot.size;
    options.cpu = cpu;
    options.captures = c.captures;
    for (const std::string& output : checked.output_names())
        if (std::ranges::find(options.captures, output) == options.captures.end())
            options.captures.push_back(output);
    const auto session = open_session(checked, shot, options, nodes);
    Images result{.names = options.captures};
    for (const PlanPass& pass : session->plan().passes) result.constants.push_back(pass.constants);
    for (uint32_t frame = 0; frame < 3; ++frame) {
        session->run_frame(frame, frame == 0);
        for (const std::string& name : options.captures) {
            const auto bytes = session->view().captured(name);
            result.frames.emplace_back(bytes.begin(), bytes.end());
        }
    }
    return result;
}

class Lanes : public GpuTest {};

// Few pixels of a tile need rays, so that how they are shared out matters; sizes that leave half tiles.
TEST_F(Lanes, HowADeviceGroupsThemDoesNotShow) {
    const Shot shot = plaza_shot({203, 117}, 3);
    for (const Case& c : {Case{"shadows", {}, {"hits", "blockers"}}, Case{"raw", {}, {"hits"}},
                          Case{"raw", {"nodes.trace.params.rays_per_pixel=5"}, {"hits", "fraction"}},
                          Case{"hybrid_shadows",
                               {"nodes.cover.params.budget=16"},
                               {"hits", "coverage", "fraction", "given_up"}}}) {
        const auto shipped = run(c, shot, 0).frames;
        for (const uint32_t width : {8u, 16u, 32u})
            EXPECT_TRUE(run(c, shot, width).frames == shipped) << c.pipeline << ", workgroups of " << width;
    }
}

// By how many steps two images of halves that are not negative, whose words are in their order, differ at
// most.
int steps_between(const std::vector<std::byte>& a, const std::vector<std::byte>& b) {
    std::vector<int16_t> x(a.size() / 2), y(x.size());
    std::memcpy(x.data(), a.data(), a.size());
    std::memcpy(y.data(), b.data(), a.size());
    int worst = 0;
    for (size_t k = 0; k < x.size(); ++k) worst = std::max(worst, std::abs(x[k] - y[k]));
    return worst;
}

// What gather hands on of cells with work, those whose stored word is 0; of the others it says no more than
// that word.
std::vector<std::byte> of_working(std::vector<std::byte> cells, const std::vector<std::byte>& idle_cells) {
    constexpr size_t word = sizeof(uint32_t), cell = 8 * sizeof(float);
    for (size_t c = 0; c < idle_cells.size() / word; ++c) {
        uint32_t stored = 0;
        std::memcpy(&stored, idle_cells.data() + word * c, word);
        if (stored != 0) std::fill_n(cells.data() + cell * c, cell, std::byte{});
    }
    return cells;
}

// A GPU's shapes on a CPU device: another number of pixels for each lane, branches that are no loops, stacks
// in shared memory, a leaf's planes decided before its lines. Both trace in our tree: a GPU that has ray
// queries would take those, whose first hit of several is another. What a compiler fuses depends on the code
// around it, so `color` may be rounded another way, which its history keeps: two steps of a half a frame.
void expect_same_of_either_class(const Case& c, const Shot& shot) {
    const Images gpu = run(c, shot, 0, false), cpu = run(c, shot, 0, true);
    EXPECT_NE(gpu.constants, cpu.constants) << "both are of the same class";
    ASSERT_EQ(gpu.frames.size(), cpu.frames.size());
    for (size_t i = 0; i < gpu.frames.size(); ++i) {
        const auto &a = gpu.frames[i], &b = cpu.frames[i];
        const auto frame = static_cast<int>(i / cpu.names.size());
        const std::string& name = cpu.names[i % cpu.names.size()];
        if (name == "color" && a.size() == b.size()) {
            EXPECT_LE(steps_between(a, b), 2 * frame);
        } else if (name == "cells") {
            EXPECT_TRUE(of_working(a, gpu.frames[i - 1]) == of_working(b, cpu.frames[i - 1]))
                << name << " of frame " << frame;
        } else {
            EXPECT_TRUE(a == b) << name << " of frame " << frame;
        }
    }
}

class DeviceClass : public GpuTest, public ::testing::WithParamInterface<Case> {};

TEST_P(DeviceClass, DoesNotShow) {
    // Of a size at which no ray lies within rounding of an edge, where it is the compiler who says.
    expect_same_of_either_class(GetParam(), plaza_shot({197, 117}, 3));
}

const std::string by_tree = "nodes.trace.params.backend=bvh";

// Its light ends within the picture: workgroups of either shape have tiles with work beside tiles without.
TEST_F(Lanes, ALampsReachDoesNotShowInWhoWorksTogether) {
    Shot shot = plaza_shot({203, 117}, 3);
    shot.lights.at("lamp").range = 3.4;
    expect_same_of_either_class({"light_shadows", {by_tree}, {"hits", "ray_bits", "idle_cells", "lit"}},
                                shot);
}

INSTANTIATE_TEST_SUITE_P(
    Of, DeviceClass,
    ::testing::Values(
        Case{"hybrid_shadows", {by_tree}, {"hits", "coverage", "lit", "color"}},
        Case{"shadows", {by_tree}, {"hits", "blockers", "ray_bits", "idle_cells", "cells", "lit", "color"}},
        Case{"light_shadows", {by_tree}, {"hits", "blockers", "idle_cells", "cells", "lit"}},
        Case{"hybrid_fidelityfx", {by_tree}, {"hits", "color"}},
        Case{"light", {by_tree}, {"hits", "coverage", "lit"}}, Case{"lights", {}, {"masks", "lit"}}),
    [](const auto& test) { return std::string(test.param.pipeline); });

// Mesa's CPU device takes its subgroups' size from the environment. Its cache of compiled shaders knows
// nothing of it and would hand out those of another size.
class SubgroupsOf : public Cli {};

TEST_F(SubgroupsOf, FourAndOfEightGiveTheSameBits) {
    if (gpu().info().driver.find("llvmpipe") == std::string::npos)
        GTEST_SKIP() << "sizes of Mesa's CPU device";
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
    for (const char* pipeline : {"shadows", "hybrid_shadows"}) {
        std::map<std::string, std::string> images[2];
        for (const int bits : {128, 256}) {
            setenv("LP_NATIVE_VECTOR_WIDTH", std::to_string(bits).c_str(), 1);
            const Result devices = run("devices");
            ASSERT_NE(devices.out.find("subgroup " + std::to_string(bits / 32)), std::string::npos)
                << devices.out;
            const fs::path out = folder_ / (pipeline + std::to_string(bits));
            const std::string blockers = pipeline == std::string("shadows") ? ",blockers" : ",coverage";
            const Result result =
                run("render pipelines/" + std::string(pipeline) +
                    ".json --shot scenes/lamp.shot.json --size 100x60 --frames 0..2 --capture hits" +
                    blockers + " --out '" + out.string() + "'");
            ASSERT_EQ(result.code, 0) << result.err;
            for (const auto& entry : fs::directory_iterator(out))
                if (entry.path().extension() == ".exr")
                    images[bits == 256][entry.path().filename().string()] = read_file(entry.path());
        }
        EXPECT_EQ(images[0].size(), 3u * 4u);
        EXPECT_TRUE(images[0] == images[1]) << pipeline;
    }
    unsetenv("LP_NATIVE_VECTOR_WIDTH");
    unsetenv("MESA_SHADER_CACHE_DISABLE");
}

}  // namespace
}  // namespace penumbra::test
