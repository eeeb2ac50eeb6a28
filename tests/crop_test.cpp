// SPDX-License-Identifier: MIT
// A picture is the same wherever its borders are: a part of a large render, rendered alone through an
// off-centre projection, has the same shadows but for rounding. The part starts at the first pixel, so that
// each of its own draws the same numbers. What is within reach of its border may differ: its neighbours are
// missing there.
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "tests/host_inputs.h"
#include "tests/shipped.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

constexpr uint32_t large = 512, small = 256, first = 0;  // pixels; the noise repeats nowhere else
constexpr double scale = double(large) / small;

std::vector<std::byte> cropped(const std::vector<std::byte>& texels) {
    const size_t bytes = texels.size() / (large * large);
    std::vector<std::byte> out;
    for (uint32_t y = first; y < first + small; ++y) {
        const auto row = texels.begin() + std::ptrdiff_t((size_t{y} * large + first) * bytes);
        out.insert(out.end(), row, row + std::ptrdiff_t(small * bytes));
    }
    return out;
}

// uv of the small image are twice those of the large one; exact in half precision.
std::vector<std::byte> scaled_motion(std::vector<std::byte> texels) {
    for (size_t i = 0; i < texels.size(); i += 8) {
        uint64_t word = 0;
        std::memcpy(&word, &texels[i], 8);
        glm::vec4 motion = glm::unpackHalf4x16(word);
        motion.x *= float(scale);
        motion.y *= float(scale);
        word = glm::packHalf4x16(motion);
        std::memcpy(&texels[i], &word, 8);
    }
    return texels;
}

Camera off_centre(Camera camera) {
    const double centre = 2 * (first + small / 2.0) / large - 1;  // of the crop, in the large image's ndc
    const glm::dmat4 crop = glm::scale(glm::dmat4(1), glm::dvec3(scale, scale, 1)) *
                            glm::translate(glm::dmat4(1), glm::dvec3(-centre, -centre, 0));
    const glm::dmat4 clip = crop * glm::make_mat4(camera.clip_from_view.data());
    std::copy_n(glm::value_ptr(clip), 16, camera.clip_from_view.begin());
    return camera;
}

FrameDescription crop_of(FrameDescription frame) {
    frame.camera = off_centre(frame.camera);
    frame.previous = off_centre(frame.previous);
    for (auto* jitter : {&frame.jitter, &frame.prev_jitter})
        for (double& j : *jitter) j *= scale;
    frame.size = frame.prev_size = {small, small};
    return frame;
}

class Crop : public GpuTest {};

TEST_F(Crop, OfALargerRenderEqualsTheSmallRender) {
    Shot shot = plaza_shot({large, large}, 8);
    shot.camera = {{0, {0.5, 4, 4}, {0, 0, 0}, {0, 1, 0}}, {16, {0.8, 4, 4.2}, {0, 0, 0}, {0, 1, 0}}};
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto scene = load_scene(shot, diagnostics, warnings);
    ASSERT_TRUE(scene) << diagnostics.text();
    StandaloneHost host(gpu(), shot, std::move(*scene), {{large, large}, 1, true});
    ViewRunOptions options;
    options.facts = host.facts();
    options.formats = host_image_formats;
    const CheckedPipeline pipeline = shipped_pipeline("one_ray");
    ViewRun whole(pipeline, {large, large}, options), part(pipeline, {small, small}, options);

    for (uint32_t index = 0; index < 4; ++index) {
        SCOPED_TRACE(index);
        const StandaloneFrame frame = host.frame(index, index == 0);
        for (const auto& [name, texels] : draw(host, frame)) {
            whole.set(name, texels);
            part.set(name, name == "motion" ? scaled_motion(cropped(texels)) : cropped(texels));
        }
        for (ViewRun* run : {&whole, &part}) set_scene(*run, host, frame);
        whole.frame(frame.description);
        part.frame(crop_of(frame.description));

        const std::vector<float> expected = captured_planes(whole.view(), "visibility")[0],
                                 seen = captured_planes(part.view(), "visibility")[0];
        constexpr uint32_t border = 24;
        double squares = 0, largest = 0;
        size_t soft = 0, off = 0, count = 0;
        for (uint32_t y = border; y < small - border; ++y)
            for (uint32_t x = border; x < small - border; ++x, ++count) {
                const auto v = double(expected[(y + first) * large + x + first]),
                           error = double(seen[y * small + x]) - v;
                squares += error * error;
                largest = std::max(largest, std::abs(error));
                soft += v > 0.01 && v < 0.99;
                off += std::abs(error) > 1.0 / 256;
            }
        std::printf(
            "frame %u: %zu pixels, %zu in penumbrae, %zu off by more than 1/256, largest %.3g, rms %.2g\n",
            index, count, soft, off, largest, std::sqrt(squares / double(count)));
        EXPECT_GT(soft, 900u);
        EXPECT_LE(off, count / 2000);
        EXPECT_LE(std::sqrt(squares / double(count)), 1e-3);
    }
}

}  // namespace
}  // namespace penumbra::test
