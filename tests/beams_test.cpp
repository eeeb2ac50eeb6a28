// SPDX-License-Identifier: MIT
// What beams remember from frame to frame: where nothing changes they prove what they proved, with fewer
// attempts; what becomes provable is found within a round of turns; a reset forgets. That rays' answers do
// not change is beams_rays_test's part.
#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t round_of_turns = 64;  // FAR_TURN in shaders/classification/beams.comp

class Beams : public GpuTest {
  protected:
    struct Frame {
        uint32_t listed, tried, decided;  // tiles, tiles, pixels
    };

    void open(const Shot& shot) {
        SessionOptions options;
        options.size = shot.size;
        options.jitter = false;
        options.captures = {"proved"};
        session_ = open_session(shipped_pipeline("many_rays"), shot, options);
    }

    Frame run(uint32_t frame, bool reset) {
        session_->run_frame(frame, reset);
        const auto classified = counters_of(session_->view(), "classify");
        const auto counted = counters_of(session_->view(), "beams");
        return {classified.at("tiles_listed"), counted.at("tiles_tried"),
                counted.at("lit") + counted.at("shadowed")};
    }

    // A bit per tile.
    std::vector<uint32_t> proved() const {
        const auto bytes = session_->view().captured("proved");
        std::vector<uint32_t> words(bytes.size() / 4);
        std::memcpy(words.data(), bytes.data(), bytes.size());
        return words;
    }

    std::unique_ptr<Session> session_;
};

// A plaza under a narrow sun, from which its block is taken away after frame `until`.
Shot plaza_with_block(double until) {
    Shot shot = plaza_shot({200, 120}, 3 * round_of_turns);
    shot.sun_angular_radius_deg = 0.25;
    shot.camera.resize(1);
    shot.sun.resize(1);
    shot.objects["block"].keys = {{until, {0, 0, 0}, {0, 0, 0}}, {until + 1, {0, -50, 0}, {0, 0, 0}}};
    return shot;
}

TEST_F(Beams, ProveAgainWhatTheyProvedWithFewerAttempts) {
    open(plaza_with_block(1000));
    const Frame first = run(0, true);
    EXPECT_EQ(first.tried, first.listed) << "nothing is known yet";
    EXPECT_GT(first.decided, 1000u);
    uint32_t attempts = 0;
    for (uint32_t frame = 1; frame <= round_of_turns; ++frame) {
        const Frame now = run(frame, false);
        EXPECT_LE(now.decided, first.decided) << frame;
        EXPECT_GE(now.decided, first.decided / 10 * 8)
            << frame << ": tiles alone among open ones may wait for their turn";
        attempts += now.tried;
    }
    EXPECT_LT(attempts, first.listed * round_of_turns / 10 * 9);
    const Frame again = run(round_of_turns + 1, true);
    EXPECT_EQ(again.tried, again.listed) << "a reset forgets";
}

// The naive form tries where it proved and nowhere else: what the block hid would be traced for ever.
TEST_F(Beams, FindWhatBecomesProvable) {
    open(plaza_with_block(2));
    run(0, true);
    run(1, false);
    run(2, false);
    run(3, false);
    const std::vector<uint32_t> at_once = proved();
    std::vector<uint32_t> found(at_once.size());
    for (uint32_t frame = 4; frame < 4 + round_of_turns; ++frame) {
        run(frame, false);
        const std::vector<uint32_t> now = proved();
        for (size_t i = 0; i < found.size(); ++i) found[i] |= now[i];
    }
    run(4 + round_of_turns, true);
    const std::vector<uint32_t> all = proved();
    uint32_t hidden = 0, never_found = 0;
    for (size_t i = 0; i < all.size(); ++i) {
        hidden += static_cast<uint32_t>(std::popcount(all[i] & ~at_once[i]));
        never_found += static_cast<uint32_t>(std::popcount(all[i] & ~found[i]));
    }
    EXPECT_GT(hidden, 0u) << "there is something to find; how much, depends on who shares a subgroup";
    EXPECT_EQ(never_found, 0u);
}

}  // namespace
}  // namespace penumbra::test
