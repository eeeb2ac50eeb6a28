// SPDX-License-Identifier: MIT
// Masks that a still camera's earlier frames have made are taken over, and no bit of any image changes by it:
// whatever moves, rests, comes, goes, is hidden from the camera or left to rays.
#include <algorithm>

#include "tests/gpu_test.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

class Reuse : public GpuTest {};

constexpr std::array<uint32_t, 2> size{128, 72};
constexpr uint32_t reused = 1;  // REUSED of shaders/common/reuse_words.glsl

Shot still_camera(const char* name) {
    Shot shot = shot_named(name, size);
    shot.camera.resize(1);
    return shot;
}

// The colonnade's gate, which closes between two frames and rests before and after.
Shot gate_closing(double from, double to) {
    Shot shot = still_camera("colonnade");
    std::vector<ObjectKey>& keys = shot.objects.at("gate").keys;
    keys = {keys.front(), keys.back()};
    keys[0].frame = from;
    keys[1].frame = to;
    return shot;
}

// Brought where the camera moves, too.
const std::vector<std::string> whatever_the_camera_does{
    "inputs.moved_boxes.optional=false",
    R"(nodes.reuse={ "type": "reuse", "if": "sun_disc & tree", "in": { "decided_hits": "facing_hits", "whole_masks_prev": "whole_masks@-1" } })",
    R"(nodes.retain={ "type": "retain", "if": "sun_disc & tree", "in": { "whole_masks_prev": "whole_masks@-1" } })"};

// A shot with and without reuse, frame by frame. What was whole in a tile's first try may be kept where
// without it the tile is given up, since it was in the frame before: that alone may differ, and is the better
// for it.
class Pair {
  public:
    Pair(const Shot& shot, std::vector<std::string> settings = {})
        : with_("hybrid_shadows", shot,
                {.settings = with(settings, whatever_the_camera_does),
                 .captures = {"reuse_words", "candidate_args"},
                 .jitter = true}),
          without_("hybrid_shadows", shot,
                   {.settings =
                        with(settings, {"nodes.reuse=null", "nodes.retain=null", "inputs.moved_boxes=null"}),
                    .captures = {"given_up", "candidate_args"},
                    .jitter = true}) {}
    void set_jitter(bool wanted) {
        with_.session().set_jitter(wanted);
        without_.session().set_jitter(wanted);
    }
    // Tiles that were reused.
    size_t frame(uint32_t index, bool reset = false) {
        const auto is = with_.frame(index, reset), should_be = without_.frame(index, reset);
        const auto given_up = without_.words("given_up");
        size_t differ = 0;
        for (size_t i = 0; i < is.size(); ++i) {
            const size_t tile_x = i % size[0] / 8, tile_y = i / size[0] / 4;
            const bool by_rays =
                given_up.at(tile_y * ((size[0] / 8 + 31) / 32) + tile_x / 32) >> tile_x % 32 & 1;
            differ += is[i] != should_be[i] && !by_rays;
        }
        EXPECT_EQ(differ, 0u) << "pixels of frame " << index;
        const auto words = with_.words("reuse_words");
        return static_cast<size_t>(std::ranges::count(words, reused));
    }
    // Of the last frame, tiles that were covered, of those that are without reuse.
    double share_covered() const {
        return double(with_.words("candidate_args").at(3)) / double(without_.words("candidate_args").at(3));
    }
    // The most tiles that were reused in one of the frames.
    size_t frames(uint32_t first, uint32_t last) {
        size_t most = 0;
        for (uint32_t i = first; i <= last; ++i) most = std::max(most, frame(i, i == 0));
        return most;
    }

  private:
    static std::vector<std::string> with(std::vector<std::string> settings,
                                         const std::vector<std::string>& more) {
        settings.insert(settings.end(), more.begin(), more.end());
        return settings;
    }
    ShotRun with_, without_;
};

TEST_F(Reuse, WhatMovesChangesNoBit) {
    for (const char* name : {"colonnade", "lamp"}) {
        SCOPED_TRACE(name);
        Pair pair(still_camera(name));
        EXPECT_EQ(pair.frames(0, 15), 0u) << "no frame had this jitter before";
        EXPECT_GT(pair.frames(16, 40), 40u);
    }
}

// What rests has no box, and what was seen of it and of its shadow is kept; then it moves.
TEST_F(Reuse, WhatBeginsToMoveAndComesToRestChangesNoBit) {
    Pair pair(gate_closing(20, 24));
    pair.frames(0, 19);
    const size_t moving = pair.frames(20, 25);
    EXPECT_GT(moving, 40u);
    EXPECT_GT(pair.frames(26, 48), moving);
}

TEST_F(Reuse, WhatMovesWhileTheCameraLooksElsewhereChangesNoBit) {
    Shot shot = gate_closing(20, 21);
    CameraKey here = shot.camera.at(0), there = here;
    there.position += glm::dvec3(0.5, 0, 0.25);
    there.target += glm::dvec3(0.5, 0, 0.25);
    shot.camera.clear();
    const auto stay = [&](CameraKey key, double from, double to) {
        for (const double frame : {from, to}) {
            key.frame = frame;
            shot.camera.push_back(key);
        }
    };
    stay(here, 0, 19);
    stay(there, 20, 21);
    stay(here, 22, 60);
    Pair pair(shot);
    EXPECT_GT(pair.frames(0, 19), 40u);
    EXPECT_EQ(pair.frames(20, 37), 0u);
    EXPECT_GT(pair.frames(38, 44), 40u);
}

// Tiles that were proved as a whole, and reused since, are proved again in the first frame that finds them
// anew.
TEST_F(Reuse, WhatWasProvedIsRememberedWhileItIsReused) {
    Shot shot = still_camera("colonnade");
    CameraKey key = shot.camera.at(0);
    key.frame = 24;
    shot.camera.push_back(key);
    key.frame = 25;
    key.position.x += 0.01;
    shot.camera.push_back(key);
    Pair pair(shot);
    EXPECT_GT(pair.frames(0, 24), 40u);
    EXPECT_EQ(pair.frame(25), 0u);
    EXPECT_LT(pair.share_covered(), 1.05);
}

// Frames that nobody renders move things, too, and need not turn the jitter by one.
TEST_F(Reuse, AFrameThatIsLeftOutChangesNoBit) {
    Pair pair(still_camera("colonnade"));
    pair.frames(0, 20);
    EXPECT_GT(pair.frame(37), 0u);
    pair.frames(38, 40);
}

TEST_F(Reuse, AnotherJitterChangesNoBit) {
    Pair pair(still_camera("trees"));
    EXPECT_GT(pair.frames(0, 17), 40u);
    pair.set_jitter(false);
    EXPECT_EQ(pair.frames(18, 33), 0u);
    EXPECT_GT(pair.frames(34, 36), 40u);
}

// Rays have another noise in every frame.
TEST_F(Reuse, WhatIsLeftToRaysIsNotKept) {
    Pair pair(still_camera("trees"), {"nodes.cover.params.budget=24"});
    EXPECT_GT(pair.frames(0, 20), 40u);
}

TEST_F(Reuse, ACutForgets) {
    Pair pair(still_camera("trees"));
    EXPECT_GT(pair.frames(0, 17), 40u);
    EXPECT_LT(pair.share_covered(), 0.1);
    EXPECT_EQ(pair.frame(18, true), 0u);
    EXPECT_EQ(pair.frames(19, 34), 0u);
    EXPECT_GT(pair.frame(35), 40u);
}

}  // namespace
}  // namespace penumbra::test
