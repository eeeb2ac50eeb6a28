// SPDX-License-Identifier: MIT
// The last frame's light was another one, or is not known: what its rays said is believed as far as it is the
// same light.
#include <fmt/format.h>

#include <algorithm>

#include "tests/gpu_test.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

class AnotherLight : public GpuTest {};

// After a jump of the sun rays go where a frame without a past would send them: 1.5 times its error where
// they go where the old sun's shadows were.
TEST_F(AnotherLight, RaysAreNotAllottedByWhatTheSunOfBeforeShowed) {
    constexpr uint32_t jump = 10;
    Shot shot = shot_named("colonnade", {{192, 108}});
    shot.camera.resize(1);
    shot.objects.clear();
    shot.sun = {{jump - 1.0, {-0.4, 0.7, 0.5}}, {double(jump), {0.75, 0.62, -0.25}}};
    const std::vector<float> exact = ShotRun("covered", shot).frame(jump, true);
    const double without = rms(ShotRun("shadows_fast", shot).frame(jump, true), exact);
    EXPECT_GT(without, 0.02);
    EXPECT_LT(rms(ShotRun("shadows_fast", shot).up_to(jump), exact), 1.3 * without);
}

// Who brings the sun's past with a lamp and not the lamp's has said nothing of the lamp's.
TEST_F(AnotherLight, ALampsPastIsNotTheSuns) {
    const Shot shot = shot_named("lights/grating", {{192, 108}});
    ShotRun with("one_ray", shot, {.settings = {"inputs.light={}"}}),
        without("one_ray", shot, {.settings = {"inputs.light={}", "inputs.sun_prev=null"}});
    for (uint32_t f = 0; f < 6; ++f)
        EXPECT_TRUE(with.frame(f, f == 0) == without.frame(f, f == 0)) << "frame " << f;
}

// What a large lamp's penumbra was says nothing of a small one's: .029 against .008 without a past, where all
// of the small one's place was believed to have been asked.
TEST_F(AnotherLight, ALampThatShrinksLeavesItsPenumbraBehind) {
    constexpr uint32_t then = 24;
    Shot shot = shot_named("lights/interior", {{96, 64}});
    shot.camera.resize(1);
    shot.objects.clear();
    for (const LightKind kind : {LightKind::sphere, LightKind::rectangle}) {
        ShotLight lamp;
        lamp.kind = kind;
        lamp.strength = 4000;
        lamp.radius = lamp.length = lamp.height = 0.4;
        for (const double aside : {0.0, 0.4}) {  // to the rim of where it was
            SCOPED_TRACE(fmt::format("kind {}, {} m aside", int(kind), aside));
            const LightKey large{.position = {0.4, 2.2, 0.2}};
            LightKey before = large, small = large;
            before.frame = then - 1;
            small.frame = then;
            small.position.x += aside;
            small.size = 0.05;
            lamp.keys = {large, before, small};
            shot.lights = {{"lamp", lamp}};
            const std::vector<float> exact = ShotRun("light", shot).frame(then, true);
            const double without = rms(ShotRun("light_shadows", shot).frame(then, true), exact);
            EXPECT_LT(rms(ShotRun("light_shadows", shot).up_to(then), exact), 1.3 * without);
        }
    }
}

// A point that is taken for a light with a size, as the model's own lamps are until they have been read.
TEST_F(AnotherLight, APointMayBeTakenForADisc) {
    Shot shot = shot_named("lights/grating", {{192, 108}});
    shot.lights.at("spot").radius = 0;
    const std::vector<float> known = ShotRun("light_shadows", shot).up_to(2),
                             taken = ShotRun("light_shadows", shot, {.facts = {{"sun_disc", true}}}).up_to(2);
    EXPECT_GT(std::ranges::count(known, 0.0f), 1000);
    EXPECT_LT(rms(taken, known), 0.05);
}

}  // namespace
}  // namespace penumbra::test
