// SPDX-License-Identifier: MIT
// denoise_radiance.json, for hosts that trace by themselves: on radiance_rays' own rays as if they were a
// host's.
#include <algorithm>

#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/reflections/radiance_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class DenoiseRadiance : public GpuTest {};

constexpr uint32_t frames = 5;

Shot moving_shot() {
    Shot shot = night_shot(striped_floor({0, 0.1f, 0.3f, 0.8f}), {56, 32}, frames);
    shot.camera.push_back({frames - 1, {0.4, 1.4, 2.8}, {0.1, 0, 0}, {0, 1, 0}});
    shot.environment = linear_sky(0.2, 2);
    return shot;
}

// What the host's rays become after some frames, and what their own pipeline makes of them. `turned`: each
// direction is that of another pixel.
struct Images {
    std::vector<float> foreign, own;
};
Images run(bool turned) {
    const Shot shot = moving_shot();
    const auto session =
        open_shipped("reflections", shot,
                     {"nodes.rays.params.hit_normals=false", "nodes.reconnect.params.hit_normals=false"},
                     {"radiance", "ray_direction"});
    ViewRunOptions options;
    options.formats = {{"depth", Format::r32f},
                       {"normal", Format::rgba32f},
                       {"motion", Format::rgba16f},
                       {"material", Format::rg8}};
    options.facts = {{"moves", true}};
    ViewRun host(shadow_pipeline_file("denoise_radiance"), {shot.size[0], shot.size[1]}, options);
    const auto hand_over = [&](const char* name, const GpuImage& image) {
        host.set(name, read_image(gpu(), image.get(), image.format, image.extent, GBuffer::final_layout));
    };
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session->run_frame(frame, frame == 0);
        const GBufferImages& images = session->host().images();
        hand_over("depth", images.depth);
        hand_over("normal", images.normal);
        hand_over("motion", images.motion);
        hand_over("material", images.material);
        host.set("radiance", session->view().captured("radiance"));
        auto directions = captured<uint32_t>(session->view(), "ray_direction");
        if (turned) std::rotate(directions.begin(), directions.begin() + 1, directions.end());
        host.set("ray_direction", directions);
        host.frame(session->frame_description());
    }
    return {captured_planes(host.view(), "specular").at(0),
            captured_planes(session->view(), "specular").at(0)};
}

TEST_F(DenoiseRadiance, OfOurRaysIsTheirPipeline) {
    const Images images = run(false);
    EXPECT_TRUE(images.foreign == images.own);
    EXPECT_GT(*std::ranges::max_element(images.own), 0.1f);
}

TEST_F(DenoiseRadiance, KnowsWhereRaysWent) {
    const Images images = run(true);
    EXPECT_FALSE(images.foreign == images.own);
}

}  // namespace
}  // namespace penumbra::test
