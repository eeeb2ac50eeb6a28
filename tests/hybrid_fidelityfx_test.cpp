// SPDX-License-Identifier: MIT
// The original dataflow whole: the published classifier spares the published denoiser rays. What it leaves is
// cast as without it, and along a straight edge, where the maps are right, so is what the denoiser makes of
// it.
#include <bit>

#include "tests/hard_cases/hard_cases.h"

namespace penumbra::test {
namespace {

class HybridFidelityFx : public GpuTest {};

uint32_t rays_of(const ShotRun& run) {
    return counters_of(run.session().view(), "trace").at("rays");
}

TEST_F(HybridFidelityFx, IsWorthWhatTheDenoiserIsWithoutTheClassifier) {
    const Shot shot = edge_shot(16, 20, {160, 90});
    const std::vector<float> truth = truth_of(shot, 31, 256).visibility;
    ShotRun all("fidelityfx", shot), hybrid("hybrid_fidelityfx", shot, {.cascade_size = 512});
    const double without = n_eff(all.up_to(31), truth), with = n_eff(hybrid.up_to(31), truth);
    figure("N_eff of the published denoiser (naive), with the published classifier (ours)", without, with);
    EXPECT_GT(with, 0.8 * without);
    EXPECT_LT(with, 1.25 * without);
    EXPECT_LT(rays_of(hybrid), rays_of(all) * 3 / 4);
    EXPECT_GT(rays_of(hybrid), rays_of(all) / 4);
}

// What its words say of the pixels without a ray stands in the ray-hit words, and the others have their rays:
// those of fidelityfx.json, in a shot where no caster is thin.
TEST_F(HybridFidelityFx, CastsTheRaysThatTheClassifierLeaves) {
    const Shot shot = edge_shot(16, 20, {160, 90});
    const RunOptions options{.settings = {"nodes.taps.out.undecided_words=undecided_words"},
                             .captures = {"undecided_words", "preloaded_hits", "hits"},
                             .cascade_size = 512};
    ShotRun all("fidelityfx", shot, {.captures = {"hits"}}), hybrid("hybrid_fidelityfx", shot, options);
    all.frame(0, true);
    hybrid.frame(0, true);
    const auto words = [](const ShotRun& run, const char* name) {
        return captured<uint32_t>(run.session().view(), name);
    };
    const auto whole = words(all, "hits"), hits = words(hybrid, "hits"),
               open = words(hybrid, "undecided_words"), preloaded = words(hybrid, "preloaded_hits");
    uint32_t cast = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
        cast += static_cast<uint32_t>(std::popcount(open[i]));
        EXPECT_EQ(preloaded[i] & open[i], 0u);
        EXPECT_EQ(hits[i] & ~open[i], preloaded[i] & ~open[i]);
        EXPECT_EQ(hits[i] & open[i], whole[i] & open[i]);
    }
    EXPECT_EQ(cast, rays_of(hybrid));
    EXPECT_GT(cast, 0u);
}

}  // namespace
}  // namespace penumbra::test
