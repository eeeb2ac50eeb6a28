// SPDX-License-Identifier: MIT
// What the previous frame has seen amid light is not asked again where neither the sun nor a caster moves:
// the image is the one that asks everybody, everybody has a turn, and a cut forgets.
#include <bit>
#include <cmath>
#include <map>

#include "tests/gpu_test.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

class Recall : public GpuTest {};

constexpr std::array<uint32_t, 2> size{192, 108};

// Tiles by number, with the pixels that a list asks for.
std::map<uint32_t, uint32_t> asked(const ShotRun& run, const std::string& list, const std::string& args) {
    const auto records = run.words(list);
    std::map<uint32_t, uint32_t> tiles;
    for (uint32_t i = 0; i < run.words(args).at(3); ++i)
        tiles[records.at(4 * i) & 0x3fff1fffu] |= records.at(4 * i + 1);
    return tiles;
}

size_t pixels_of(const std::map<uint32_t, uint32_t>& tiles) {
    size_t n = 0;
    for (const auto& [tile, pixels] : tiles) n += size_t(std::popcount(pixels));
    return n;
}

// A camera that steps aside and back: what the engine's parts uncover, wider than a tile, was not seen
// before.
Shot stepping_aside() {
    Shot shot = shot_named("engine", size);
    const CameraKey first = shot.camera.at(0);
    const glm::dvec3 aside = 0.3 * glm::length(first.target - first.position) *
                             glm::normalize(glm::cross(first.target - first.position, first.up));
    shot.camera.clear();
    for (uint32_t frame = 0; frame < 12; ++frame) {
        CameraKey key = first;
        key.frame = frame;
        if (frame % 2 == 1) key.position += aside;
        if (frame % 2 == 1) key.target += aside;
        shot.camera.push_back(key);
    }
    return shot;
}

const std::vector<std::string> lists = {"unproved", "unproved_args", "candidates", "candidate_args"};

TEST_F(Recall, ChangesWhoIsAskedAndNotTheImage) {
    const std::pair<const char*, Shot> shots[] = {{"trees", shot_named("trees", size)},
                                                  {"heightfield", shot_named("heightfield", size)},
                                                  {"cards", shot_named("cards", size)},
                                                  {"stepping aside", stepping_aside()}};
    for (const auto& [name, shot] : shots) {
        SCOPED_TRACE(name);
        ShotRun some("hybrid_shadows_fast", shot, {{}, lists});
        ShotRun all("hybrid_shadows_fast", shot, {{"nodes.recall.params.turn=1"}, lists});
        size_t differ = 0, spared = 0, listed = 0;
        for (uint32_t frame = 0; frame < 12; ++frame) {
            const bool cut = frame == 0 || frame == 8;
            const auto is = some.frame(frame, cut), should_be = all.frame(frame, cut);
            if (cut) {
                EXPECT_EQ(asked(some, "candidates", "candidate_args"),
                          asked(some, "unproved", "unproved_args"));
            }
            for (size_t i = 0; i < is.size(); ++i) differ += is[i] != should_be[i];
            listed += pixels_of(asked(some, "unproved", "unproved_args"));
            spared += pixels_of(asked(some, "unproved", "unproved_args")) -
                      pixels_of(asked(some, "candidates", "candidate_args"));
            EXPECT_EQ(asked(all, "candidates", "candidate_args"), asked(all, "unproved", "unproved_args"));
        }
        RecordProperty(std::string(name) + "_differ", std::to_string(differ));
        RecordProperty(std::string(name) + "_spared", std::to_string(double(spared) / double(listed)));
        EXPECT_LE(differ, 2u) << "of a quarter of a million pixels";
        EXPECT_GE(spared, listed / 20);
    }
}

// Standing still all that is lit for certain is asked once in `turn` frames, and in the frame after a cut.
TEST_F(Recall, EverybodyHasATurn) {
    Shot shot = shot_named("trees", size);
    shot.camera.resize(1);
    ShotRun run("hybrid_shadows_fast", shot, {{"nodes.recall.params.turn=4"}, lists});
    std::map<uint32_t, uint32_t> listed, met;
    for (uint32_t frame = 0; frame < 8; ++frame) {
        run.frame(frame, frame == 0);
        listed = asked(run, "unproved", "unproved_args");
        if (frame < 4) continue;
        EXPECT_LT(pixels_of(asked(run, "candidates", "candidate_args")), pixels_of(listed));
        for (const auto& [tile, pixels] : asked(run, "candidates", "candidate_args")) met[tile] |= pixels;
    }
    for (const auto& [tile, pixels] : listed) EXPECT_EQ(met[tile] & pixels, pixels) << tile;
    run.frame(8, true);
    EXPECT_EQ(asked(run, "candidates", "candidate_args"), asked(run, "unproved", "unproved_args"));
}

}  // namespace
}  // namespace penumbra::test
