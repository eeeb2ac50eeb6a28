// SPDX-License-Identifier: MIT
// Nodes put out the same however a device groups lanes: with the shapes of either class, with a subgroup per
// tile, as on a CPU, with several that share one, and with subgroups of another size. What is decided per
// tile must not be decided per subgroup.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>

#include "app/session.h"
#include "penumbra/shadow_nodes.h"
#include "tests/cli_run.h"
#include "tests/gpu_test.h"
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

using Frames = std::vector<std::vector<std::byte>>;

// `width`: lanes of a workgroup of trace and cover; 0: as shipped for the device.
Frames run(const Case& c, const Shot& shot, uint32_t width, std::optional<bool> cpu = {}) {
    NodeSet nodes = shadow_nodes();
    for (const char* name : {"trace", "cover"}) {
        NodeEntry entry = *nodes.find(name);
        if (width == 0) continue;
        entry.type.cpu.group = entry.type.gpu.group = std::array{width, 1u, 1u};
        nodes.add(std::move(entry));
    }
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto pipeline =
        load_pipeline(root / "pipelines" / (std::string(c.pipeline) + ".json"), c.settings, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    SessionOptions options;
    options.size = shot.size;
    options.optimum = false;
    options.cpu = cpu;
    options.captures = c.captures;
    options.captures.emplace_back("visibility");
    const auto session = Session::open(gpu(), nodes, *checked, shot, options, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    Frames frames;
    for (uint32_t frame = 0; frame < 3; ++frame) {
        session->run_frame(frame, frame == 0);
        for (const std::string& name : options.captures) {
            const auto bytes = session->view().captured(name);
            frames.emplace_back(bytes.begin(), bytes.end());
        }
    }
    return frames;
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
        const Frames shipped = run(c, shot, 0);
        for (const uint32_t width : {8u, 16u, 32u})
            EXPECT_TRUE(run(c, shot, width) == shipped) << c.pipeline << ", workgroups of " << width;
    }
}

// A GPU's shapes on a CPU device: another number of pixels for each lane, branches that are no loops, stacks
// in shared memory. What a compiler fuses depends on the code around it, so `color` may be rounded another
// way, which its history keeps: a step of a half a frame.
TEST_F(Lanes, ADevicesClassDoesNotShow) {
    const Shot shot = plaza_shot({203, 117}, 4);
    const Case all{"hybrid_shadows", {}, {"hits", "coverage", "lit", "color"}};
    const size_t color = 3;
    const Frames gpu = run(all, shot, 0, false), cpu = run(all, shot, 0, true);
    ASSERT_EQ(gpu.size(), cpu.size());
    for (size_t i = 0; i < gpu.size(); ++i) {
        const size_t images = all.captures.size() + 1, image = i % images;
        const auto frame = static_cast<int>(i / images);
        if (image != color || frame == 0) {
            EXPECT_TRUE(gpu[i] == cpu[i]) << "image " << image << " of frame " << frame;
            continue;
        }
        ASSERT_EQ(gpu[i].size(), cpu[i].size());
        std::vector<int16_t> a(gpu[i].size() / 2), b(a.size());  // halves that are not negative: in order
        std::memcpy(a.data(), gpu[i].data(), gpu[i].size());
        std::memcpy(b.data(), cpu[i].data(), cpu[i].size());
        int worst = 0;
        for (size_t k = 0; k < a.size(); ++k) worst = std::max(worst, std::abs(a[k] - b[k]));
        EXPECT_LE(worst, frame);
    }
}

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
