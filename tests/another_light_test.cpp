// SPDX-License-Identifier: MIT
// The last frame's light was another one, or is not known: what its rays said is believed as far as it is the
// same light.
#include <algorithm>
#include <cmath>

#include "tests/gpu_test.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

double rms_difference(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return std::sqrt(sum / double(a.size()));
}

class AnotherLight : public GpuTest {};

// After a jump of the sun rays go where a frame without a past would send them: 1.5 times its error where
// they go where the old sun's shadows were.
TEST_F(AnotherLight, RaysAreNotAllottedByWhatTheSunOfBeforeShowed) {
    constexpr uint32_t jump = 10;
    Shot shot = shot_named("colonnade");
    shot.camera.resize(1);
    shot.objects.clear();
    shot.sun = {{jump - 1.0, {-0.4, 0.7, 0.5}}, {double(jump), {0.75, 0.62, -0.25}}};
    ShotRun run(shot, "shadows", {}, {}), cold(shot, "shadows", {}, {}), exact(shot, "covered", {}, {});
    for (uint32_t f = 0; f <= jump; ++f) run.frame(f, f == 0);
    cold.frame(jump, true);
    exact.frame(jump, true);
    const double without = rms_difference(cold.visibility(), exact.visibility());
    EXPECT_GT(without, 0.02);
    EXPECT_LT(rms_difference(run.visibility(), exact.visibility()), 1.3 * without);
}

// Who brings the sun's past with a lamp and not the lamp's has said nothing of the lamp's.
TEST_F(AnotherLight, ALampsPastIsNotTheSuns) {
    const Shot shot = shot_named("lights/grating");
    ShotRun with(shot, "one_ray", {"inputs.light={}"}, {}),
        without(shot, "one_ray", {"inputs.light={}", "inputs.sun_prev=null"}, {});
    for (uint32_t f = 0; f < 6; ++f) {
        with.frame(f, f == 0);
        without.frame(f, f == 0);
        EXPECT_TRUE(with.visibility() == without.visibility()) << "frame " << f;
    }
}

// A point that is taken for a light with a size, as the model's own lamps are until they have been read.
TEST_F(AnotherLight, APointMayBeTakenForADisc) {
    Shot shot = shot_named("lights/grating");
    shot.lights.at("spot").radius = 0;
    ShotRun taken(shot, "light_shadows", {}, {}, {{"sun_disc", true}}), known(shot, "light_shadows", {}, {});
    for (uint32_t f = 0; f < 3; ++f) {
        taken.frame(f, f == 0);
        known.frame(f, f == 0);
    }
    EXPECT_GT(std::ranges::count(known.visibility(), 0.0f), 1000);
    EXPECT_LT(rms_difference(taken.visibility(), known.visibility()), 0.05);
}

}  // namespace
}  // namespace penumbra::test
