// SPDX-License-Identifier: MIT
// What `penumbra gates --signal` says of rays that nobody denoises is known beforehand.
#include "app/gates/radiance_gates.h"

#include <tuple>

#include "app/radiance_truth.h"
#include "app/signal_pipeline.h"
#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"

namespace penumbra::test {
namespace {

class RadianceGates : public GpuTest {
  protected:
    CheckedPipeline pipeline(const std::string& name, const std::string& signal,
                             const std::vector<std::string>& settings = {}) {
        auto checked = signal_pipeline(PENUMBRA_SOURCE_DIR "/pipelines/" + name + ".json", signal, settings,
                                       nodes_, diagnostics_);
        if (!checked) throw std::runtime_error(diagnostics_.text());
        return *checked;
    }
    gates::RadianceBench bench(const CheckedPipeline& pipeline, const std::string& signal) {
        return {gpu(), nodes_, pipeline, signal, study_, scenes_, diagnostics_, warnings_};
    }
    RadianceGates() {
        study_.size = {64, 36};
        study_.seeds = 2;
        study_.rays = 256;
        study_.after = {1, 3};
        study_.moving_frames = 3;
    }

    NodeSet nodes_ = shadow_nodes();
    Diagnostics diagnostics_;
    std::vector<std::string> warnings_;
    gates::RadianceStudy study_;
    gates::RadianceScenes scenes_;
};

TEST_F(RadianceGates, RaysAloneAreOneRayAndForgetAtOnce) {
    const CheckedPipeline raw = pipeline("raw_indirect", "diffuse");
    const auto furnace = gates::measure_furnace(bench(raw, "diffuse"));
    const auto still = gates::measure_still(bench(raw, "diffuse"));
    const auto moving = gates::measure_moving(bench(raw, "diffuse"));
    const auto left = gates::measure_lamp_off(bench(raw, "diffuse"));
    ASSERT_TRUE(furnace && still && moving && left) << diagnostics_.text();
    EXPECT_LT(furnace->back(), 1e-3);
    EXPECT_NEAR(*still->back().n_eff(), 1, 0.2);
    EXPECT_NEAR(*moving->n_eff(), 1, 0.2);
    EXPECT_NEAR(*still->back().bias(), 0, 0.05);
    EXPECT_GT(*still->back().flicker(), 0.3) << "noise that is new in every frame";
    for (const double share : *left) EXPECT_NEAR(share, 0, 0.1);
}

// A class of roughness per strip, and each is seen; metal of roughness .8 is worse off with single rays than
// with sixteen by about that.
TEST_F(RadianceGates, SixteenRaysAreWorthAboutAsMany) {
    const CheckedPipeline one = pipeline("raw_reflections", "specular"),
                          many = pipeline("raw_reflections", "specular",
                                          {"nodes.rays.params.rays_per_pixel=16"});
    const auto by_one = gates::measure_still(bench(one, "specular")),
               by_many = gates::measure_still(bench(many, "specular"));
    ASSERT_TRUE(by_one && by_many) << diagnostics_.text();
    for (size_t c = 0; c < roughness_classes; ++c) EXPECT_GT(by_one->back().classes[c].pixels, 100u) << c;
    for (size_t c = 1; c < roughness_classes; ++c) {
        const double gain = *by_many->back().n_eff(c) / *by_one->back().n_eff(c);
        EXPECT_GT(gain, 8) << c;
        EXPECT_LT(gain, 128) << c << ": they are spread evenly, which is worth 16^1.6";
    }
    const auto furnace = gates::measure_furnace(bench(many, "specular"));
    ASSERT_TRUE(furnace);
    for (const double off : *furnace) EXPECT_LT(off, 1e-3);
}

// What denoises remembers the lamp: more than rays do, less with time.
TEST_F(RadianceGates, AMemoryIsSeenToFade) {
    study_.seeds = 1;
    const auto left = gates::measure_lamp_off(bench(pipeline("reflections", "specular"), "specular"));
    ASSERT_TRUE(left) << diagnostics_.text();
    EXPECT_GT(left->front(), 0.02);
    EXPECT_LT(left->back(), 0.5 * left->front());
}

// Half of what is reached, about: 199 and 77 rays (55 and 35 without the density of a neighbour's ray here),
// .01 of the lamp after eight frames (.03 and .16 where 5x5 pixels alone judge a past).
TEST_F(RadianceGates, OursAreWorthManyRaysAndForgetALamp) {
    study_.after = {4, 16};
    study_.after_off = {4, 8};
    for (const auto& [name, signal, rays, left_of_lamp] :
         {std::tuple{"reflections", "specular", 110, 0.02}, {"indirect", "diffuse", 50, 0.05}}) {
        SCOPED_TRACE(name);
        const auto ours = pipeline(name, signal);
        const auto still = gates::measure_still(bench(ours, signal));
        const auto left = gates::measure_lamp_off(bench(ours, signal));
        ASSERT_TRUE(still && left) << diagnostics_.text();
        EXPECT_GT(*still->back().n_eff(), rays);
        EXPECT_LT(left->back(), left_of_lamp);
    }
}

// In motion a lone bright sample, which shows no variance, is no reason to cast out a past: 7 rays of the
// narrowest lobes, else none. Nor has the surface's past precedence over the image's: 929 rays between .3 and
// .5, else 818.
TEST_F(RadianceGates, InMotionALoneSampleIsNotBelieved) {
    study_.size = {160, 90};
    study_.seeds = 3;
    study_.moving_frames = 17;
    const auto moving = gates::measure_moving(bench(pipeline("reflections", "specular"), "specular"));
    ASSERT_TRUE(moving) << diagnostics_.text();
    EXPECT_GT(*moving->n_eff(0), 1);
    EXPECT_GT(*moving->n_eff(3), 870);
}

// What a mirror of little roughness shows is found where its image was; without that 2 rays are left of 16.
// The variance of what a level has filtered is less than that of its pixels: else 18 of 34.
TEST_F(RadianceGates, ABaselineIsAStrongOne) {
    const auto relax = pipeline("relax", "specular");
    study_.after = {16};
    study_.moving_frames = 8;
    const auto still = gates::measure_still(bench(relax, "specular"));
    const auto moving = gates::measure_moving(bench(relax, "specular"));
    ASSERT_TRUE(still && moving) << diagnostics_.text();
    EXPECT_GT(*still->back().n_eff(), 26);
    EXPECT_GT(*moving->n_eff(1), 8);
}

}  // namespace
}  // namespace penumbra::test
