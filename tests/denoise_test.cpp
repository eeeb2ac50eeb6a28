// SPDX-License-Identifier: MIT
// denoise.json, for hosts that trace by themselves: on trace's own rays as if they were a host's, by how much
// is known of them; and on images of the test's making, in every form that the host's samples may come in.
#include <algorithm>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <random>

#include "app/session.h"
#include "host/truth/analytic.h"
#include "tests/edge_run.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

class Denoise : public GpuTest {};

// Rays of a pipeline of ours on a straight edge, handed to denoise.json frame by frame. `knows`: gather's
// parameter rays. A host may have rays for some pixels only: a word per 8x4 pixels, of the frame's number.
using RayWord = uint32_t (*)(uint32_t frame);

class ForeignRays {
  public:
    ForeignRays(const Edge& edge, const std::string& knows, const std::vector<std::string>& settings = {},
                const std::string& tracer = "one_ray", RayWord some = nullptr)
        : shot_(shot_of(edge)),
          knows_(knows),
          budget_(tracer != "one_ray"),
          some_(some),
          run_(pipeline(knows, settings, budget_, some != nullptr), extent_of(edge), run_options()) {
        SessionOptions options;
        options.size = edge.size;
        options.captures = {"hits", "blockers", "ray_points", "visibility"};
        if (budget_) options.captures.insert(options.captures.end(), {"ray_words", "ray_bits"});
        options.seed = 1;
        options.facts = {{"moves", true}};  // as the other knows it
        options.jitter = false;
        tracer_ = open_session(shipped_pipeline(tracer), shot_, options, test_nodes());
    }

    // What denoise.json makes of them, and what their own pipeline does.
    struct Images {
        std::vector<float> foreign, own;
    };
    Images up_to(uint32_t last) {
        for (uint32_t index = 0; index <= last; ++index) {
            tracer_->run_frame(index, index == 0);
            const StandaloneFrame frame = tracer_->host().frame(index, index == 0);
            const GBufferImages& images = tracer_->host().images();
            hand_over("depth", images.depth);
            hand_over("normal", images.normal);
            hand_over("motion", images.motion);
            run_.set("sun", std::vector<blocks::Sun>{frame.sun});
            run_.set("sun_prev", std::vector<blocks::Sun>{frame.sun});
            run_.set("hits", captured<uint32_t>(tracer_->view(), "hits"));
            if (knows_ != "bits") run_.set("blockers", captured<uint32_t>(tracer_->view(), "blockers"));
            if (knows_ == "known") run_.set("ray_points", captured<uint32_t>(tracer_->view(), "ray_points"));
            if (budget_) {
                run_.set("ray_words", captured<uint32_t>(tracer_->view(), "ray_words"));
                run_.set("ray_bits", captured<uint32_t>(tracer_->view(), "ray_bits"));
            }
            if (some_) {
                const size_t words = captured<uint32_t>(tracer_->view(), "hits").size();
                run_.set("ray_words", std::vector<uint32_t>(words, some_(index)));
            }
            run_.frame(frame.description);
        }
        return {captured_planes(run_.view(), "visibility").at(0),
                captured_planes(tracer_->view(), "visibility").at(0)};
    }

  private:
    static Extent extent_of(const Edge& edge) { return {edge.size[0], edge.size[1]}; }
    static CheckedPipeline pipeline(const std::string& knows, std::vector<std::string> settings, bool budget,
                                    bool some) {
        if (budget || some) {
            settings.emplace_back("inputs.ray_words={}");
            settings.emplace_back("nodes.gather.out.frame_worth=frame_worth");
            settings.emplace_back("nodes.drift.in.frames=frame_worth");
        }
        if (budget) settings.emplace_back("inputs.ray_bits={}");
        settings.push_back("nodes.gather.params.rays=" + knows);
        if (knows != "bits")
            settings.insert(settings.end(), {"inputs.blockers={}", "nodes.prepare.params.blocks=true"});
        if (knows == "known") settings.emplace_back("inputs.ray_points={}");
        return shipped_pipeline("denoise", settings);
    }
    static ViewRunOptions run_options() {
        ViewRunOptions options;
        options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba32f}, {"motion", Format::rgba16f}};
        return options;
    }
    void hand_over(const char* name, const GpuImage& image) {
        run_.set(name, read_image(gpu(), image.get(), image.format, image.extent, GBuffer::final_layout));
    }

    Shot shot_;
    std::string knows_;
    bool budget_;
    RayWord some_;
    ViewRun run_;
    std::unique_ptr<Session> tracer_;
};

// A host that knows as much of its rays as ours do gets what their pipeline makes of them, bit for bit: of
// one ray per pixel, and of as many as a budget gives, some pixels none and some many.
TEST_F(Denoise, WithAllThatIsKnownOfRaysIsTheirPipeline) {
    for (const std::string tracer : {"one_ray", "shadows"})
        for (const double speed : {0.0, 0.5}) {
            const Edge edge{.width_px = 8, .speed_px = speed, .last = 9};
            const auto images = ForeignRays(edge, "known", {}, tracer).up_to(edge.last);
            EXPECT_TRUE(images.foreign == images.own) << tracer << ", " << speed;
        }
}

// Rays of a host for every second pixel, in turns, or for one in four. A pixel without a ray takes its
// neighbours' and its past. Gates are about half of what is reached.
uint32_t checkerboard(uint32_t frame) {
    return frame % 2 == 0 ? 0xaa55aa55 : 0x55aa55aa;
}
uint32_t one_of_four(uint32_t frame) {
    return 0x00550055u << (frame % 2) << 8 * (frame / 2 % 2);
}

TEST_F(Denoise, TakesRaysForSomePixelsOnly) {
    for (const RayWord some : {&checkerboard, &one_of_four}) {
        SCOPED_TRACE(some == &checkerboard ? "every second pixel" : "one of four");
        const auto n_eff = [&](const Edge& edge) {
            return n_eff_inside(edge,
                                ForeignRays(edge, "known", {}, "one_ray", some).up_to(edge.last).foreign);
        };
        EXPECT_GT(n_eff({.width_px = 8, .last = 0}), some == &checkerboard ? 20 : 8);
        EXPECT_GT(n_eff({.width_px = 32, .last = 0}), some == &checkerboard ? 60 : 25);
        EXPECT_GT(n_eff({.width_px = 8, .last = 63}), some == &checkerboard ? 90 : 23);
        EXPECT_GT(n_eff({.width_px = 1, .last = 63}), some == &checkerboard ? 25 : 10);
        EXPECT_GT(n_eff({.width_px = 8, .speed_px = 0.5, .last = 24}), some == &checkerboard ? 15 : 6);
    }
}

double n_eff(const Edge& edge, const std::string& knows, const std::vector<std::string>& settings = {}) {
    return n_eff_inside(edge, ForeignRays(edge, knows, settings).up_to(edge.last).foreign);
}

// Gates are about half of what is reached (docs/denoiser.md); the rays themselves have 1.
TEST_F(Denoise, KnowsPenumbraeByTheirBlockersDistances) {
    EXPECT_GT(n_eff({.width_px = 2, .last = 0}, "distances"), 2.8);
    EXPECT_GT(n_eff({.width_px = 8, .last = 0}, "distances"), 17);
    EXPECT_GT(n_eff({.width_px = 32, .last = 0}, "distances"), 100);
    EXPECT_GT(n_eff({.width_px = 8, .speed_px = 0.5, .last = 24}, "distances"), 12);
    EXPECT_GT(n_eff({.width_px = 16, .last = 63}, "distances"), 1000);
}

TEST_F(Denoise, OfBareBitsIsNoWorseThanAveragingThem) {
    for (const double width : {2.0, 8.0, 32.0}) {
        EXPECT_GT(n_eff({.width_px = width, .last = 0}, "bits"), 2.5) << width;
        EXPECT_GT(n_eff({.width_px = width, .last = 63}, "bits"), 300) << width;
    }
    EXPECT_GT(n_eff({.width_px = 8, .speed_px = 0.5, .last = 24}, "bits"), 1.8);
}

// denoise.json on images that a host hands over: a wall seen face on, and noise that thickens to the right.
class WallHost {
  public:
    explicit WallHost(const CheckedPipeline& pipeline, std::optional<uint32_t> poison = 0, bool alias = true)
        : run_(pipeline, extent, options(poison, alias)) {}

    // `broken` is what half of every image holds instead.
    std::vector<float> frame(uint32_t index, std::optional<float> broken = {}) {
        const size_t n = size_t(extent.width) * extent.height;
        std::vector<float> depth(n, 0.01f);  // near / view depth
        std::vector<uint64_t> normal(n, glm::packHalf4x16({0, 0, 1, 0})), motion(n, 0);
        std::vector<uint32_t> hits(size_t(extent.width / 8) * (extent.height / 4), 0);
        std::vector<uint8_t> mask(n);
        std::mt19937 random(index + 1);
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t x = i % extent.width, y = i / extent.width;
            const bool lit = further_ || random() % extent.width >= x;
            mask[i] = lit ? 255 : 0;
            if (!lit) hits[y / 4 * (extent.width / 8) + x / 8] |= 1u << (y % 4 * 8 + x % 8);
            if (broken && y < extent.height / 2) {
                depth[i] = *broken;
                normal[i] = motion[i] = glm::packHalf4x16(glm::vec4(*broken));
            }
        }
        run_.set("depth", depth);
        run_.set("normal", normal);
        run_.set("motion", motion);
        run_.set("sun", std::vector<blocks::Sun>{{{{0, 0.6f, 0.8f}}, 0.00465f}});
        run_.set("sun_prev", std::vector<blocks::Sun>{{{{0, 0.6f, 0.8f}}, 0.00465f}});
        if (image_)
            run_.set("mask", mask);
        else
            run_.set("hits", hits);
        if (further_) {
            run_.set("ray_words", std::vector<uint32_t>(hits.size(), ~0u));
            std::vector<uint32_t> bits(n);
            bits.at(further_->pixel) = index < further_->from ? further_->before : further_->word;
            run_.set("ray_bits", bits);
        }
        const Camera camera = camera_at({0, 0, 0}, 0, extent);
        run_.frame(frame_between(camera, camera, extent, index, index == 0 || index == reset_at_));
        return captured_planes(run_.view(), "visibility").at(0);
    }
    WallHost& with_mask() {
        image_ = true;
        return *this;
    }
    // Every pixel's ray is lit then, and one pixel has several, in words as refine leaves them; the second
    // counts from a frame on.
    struct Further {
        uint32_t pixel, before, word, from;
    };
    WallHost& with_further(const Further& further) {
        further_ = further;
        return *this;
    }
    WallHost& with_reset_at(uint32_t index) {
        reset_at_ = index;
        return *this;
    }

  private:
    static constexpr Extent extent{96, 64};
    static ViewRunOptions options(std::optional<uint32_t> poison, bool alias) {
        ViewRunOptions options;
        options.poison = poison;
        options.alias = alias;
        options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}, {"motion", Format::rgba16f}};
        return options;
    }
    ViewRun run_;
    bool image_ = false;
    std::optional<Further> further_;
    uint32_t reset_at_ = 0;
};

CheckedPipeline by_input(bool mask) {
    if (!mask) return shipped_pipeline("denoise");
    return shipped_pipeline("denoise",
                            {"inputs.hits=null", "inputs.mask={}", "nodes.prepare.params.source=image"});
}

TEST_F(Denoise, ComesFromAHostsBitsAndFromItsMaskAlike) {
    WallHost words(by_input(false)), image(by_input(true));
    image.with_mask();
    for (uint32_t index = 0; index < 4; ++index)
        EXPECT_TRUE(words.frame(index) == image.frame(index)) << index;
}

// The denoiser alone, by either input: memory sharing and garbage do not show. A reset in the middle makes
// garbage history likelier to show.
TEST_F(Denoise, DoesNotShowAliasingOrPoison) {
    for (const bool mask : {false, true}) {
        const auto frames = [&](std::optional<uint32_t> poison, bool alias) {
            WallHost host(by_input(mask), poison, alias);
            if (mask) host.with_mask();
            host.with_reset_at(5);
            std::vector<std::vector<float>> out;
            for (uint32_t index = 0; index < 8; ++index) out.push_back(host.frame(index));
            return out;
        };
        const auto expected = frames(std::nullopt, false);
        for (const uint32_t poison : {0u, 1u})
            for (const bool alias : {true, false})
                EXPECT_TRUE(frames(poison, alias) == expected)
                    << "mask " << mask << " poison " << poison << " alias " << alias;
    }
}

// Of a pixel's own nine rays five are blocked, all first rays are lit, and so may earlier frames have been:
// what they agree in is no more certain than the nine, and a past that these contradict is over.
TEST_F(Denoise, BelievesAPixelsOwnRaysBeforeOthersThatAgree) {
    const uint32_t pixel = 96 * 33 + 49, nine = 0b1'0001'1111, nearly_lit = 0b1'0000'0001;
    for (const uint32_t from : {0u, 24u}) {
        WallHost host(shipped_pipeline(
            "denoise", {"inputs.ray_words={}", "inputs.ray_bits={}",
                        "nodes.gather.out.frame_worth=frame_worth", "nodes.drift.in.frames=frame_worth"}));
        host.with_further({pixel, nearly_lit, nine, from});
        for (uint32_t index = 0; index < from; ++index) host.frame(index);
        const std::vector<float> image = host.frame(from);
        EXPECT_NEAR(image.at(pixel), 4.0 / 9, from == 0 ? 0.01 : 0.15) << from;
        EXPECT_EQ(std::ranges::count(image, 1.0f), 96 * 64 - 1) << from;
    }
}

// A block of pixels that turns dark, and beyond the reach of rays, but not of the doubt that this casts on
// the past, one that has no ray any more: nothing says that it has changed.
TEST_F(Denoise, LeavesAPixelThatNothingTellsWhatItWas) {
    constexpr Extent extent{32, 32};
    constexpr uint32_t n = extent.width * extent.height, alone = 10 * extent.width + 19, turns = 8;
    ViewRunOptions options;
    options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}, {"motion", Format::rgba16f}};
    ViewRun run(
        shipped_pipeline("denoise", {"inputs.ray_words={}", "nodes.gather.out.frame_worth=frame_worth",
                                     "nodes.drift.in.frames=frame_worth"}),
        extent, options);
    std::vector<uint64_t> normal(n, glm::packHalf4x16({0, 0, -1, 0}));  // away from the sun
    normal[alone] = glm::packHalf4x16({0, 0, 1, 0});
    std::vector<uint32_t> block(n / 32), rays(n / 32, ~0u);
    for (uint32_t y = 8; y < 16; ++y)
        for (uint32_t x = 8; x < 16; ++x) {
            normal[y * extent.width + x] = normal[alone];
            block[y / 4 * (extent.width / 8) + x / 8] |= 1u << (y % 4 * 8 + x % 8);
        }
    const Camera camera = camera_at({0, 0, 0}, 0, extent);
    const blocks::Sun sun{{{0, 0.6f, 0.8f}}, 0.00465f};
    for (uint32_t index = 0; index < turns + 4; ++index) {
        run.set("depth", std::vector<float>(n, 0.01f));
        run.set("normal", normal);
        run.set("motion", std::vector<uint64_t>(n, 0));
        run.set("sun", std::vector{sun});
        run.set("sun_prev", std::vector{sun});
        run.set("hits", index < turns ? std::vector<uint32_t>(n / 32) : block);
        rays[10 / 4 * (extent.width / 8) + 19 / 8] = index < turns ? ~0u : 0u;
        run.set("ray_words", rays);
        run.frame(frame_between(camera, camera, extent, index, index == 0));
        const std::vector<float> image = captured_planes(run.view(), "visibility").at(0);
        EXPECT_GT(image.at(alone), 0.99f) << index;
        if (index >= turns) {
            EXPECT_LT(image.at(10 * extent.width + 12), 0.2f) << index;
        }
    }
}

// What a broken frame leaves behind is a shorter history, in the part that was broken and around it.
TEST_F(Denoise, SurvivesABrokenFrame) {
    for (const float broken :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30f}) {
        WallHost host(by_input(false)), unharmed(by_input(false));
        for (uint32_t index = 0; index < 8; ++index) {
            SCOPED_TRACE(testing::Message() << broken << ", frame " << index);
            const std::vector<float> image =
                host.frame(index, index == 3 ? std::optional(broken) : std::nullopt);
            const std::vector<float> expected = unharmed.frame(index);
            for (const float v : image) ASSERT_TRUE(v >= 0 && v <= 1);
            for (size_t i = 96 * (32 + 16); i < image.size(); ++i)
                ASSERT_NEAR(image[i], expected[i], 0.05) << i;
        }
    }
}

}  // namespace
}  // namespace penumbra::test
