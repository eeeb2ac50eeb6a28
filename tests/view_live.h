// SPDX-License-Identifier: MIT
// A view without its window, of the small scene of tests/test_scene.h.
#pragma once

#include <filesystem>
#include <fstream>

#include "app/view/live.h"
#include "tests/gpu_test.h"
#include "tests/test_folder.h"
#include "tests/test_scene.h"

namespace penumbra::viewer {

namespace fs = std::filesystem;

inline constexpr std::array<uint32_t, 2> size{96, 64};

class ViewLive : public test::GpuTest {
  protected:
    void SetUp() override {
        GpuTest::SetUp();
        fs::create_directories(folder_ / "nodes");
        shot_ = test::plaza_shot(size, 32);
    }
    Live live(const std::string& pipeline) {
        const fs::path shipped = fs::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (pipeline + ".json");
        StageWish wish;
        wish.pipeline = fs::exists(shipped) ? shipped.string() : pipeline;
        wish.size = size;
        if (!fs::is_empty(folder_ / "nodes")) wish.node_folders = {(folder_ / "nodes").string()};
        return Live(test::gpu(), shot_, wish);
    }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
        static int tick = 0;
        fs::last_write_time(folder_ / name, fs::file_time_type::clock::now() + std::chrono::seconds(++tick));
        return (folder_ / name).string();
    }
    static void run(Live& live, int frames) {
        for (int i = 0; i < frames; ++i) live.frame({}, 0);
    }

    test::TestFolder folder_;
    Shot shot_;
};

inline std::vector<uint8_t> rgba(Live& live, const char* resource) {
    live.show(resource);
    EXPECT_EQ(live.shown(), resource);
    return live.picture().rgba;
}

}  // namespace penumbra::viewer
