// SPDX-License-Identifier: MIT
// A host may keep its depth as most engines once did, 0 at a near plane and 1 at a far one and in the sky:
// the camera's matrix says so, and the masks are those of reverse depth, frame by frame, but for rounding.
#include <cmath>
#include <cstring>

#include "tests/host_inputs.h"
#include "tests/shipped.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

constexpr Extent extent{256, 144};
constexpr double near_m = 1, far_m = 100;  // nothing of the scene is nearer or farther

Camera standard(Camera camera) {
    camera.clip_from_view[10] = -far_m / (far_m - near_m);
    camera.clip_from_view[14] = -near_m * far_m / (far_m - near_m);
    camera.near_m = near_m;
    return camera;
}

std::vector<std::byte> standard(std::vector<std::byte> texels, double near_of_reverse) {
    for (size_t i = 0; i < texels.size(); i += sizeof(float)) {
        float depth = 0;
        std::memcpy(&depth, &texels[i], sizeof depth);
        const double share = depth > 0 ? 1 - near_m * double(depth) / near_of_reverse : 1;
        depth = static_cast<float>(std::min(share * far_m / (far_m - near_m), 1.0));
        std::memcpy(&texels[i], &depth, sizeof depth);
    }
    return texels;
}

class StandardDepth : public GpuTest {};

TEST_F(StandardDepth, GivesTheMaskOfReverseDepth) {
    Shot shot = plaza_shot({extent.width, extent.height}, 8);
    shot.camera = {{0, {0.5, 2.5, 6}, {0, 1.2, 0}, {0, 1, 0}}, {16, {0.8, 2.5, 6.2}, {0, 1.2, 0}, {0, 1, 0}}};
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto scene = load_scene(shot, diagnostics, warnings);
    ASSERT_TRUE(scene) << diagnostics.text();
    StandaloneHost host(gpu(), shot, std::move(*scene), {{extent.width, extent.height}, 1, true});
    ViewRunOptions options;
    options.facts = host.facts();
    options.formats = host_image_formats;
    options.captures = {"view_depth"};
    const CheckedPipeline pipeline = shipped_pipeline("one_ray");
    ViewRun reverse(pipeline, extent, options), other(pipeline, extent, options);
    for (uint32_t index = 0; index < 4; ++index) {
        SCOPED_TRACE(index);
        const StandaloneFrame frame = host.frame(index, index == 0);
        for (const auto& [name, texels] : draw(host, frame)) {
            reverse.set(name, texels);
            other.set(name, name == "depth" ? standard(texels, frame.description.camera.near_m) : texels);
        }
        for (ViewRun* run : {&reverse, &other}) set_scene(*run, host, frame);
        reverse.frame(frame.description);
        FrameDescription described = frame.description;
        described.camera = standard(described.camera);
        described.previous = standard(described.previous);
        other.frame(described);

        const std::vector<float> expected = captured_planes(reverse.view(), "visibility")[0],
                                 seen = captured_planes(other.view(), "visibility")[0];
        const auto z = captured<float>(reverse.view(), "view_depth"),
                   same_z = captured<float>(other.view(), "view_depth");
        size_t sky = 0, soft = 0, off = 0;
        double squares = 0, farthest = 0;
        for (size_t p = 0; p < z.size(); ++p) {
            ASSERT_EQ(z[p] > 0, same_z[p] > 0) << p;
            sky += z[p] == 0;
            if (z[p] > 0) farthest = std::max(farthest, std::abs(double(same_z[p]) / double(z[p]) - 1));
            const double error = double(seen[p]) - double(expected[p]);
            squares += error * error;
            soft += expected[p] > 0.01f && expected[p] < 0.99f;
            off += std::abs(error) > 1.0 / 256;
        }
        const double rms = std::sqrt(squares / double(z.size()));
        std::printf(
            "frame %u: %zu of sky, %zu in penumbrae, %zu off by more than 1/256, rms %.2g; depth %.2g\n",
            index, sky, soft, off, rms, farthest);
        EXPECT_GT(sky, 1000u);
        EXPECT_GT(soft, 100u);
        EXPECT_LT(farthest, 2e-5);
        EXPECT_LE(off, z.size() / 2000);
        EXPECT_LE(rms, 1e-3);
    }
}

}  // namespace
}  // namespace penumbra::test
