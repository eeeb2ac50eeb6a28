// SPDX-License-Identifier: MIT
#include "tests/denoiser_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <set>

#include "tests/gpu_test.h"

namespace penumbra::test {
namespace {

constexpr int tile_w = 8, tile_h = 4;

glm::dvec3 normal_of(uint32_t texel) {
    glm::dvec3 n;
    for (int c = 0; c < 3; ++c) n[c] = 2 * static_cast<double>(texel >> (10 * c) & 1023) / 1023 - 1;
    return texel >> 30 ? n : glm::dvec3(0);
}

glm::dmat4 matrix(const std140::mat4& m) {
    glm::dmat4 out;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) out[c][r] = static_cast<double>(m.columns[c][r]);
    return out;
}

glm::dmat3 matrix(const std140::mat3& m) {
    glm::dmat3 out;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) out[c][r] = static_cast<double>(m.columns[c][r]);
    return out;
}

// View depth of the infinite reverse-Z perspective; 0 for all that is none.
double linear_depth(const FrameBlock& block, float depth) {
    return depth > 0 && depth < 1 ? static_cast<double>(block.near_m) / static_cast<double>(depth) : 0;
}

// Distance between neighbouring numbers of an r11g11b10f channel.
double small_float_ulp(double x, int mantissa_bits) {
    return std::ldexp(1.0, (x > 0x1p-14 ? std::ilogb(x) : -14) - mantissa_bits);
}

bool bit_at(const std::vector<uint32_t>& words, int width, int x, int y) {
    const int across = (width + tile_w - 1) / tile_w;
    return words[static_cast<size_t>(y / tile_h) * across + x / tile_w] >>
               (y % tile_h * tile_w + x % tile_w) &
           1;
}

}  // namespace

// Differences of one quantity: the first one is described, all are counted, the largest is kept.
struct DenoiserCheck::Compare {
    Compare(DenoiserCheck& owner, std::string quantity) : check(owner), what(std::move(quantity)) {}
    ~Compare() { EXPECT_EQ(count, 0u) << what << ", " << count << " pixels differ; the first: " << first; }

    // Whether a value lies in [low, high], give or take the tolerance.
    static double excess(double gpu, double low, double high, double tolerance) {
        const double distance = std::max({low - gpu, gpu - high, 0.0});
        return std::isfinite(gpu) ? distance / tolerance : 1e9;
    }
    void range(size_t i, double gpu, double low, double high, double tolerance) {
        const double part = excess(gpu, low, high, tolerance);
        double& worst = check.worst_[what];
        if (part <= 1)
            worst = std::max(worst, part);
        else
            fail(i, testing::Message() << gpu << " for " << low << " .. " << high << " +- " << tolerance);
    }
    void near(size_t i, double gpu, double expected, double tolerance) {
        range(i, gpu, expected, expected, tolerance);
    }
    void same(size_t i, uint32_t gpu, uint32_t expected) {
        if (gpu != expected) fail(i, testing::Message() << std::hex << gpu << " for " << expected);
    }
    void fail(size_t i, const testing::Message& message) {
        if (count++ == 0)
            first = (testing::Message() << "element " << i << " (as a pixel " << i % check.width_ << ", "
                                        << i / check.width_ << "): " << message)
                        .GetString();
    }

    DenoiserCheck& check;
    std::string what, first;
    size_t count = 0;
};

DenoiserCheck::DenoiserCheck(Extent extent, double sampler_error_px)
    : width_(static_cast<int>(extent.width)),
      height_(static_cast<int>(extent.height)),
      sampler_error_px_(sampler_error_px) {
    const size_t n = static_cast<size_t>(width_) * height_;
    before_ = {model::Image<double>(n, 0), model::Image<model::Moments>(n), model::Image<model::Signal>(n)};
}

std::vector<std::string> DenoiserCheck::names() {
    return {"view_depth",       "guide_normal", "tile_list", "trace_args", "preloaded_hits", "receiver_words",
            "visibility_words", "reprojected",  "moments",   "tile_meta",  "filtered0",      "filtered1"};
}

void DenoiserCheck::frame(const View& view, const HostFrame& host, const FrameDescription& description) {
    block_ = make_frame_block(description);
    guides(view, host);
    classify(view, host);
    prepare(view, host);
    read_inputs(view, host);
    tileclass(view);
    filters(view);

    const auto moments = captured_planes(view, "moments");
    before_.view_depth = inputs_.view_depth;
    before_.history = signal(view, "filtered0");
    for (size_t i = 0; i < moments[0].size(); ++i)
        before_.moments[i] = {moments[0][i], moments[1][i], moments[2][i]};
}

void DenoiserCheck::guides(const View& view, const HostFrame& host) {
    const auto depth = captured<float>(view, "view_depth");
    const auto normal = captured<uint32_t>(view, "guide_normal");
    const glm::dmat3 world = matrix(block_.world_from_view);
    Compare depths(*this, "guides view_depth"), normals(*this, "guides normal");
    for (size_t i = 0; i < depth.size(); ++i) {
        const double z = linear_depth(block_, host.depth[i]);
        depths.near(i, static_cast<double>(depth[i]), z, 4e-7 * z + 1e-30);
        if (!(z > 0)) {
            normals.same(i, normal[i], 0);
            continue;
        }
        const glm::dvec3 given(host.normal[i][0], host.normal[i][1], host.normal[i][2]);
        const double length2 = glm::dot(given, given);
        const glm::dvec3 n = length2 > 1e-4 && length2 < 1e4 ? given / std::sqrt(length2) : world[2];
        for (int c = 0; c < 3; ++c)  // the nearest of 1024 steps, or its neighbour where it is a tie
            normals.near(i, normal[i] >> (10 * c) & 1023, 1023 * (0.5 * n[c] + 0.5), texel_steps(0.005));
        normals.same(i, normal[i] >> 30, 3);
    }
}

void DenoiserCheck::classify(const View& view, const HostFrame& host) {
    const auto depth = captured<float>(view, "view_depth");
    const auto normal = captured<uint32_t>(view, "guide_normal"),
               args = captured<uint32_t>(view, "trace_args"),
               hits = captured<uint32_t>(view, "preloaded_hits"),
               receivers = captured<uint32_t>(view, "receiver_words");
    const glm::dvec3 sun(host.sun.to_sun.v[0], host.sun.to_sun.v[1], host.sun.to_sun.v[2]);
    const double limit =
        host.whole_disc ? -std::sin(static_cast<double>(host.sun.angular_radius)) - 1.0 / 512 : 0;
    std::vector<uint32_t> expected_hits(hits.size(), 0), expected_receivers(hits.size(), 0);
    const int across = (width_ + tile_w - 1) / tile_w;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const size_t i = static_cast<size_t>(y) * width_ + x;
            if (!(depth[i] > 0)) continue;
            const size_t word = static_cast<size_t>(y / tile_h) * across + x / tile_w;
            const uint32_t bit = 1u << (y % tile_h * tile_w + x % tile_w);
            expected_receivers[word] |= bit;
            const glm::dvec3 n = normal_of(normal[i]);
            const double facing = glm::dot(n, sun) / glm::length(n) - limit;
            const bool rounds = std::abs(facing) < 1e-6;  // single precision may see either sign
            if (rounds ? (hits[word] & bit) != 0 : facing <= 0) expected_hits[word] |= bit;
        }
    Compare preloaded(*this, "classify preloaded_hits"), words(*this, "classify receiver_words"),
        list(*this, "classify tile_list"), arguments(*this, "classify trace_args"),
        sums(*this, "classify counters");
    std::map<uint32_t, uint32_t> tiles;  // packed position -> pixels to trace
    uint32_t receiver_count = 0, shadowed = 0;
    for (uint32_t w = 0; w < hits.size(); ++w) {
        preloaded.same(w, hits[w], expected_hits[w]);
        words.same(w, receivers[w], expected_receivers[w]);
        const uint32_t undecided = expected_receivers[w] & ~expected_hits[w];
        if (undecided)
            tiles[w % static_cast<uint32_t>(across) | w / static_cast<uint32_t>(across) << 16] = undecided;
        receiver_count += static_cast<uint32_t>(std::popcount(expected_receivers[w]));
        shadowed += static_cast<uint32_t>(std::popcount(expected_hits[w]));
    }
    const auto listed = static_cast<uint32_t>(tiles.size());
    const std::array<uint32_t, 4> wanted = {std::min(listed, 32768u), (listed + 32767) / 32768,
                                            listed ? 1u : 0u, listed};
    for (size_t i = 0; i < 4; ++i) arguments.same(i, args[i], wanted[i]);
    const auto counters = counters_of(view, "classify");
    sums.same(0, counters.at("receivers"), receiver_count);
    sums.same(1, counters.at("lit"), 0);
    sums.same(2, counters.at("shadowed"), shadowed);
    sums.same(3, counters.at("unknown"), receiver_count - shadowed);
    sums.same(4, counters.at("tiles_listed"), listed);

    const auto records = captured<std::array<uint32_t, 4>>(view, "tile_list");
    const auto whole_ray = std::bit_cast<uint32_t>(1e30f);
    for (uint32_t i = 0; i < std::min<uint32_t>(args[3], static_cast<uint32_t>(records.size())); ++i) {
        const auto& [position, mask, t_min, t_max] = records[i];
        list.same(i, static_cast<uint32_t>(tiles.contains(position)), 1);  // once: it is erased below
        if (tiles.contains(position)) list.same(i, mask, tiles[position]);
        list.same(i, t_min, 0);
        list.same(i, t_max, whole_ray);
        tiles.erase(position);
    }
    list.same(records.size(), static_cast<uint32_t>(tiles.size()), 0);
}

void DenoiserCheck::prepare(const View& view, const HostFrame& host) {
    const auto visibility = captured<uint32_t>(view, "visibility_words"),
               receivers = captured<uint32_t>(view, "receiver_words");
    Compare words(*this, "prepare visibility_words");
    for (size_t w = 0; w < visibility.size(); ++w) words.same(w, visibility[w], ~host.hits[w] & receivers[w]);
}

// The model's inputs from what the device's tileclass read.
void DenoiserCheck::read_inputs(const View& view, const HostFrame& host) {
    const auto depth = captured<float>(view, "view_depth");
    const auto normal = captured<uint32_t>(view, "guide_normal"),
               words = captured<uint32_t>(view, "visibility_words");
    const glm::dmat4 clip = matrix(block_.clip_from_view), previous = matrix(block_.prev_clip_from_rel);
    const glm::dmat3 world = matrix(block_.world_from_view);
    inputs_ = model::flat_receiver(width_, height_);
    inputs_.reset = (block_.flags & frame_reset) != 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const size_t i = static_cast<size_t>(y) * width_ + x;
            const double z = static_cast<double>(depth[i]);
            const glm::dvec2 uv = (glm::dvec2(x, y) + 0.5) / glm::dvec2(width_, height_) -
                                  glm::dvec2(block_.jitter.v[0], block_.jitter.v[1]);
            const glm::dvec2 ndc = 2.0 * uv - 1.0;
            const glm::dvec3 ray =
                world * glm::dvec3(ndc.x / clip[0].x, ndc.y / clip[1].y, -1);  // at view depth 1
            const glm::dvec3 n = normal_of(normal[i]);
            inputs_.lit[i] = bit_at(words, width_, x, y);
            inputs_.view_depth[i] = z;
            inputs_.expected_depth[i] = (previous * glm::dvec4(z * ray, 1)).w;
            inputs_.normal[i] = {n.x, n.y, n.z};
            inputs_.facing[i] = z > 0 ? glm::dot(n, -ray) / (glm::length(n) * glm::length(ray)) : 0;
            inputs_.motion[i] = {static_cast<double>(host.motion[i][0]),
                                 static_cast<double>(host.motion[i][1])};
        }
}

void DenoiserCheck::tileclass(const View& view) {
    const model::DenoiserSettings exact{.storage = model::Storage::exact};
    const model::DenoiserFrame expected = model::classify_tiles(inputs_, before_, exact);
    const auto meta = captured<uint32_t>(view, "tile_meta");
    Compare states(*this, "tileclass tile_meta");
    tile_meta_ = expected.tile_meta;
    for (size_t i = 0; i < meta.size(); ++i) states.same(i, meta[i], static_cast<uint32_t>(tile_meta_[i]));

    // A store may round either way; arithmetic in single precision adds the constant.
    const auto reprojected = captured_planes(view, "reprojected"), moments = captured_planes(view, "moments");
    struct Quantity {
        const char* name;
        const std::vector<float>& gpu;
        double (*of)(const model::DenoiserFrame&, size_t);
        double (*tolerance)(double);
    };
    const std::array<Quantity, 5> quantities = {{
        {"tileclass visibility", reprojected[0],
         [](const auto& f, size_t i) { return f.reprojected[i].visibility; },
         [](double x) { return half_ulp(x) + 1e-5; }},
        {"tileclass variance", reprojected[1],
         [](const auto& f, size_t i) { return f.reprojected[i].variance; },
         [](double x) { return half_ulp(x) + 1e-5 * (1 + std::abs(x)); }},
        {"tileclass mean", moments[0], [](const auto& f, size_t i) { return f.moments[i].mean; },
         [](double x) { return small_float_ulp(x, 6) + 1e-5; }},
        {"tileclass deviations", moments[1], [](const auto& f, size_t i) { return f.moments[i].deviations; },
         [](double x) { return small_float_ulp(x, 6) + 1e-5; }},
        {"tileclass count", moments[2], [](const auto& f, size_t i) { return f.moments[i].count; },
         [](double x) { return small_float_ulp(x, 5) + 1e-5 * (1 + std::abs(x)); }},
    }};
    std::set<size_t> apart;
    for (size_t i = 0; i < inputs_.lit.size(); ++i) {
        const size_t x = i % width_, y = i / width_;
        const bool work =
            tile_meta_[y / 8 * ((static_cast<size_t>(width_) + 7) / 8) + x / 8] == model::BlockState::work;
        worked_ += work && inputs_.view_depth[i] > 0;
        for (const Quantity& q : quantities) {
            const double e = q.of(expected, i), g = static_cast<double>(q.gpu[i]);
            if (!(Compare::excess(g, e, e, q.tolerance(e)) <= 1)) apart.insert(i);
        }
    }
    // Where the inputs lie on a threshold (the texel that holds the previous position, the image's border,
    // the depth's tolerance), rounding decides: moved by no more than rounding moves it, the model gives the
    // range of answers.
    std::vector<model::DenoiserFrame> moved;
    if (!apart.empty()) {
        const model::DenoiserInputs here = inputs_;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                for (auto& motion : inputs_.motion) {
                    motion[0] += dx * sampler_error_px_ / width_;
                    motion[1] += dy * sampler_error_px_ / height_;
                }
                for (double& z : inputs_.expected_depth) z *= 1 + 1e-6 * (dx + 3 * dy);
                moved.push_back(model::classify_tiles(inputs_, before_, exact));
                inputs_ = here;
            }
        on_threshold_ += apart.size();
    }
    for (const Quantity& q : quantities) {
        Compare compare(*this, q.name);
        for (size_t i = 0; i < inputs_.lit.size(); ++i) {
            const double e = q.of(expected, i);
            double low = e, high = e;
            if (apart.contains(i))
                for (const model::DenoiserFrame& f : moved) {
                    low = std::min(low, q.of(f, i));
                    high = std::max(high, q.of(f, i));
                }
            compare.range(i, static_cast<double>(q.gpu[i]), low, high, q.tolerance(high));
        }
    }
}

model::Image<model::Signal> DenoiserCheck::signal(const View& view, const std::string& name) const {
    const auto planes = captured_planes(view, name);
    model::Image<model::Signal> image(planes[0].size());
    for (size_t i = 0; i < image.size(); ++i) image[i] = {planes[0][i], planes[1][i]};
    return image;
}

void DenoiserCheck::filters(const View& view) {
    const std::array<std::string, 3> from = {"reprojected", "filtered0", "filtered1"},
                                     to = {"filtered0", "filtered1", "visibility"};
    for (size_t i = 0; i < 3; ++i) {
        const auto expected =
            model::filter(inputs_, tile_meta_, signal(view, from[i]), 1 << i, model::Storage::exact);
        const auto gpu = captured_planes(view, to[i]);
        Compare visibility(*this, to[i] + " visibility"), variance(*this, to[i] + " variance");
        for (size_t p = 0; p < expected.size(); ++p) {
            const model::Signal& e = expected[p];
            if (i < 2) {
                visibility.near(p, static_cast<double>(gpu[0][p]), e.visibility,
                                half_ulp(e.visibility) + 1e-5);
                variance.near(p, static_cast<double>(gpu[1][p]), e.variance,
                              half_ulp(e.variance) + 1e-5 * (1 + e.variance));
            } else {
                visibility.near(p, 255 * static_cast<double>(gpu[0][p]), 255 * model::with_contrast(e),
                                texel_steps(0.01));
            }
        }
    }
}

}  // namespace penumbra::test
