// SPDX-License-Identifier: MIT
// What the tests of shadow maps' proofs share: the classifiers before undenoised rays, where a pixel's
// verdict can be seen, scenes for them, and the frames that two of them differ in.
#pragma once

#include "tests/hard_cases/hard_cases.h"

namespace penumbra::test {

inline constexpr const char *cascades_raw = "../tests/pipelines/cascades_raw",
                            *taps_raw = "../tests/pipelines/taps_raw";  // as published

inline Shot shadow_shot(const char* key, const std::vector<Placed>& shapes, std::array<uint32_t, 2> size) {
    Shot shot = scene_shot(key, shapes, size);
    shot.camera = {{0, {0.5, 1.6, 4}, {0, 0.4, 0}, {0, 1, 0}}};
    shot.sun = {{0, {0.5, 0.8, 0.3}}};
    shot.sun_angular_radius_deg = 0.27;
    return shot;
}

// Wires of 6 mm over a floor.
inline Shot wires() {
    return shadow_shot("cascade_wires",
                       {{"floor", ground(8, 8, 4, 4)},
                        {"low", rod({-2, 0.3, 0}, {2, 0.4, 0.3}, 0.003, 6)},
                        {"high", rod({-2, 1.1, 0.4}, {2, 0.9, -0.6}, 0.003, 6)},
                        {"post", rod({0.3, 0, 0.2}, {0.3, 1.2, 0.2}, 0.003, 6)}},
                       {240, 136});
}

inline RunOptions maps_of(uint32_t size, std::vector<std::string> settings = {}) {
    return {.settings = std::move(settings), .cascade_size = size};
}

struct Frames {
    std::vector<std::vector<float>> visibility;
    uint64_t rays = 0;  // of the node "trace"
};

inline Frames frames_of(const std::string& pipeline, const Shot& shot, const RunOptions& options,
                        uint32_t count, uint32_t cut = 0) {
    ShotRun run(pipeline, shot, options);
    Frames frames;
    for (uint32_t i = 0; i < count; ++i) {
        frames.visibility.push_back(run.frame(i, i == 0 || i == cut));
        const auto counters = counters_of(run.session().view(), "trace");
        if (counters.contains("rays")) frames.rays += counters.at("rays");
    }
    return frames;
}

// Pixels of all frames.
inline size_t differing(const Frames& a, const Frames& b) {
    size_t count = 0;
    for (size_t f = 0; f < a.visibility.size(); ++f)
        for (size_t i = 0; i < a.visibility[f].size(); ++i) count += a.visibility[f][i] != b.visibility[f][i];
    return count;
}

}  // namespace penumbra::test
