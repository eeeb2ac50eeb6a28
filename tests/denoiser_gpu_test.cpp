// SPDX-License-Identifier: MIT
// The published denoiser's nodes on a device against the model in double precision, in two settings: the
// shipped pipeline on a scene in which camera, sun and an object move; and the nodes alone on random images
// with everything a host may get wrong, in the workgroup shapes of both device classes. Memory is
// poisoned before its first use.
#include <cmath>
#include <limits>
#include <random>

#include "app/session.h"
#include "tests/denoiser_check.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

std::vector<std::array<float, 4>> read_half4(const GpuImage& image) {
    const auto bytes =
        read_image(gpu(), image.get(), image.format, image.extent, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    std::vector<std::array<float, 4>> texels(bytes.size() / 8);
    for (size_t i = 0; i < texels.size(); ++i)
        for (size_t c = 0; c < 4; ++c) {
            uint16_t half = 0;
            std::memcpy(&half, &bytes[8 * i + 2 * c], 2);
            texels[i][c] = from_half(half);
        }
    return texels;
}

std::vector<std::array<float, 4>> read_float4(const GpuImage& image) {
    const auto bytes =
        read_image(gpu(), image.get(), image.format, image.extent, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    std::vector<std::array<float, 4>> texels(bytes.size() / sizeof(std::array<float, 4>));
    std::memcpy(texels.data(), bytes.data(), bytes.size());
    return texels;
}

class DenoiserGpu : public GpuTest {
  protected:
    // A threshold is a line in the image at most; a comparison that leaves more to rounding compares nothing.
    void expect_few_on_threshold(const DenoiserCheck& check) {
        if (gpu().info().is_cpu) {
            EXPECT_LE(check.on_threshold(), 2 + check.worked() / 200);
        }
        for (const auto& [what, part] : check.worst()) RecordProperty(what, std::to_string(part));
        RecordProperty("worked", static_cast<int>(check.worked()));
        RecordProperty("on_threshold", static_cast<int>(check.on_threshold()));
    }
};

class ShippedDenoiser : public DenoiserGpu, public ::testing::WithParamInterface<std::array<uint32_t, 2>> {};

TEST_P(ShippedDenoiser, ComputesWhatTheModelSays) {
    SessionOptions options;
    options.size = GetParam();
    options.poison = 0;
    options.captures = DenoiserCheck::names();
    options.captures.insert(options.captures.end(), {"hits", "visibility"});
    const auto session = open_session(shipped_pipeline("fidelityfx"), plaza_shot(options.size, 12), options);
    DenoiserCheck check({options.size[0], options.size[1]}, sampler_error_px());
    for (uint32_t index = 0; index < 12; ++index) {
        SCOPED_TRACE(testing::Message() << "frame " << index);
        const bool reset = index == 0 || index == 9;
        session->run_frame(index, reset);
        const StandaloneFrame frame = session->host().frame(index, reset);
        const GBufferImages& images = session->host().images();
        HostFrame host;
        host.sun = frame.sun;
        const auto depth = read_image(gpu(), images.depth.get(), images.depth.format, images.depth.extent,
                                      GBuffer::final_layout);
        host.depth.resize(depth.size() / 4);
        std::memcpy(host.depth.data(), depth.data(), depth.size());
        host.normal = read_float4(images.normal);
        host.motion = read_half4(images.motion);
        host.hits = captured<uint32_t>(session->view(), "hits");
        check.frame(session->view(), host, frame.description);
    }
    EXPECT_GT(check.worked(), 0u);
    expect_few_on_threshold(check);
}

INSTANTIATE_TEST_SUITE_P(Sizes, ShippedDenoiser,
                         ::testing::Values(std::array{203u, 117u}, std::array{67u, 45u}, std::array{17u, 1u}),
                         [](const auto& test) {
                             return std::to_string(test.param[0]) + "x" + std::to_string(test.param[1]);
                         });

// The shipped wiring without the tracer: the rays' results are a host input.
constexpr const char* nodes_alone = R"({
  "penumbra": 1, "name": "denoiser", "inputs": { "depth": {}, "normal": {}, "motion": {}, "sun": {}, "ray_hits": {} },
  "outputs": ["visibility"], "resources": { "visibility": { "format": "r8" } },
  "nodes": {
    "guides": { "type": "guides" },
    "classify": { "type": "classify", "params": { "terminator": "TERMINATOR" } },
    "prepare": { "type": "prepare", "in": { "hits": "ray_hits" } },
    "tileclass": { "type": "tileclass", "in": { "history": "filtered0@-1", "moments_prev": "moments@-1", "view_depth_prev": "view_depth@-1" } },
    "filter0": { "type": "filter", "in": { "signal": "reprojected" }, "out": { "filtered": "filtered0" }, "params": { "step": 1 } },
    "filter1": { "type": "filter", "in": { "signal": "filtered0" }, "out": { "filtered": "filtered1" }, "params": { "step": 2 } },
    "filter2": { "type": "filter", "in": { "signal": "filtered1" }, "out": { "filtered": "visibility" }, "params": { "step": 4, "contrast": true } }
  }
})";

// A wavy surface with holes. The sun's shadow is a noisy disc that moves, so that blocks are uniform, noisy
// and both in turn.
class RandomHost {
  public:
    RandomHost(Extent extent, uint32_t seed) : extent_(extent), random_(seed) {}

    HostFrame frame(double near_m) {
        const size_t n = static_cast<size_t>(extent_.width) * extent_.height;
        HostFrame host;
        host.sun = {{{0.6f, 0.64f, 0.48f}}, 0.02f};
        const uint32_t across = (extent_.width + 7) / 8, down = (extent_.height + 3) / 4;
        host.hits.assign(static_cast<size_t>(across) * down, 0);
        for (size_t i = 0; i < n; ++i) {
            const auto x = static_cast<double>(i % extent_.width), y = static_cast<double>(i / extent_.width);
            host.depth.push_back(depth(x, y, near_m));
            host.normal.push_back(halves(normal(x, y)));
            host.motion.push_back(halves(motion()));
            const double distance = std::hypot(x - 0.4 * extent_.width - frame_, y - 0.5 * extent_.height);
            const double lit = std::clamp((distance - 0.15 * extent_.width) / 12, 0.0, 1.0);
            if (!(uniform() < lit))
                host.hits[i / extent_.width / 4 * across + i % extent_.width / 8] |=
                    1u << (i / extent_.width % 4 * 8 + i % extent_.width % 8);
        }
        ++frame_;
        return host;
    }

  private:
    static constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                            inf = std::numeric_limits<double>::infinity();

    double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
    bool one_in(int n) { return random_() % static_cast<uint32_t>(n) == 0; }
    double one_of(std::initializer_list<double> values) { return values.begin()[random_() % values.size()]; }
    // As the device reads it from rgba16f.
    static std::array<float, 4> halves(const std::array<double, 4>& v) {
        std::array<float, 4> out;
        const auto bits = to_half4(v);
        for (size_t c = 0; c < 4; ++c) out[c] = from_half(bits[c]);
        return out;
    }

    float depth(double x, double y, double near_m) {
        // Left of the middle none is bad, so that blocks can be all lit.
        if (x > 0.5 * extent_.width && one_in(30))
            return static_cast<float>(one_of({nan, inf, -inf, -0.5, 0, 1, 2}));
        if (x > 0.85 * extent_.width && y < 0.4 * extent_.height) return 0;  // sky
        const double step = x > 0.6 * extent_.width ? 1.5 : 0;
        const double z = 4 + step + 0.3 * std::sin(0.2 * x) + 0.002 * y;
        return static_cast<float>(near_m / (z * (1 + (one_in(5) ? 0.05 : 0.001) * (uniform() - 0.5))));
    }
    std::array<double, 4> normal(double x, double y) {
        if (one_in(50)) return {one_of({nan, inf, 0, 1e4}), one_of({nan, 0, 0.001}), one_of({inf, 0, -1}), 0};
        if (one_in(6)) {  // about where the sun sets: within .03 of perpendicular to it
            const double sine = 0.06 * (uniform() - 0.5);
            return {0.6 * sine + 0.8, 0.64 * sine - 0.6, 0.48 * sine - 0.2, 0};
        }
        const double tilt = 0.5 * std::sin(0.1 * x) + 0.1 * (uniform() - 0.5),
                     lean = y > 0.7 * extent_.height ? 2.5 : 0.1;
        const double length = 0.2 + uniform();
        return {length * std::sin(tilt),
                length * 0.1 * (uniform() - 0.5) - length * std::sin(lean) * std::cos(tilt),
                length * std::cos(lean) * std::cos(tilt), 0};
    }
    std::array<double, 4> motion() {
        if (one_in(40)) return {one_of({nan, inf, -inf, 65504, 0.9, -0.9}), one_of({nan, inf, 0, -2}), 0, 0};
        if (one_in(2)) return {0, 0, 0, 0};
        return {(uniform() - 0.5) * 6 / extent_.width, (uniform() - 0.5) * 6 / extent_.height, 0, 0};
    }

    Extent extent_;
    std::mt19937 random_;
    int frame_ = 0;
};

std::vector<std::array<uint16_t, 4>> half_texels(const std::vector<std::array<float, 4>>& values) {
    std::vector<std::array<uint16_t, 4>> texels;
    for (const auto& v : values) texels.push_back(to_half4({v[0], v[1], v[2], v[3]}));
    return texels;
}

class DenoiserNodes : public DenoiserGpu,
                      public ::testing::WithParamInterface<std::tuple<std::array<uint32_t, 2>, bool>> {};

TEST_P(DenoiserNodes, ComputeWhatTheModelSaysOfRandomImages) {
    const auto& [size, cpu] = GetParam();
    const Extent extent{size[0], size[1]};
    for (const char* terminator : {"centre", "disc"}) {
        SCOPED_TRACE(terminator);
        std::string text = nodes_alone;
        text.replace(text.find("TERMINATOR"), 10, terminator);
        ViewRunOptions options;
        options.cpu = cpu;
        options.jitters = true;
        // NaN in the memory shows what is read unwritten, but fails the test of the previous depth as a reset
        // should: that the reset itself is heeded shows where the old state stays.
        if (std::string(terminator) == "disc") options.poison = std::nullopt;
        options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}, {"motion", Format::rgba16f}};
        options.captures = DenoiserCheck::names();
        ViewRun run(shadow_pipeline(text), extent, options);
        DenoiserCheck check(extent, sampler_error_px());
        RandomHost random(extent, 1 + size[0]);
        Camera previous = camera_at({0, 0, 0}, 0, extent);
        for (uint32_t index = 0; index < 8; ++index) {
            SCOPED_TRACE(testing::Message() << "frame " << index);
            const Camera camera =
                camera_at({0.02 * index, 0.01 * index, 0.03 * index}, 0.005 * index, extent);
            FrameDescription frame = frame_between(previous, camera, extent, index, index == 0 || index == 6);
            frame.jitter = {0.3 / extent.width, -0.2 / extent.height};
            HostFrame host = random.frame(camera.near_m);
            host.whole_disc = std::string(terminator) == "disc";
            run.set("depth", host.depth);
            run.set("normal", half_texels(host.normal));
            run.set("motion", half_texels(host.motion));
            run.set("ray_hits", host.hits);
            run.set("sun", std::vector<blocks::Sun>{host.sun});
            run.frame(frame);
            check.frame(run.view(), host, frame);
            previous = camera;
        }
        EXPECT_GT(check.worked(), 0u);
        expect_few_on_threshold(check);
    }
}

INSTANTIATE_TEST_SUITE_P(SizesAndShapes, DenoiserNodes,
                         ::testing::Combine(::testing::Values(std::array{203u, 117u}, std::array{67u, 45u},
                                                              std::array{17u, 1u}, std::array{1u, 9u}),
                                            ::testing::Bool()),
                         [](const auto& test) {
                             const auto size = std::get<0>(test.param);
                             return std::to_string(size[0]) + "x" + std::to_string(size[1]) +
                                    (std::get<1>(test.param) ? "Cpu" : "Gpu");
                         });

}  // namespace
}  // namespace penumbra::test
