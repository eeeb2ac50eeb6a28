// SPDX-License-Identifier: MIT
// What `penumbra view` shows of a light that is near, and beside it.
#include "tests/view_live.h"

namespace penumbra::viewer {
namespace {

ShotLight lamp() {
    ShotLight lamp;
    lamp.kind = LightKind::sphere;
    lamp.radius = 0.4;
    lamp.range = 60;
    lamp.keys = {{0, {2, 6, 1}, {0, -1, 0}, {1, 0, 0}, 1, 1}};
    return lamp;
}

// What is beside a mask is of the same light, also after another pipeline has brought another light.
TEST_F(ViewLive, WhatIsBesideItIsOfTheSameLight) {
    shot_.lights["lamp"] = lamp();
    Live l = live("light_raw");
    ASSERT_TRUE(l.open()) << l.error();
    l.flight().play(false);
    run(l, 1);
    const auto halves_agree = [&] {
        l.split_share = 1;
        const auto left = l.picture().rgba;
        l.split_share = 0;
        return l.picture().rgba == left;
    };
    l.compare(Beside::published);
    ASSERT_EQ(l.beside(), Beside::published) << l.error();
    run(l, 1);
    EXPECT_FALSE(halves_agree()) << "rays and a denoiser";
    l.compare(Beside::raw);
    run(l, 1);
    EXPECT_TRUE(halves_agree()) << "the same rays";
    l.choose_pipeline((fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/raw.json").string());
    ASSERT_EQ(l.beside(), Beside::raw) << l.error();
    run(l, 1);
    EXPECT_TRUE(halves_agree()) << "one half is of the lamp still";
}

// A pipeline with a mask for each light is of the shot's, as `render` has it: the one that the view begins
// with, and one that is chosen later.
TEST_F(ViewLive, APipelineForEachLightIsOfTheShotsLights) {
    shot_.lights["bulb"] = lamp();
    using Names = std::set<std::string>;
    const auto outputs = [](const Live& l) {
        Names names;
        for (const PlanOutput& output : l.plan().outputs) names.insert(output.name);
        return names;
    };
    const Names both{"visibility_bulb", "visibility_lamp"};
    Live first = live("lights_shadows");
    StageWish of_one = first.wish();
    ASSERT_TRUE(first.open()) << first.error();
    EXPECT_EQ(outputs(first), both);
    run(first, 2);
    EXPECT_NE(rgba(first, "visibility_bulb"), rgba(first, "visibility_lamp"));

    Live chosen = live("raw");
    ASSERT_TRUE(chosen.open()) << chosen.error();
    run(chosen, 1);
    chosen.choose_pipeline("lights_shadows");
    ASSERT_EQ(chosen.error(), "");
    EXPECT_EQ(outputs(chosen), both);
    run(chosen, 1);

    of_one.light = "bulb";
    Live one(test::gpu(), shot_, of_one);
    ASSERT_TRUE(one.open()) << one.error();
    EXPECT_EQ(outputs(one), Names{"visibility_bulb"});
}

// Of a light that is near, too, the truth converges, and plain rays are those to it.
TEST_F(ViewLive, ALampHasATruthAndPlainRays) {
    shot_.lights["lamp"] = lamp();
    StageWish wish;
    wish.pipeline = (fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/light_raw.json").string();
    wish.size = size;
    wish.light = "lamp";
    Live l(test::gpu(), shot_, wish);
    ASSERT_TRUE(l.open()) << l.error();
    l.flight().play(false);
    run(l, 2);
    l.compare(Beside::raw);
    EXPECT_EQ(l.beside(), Beside::raw) << l.error();
    run(l, 1);
    l.compare(Beside::error);
    ASSERT_EQ(l.error(), "");
    for (int i = 0; i < 40 && (!l.judgement() || l.judgement()->rays < 64); ++i) l.frame({}, 1e9);
    ASSERT_TRUE(l.judgement());
    ASSERT_TRUE(l.judgement()->n_eff);
    EXPECT_NEAR(*l.judgement()->n_eff, 1, 0.35) << "one ray per pixel";
}

}  // namespace
}  // namespace penumbra::viewer
