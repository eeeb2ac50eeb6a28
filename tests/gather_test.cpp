// SPDX-License-Identifier: MIT
// The estimator of node gather alone, on rays that the test casts itself: receivers of any tilt under a sun
// whose disc is partly covered by straight edges, so that every pixel's visibility is known in closed form.
// The rays, their hits and the sun's points are handed to the node as a tracer would.
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <set>

#include "shaders/common/blocks.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr Extent extent{96, 64};
constexpr double small_sun_deg = 0.1;
constexpr double middle_m = 10;  // view depth of the image's centre

constexpr const char* gather_alone = R"({
  "penumbra": 1, "name": "gather_alone",
  "inputs": { "depth": {}, "normal": {}, "motion": {}, "sun": {}, "visibility_words": {}, "receiver_words": {},
              "sunward_words": {}, "blockers": {}, "ray_points": {} },
  "outputs": ["state"],
  "nodes": {
    "guides": { "type": "guides" },
    "gather": { "type": "gather", "params": { "radius": RADIUS },
                "in": { "history": "state@-1", "idle_cells_prev": "idle_cells@-1",
                        "view_depth_prev": "view_depth@-1", "guide_normal_prev": "guide_normal@-1" } },
    "drift": { "type": "drift" }
  }
})";

// Columns: the axes across the light, and the sun (Duff et al. 2017, as sun_sample.glsl names it).
glm::dmat3 light_axes(const glm::dvec3& s) {
    const double sign = s.z >= 0 ? 1 : -1, a = -1 / (sign + s.z), b = s.x * s.y * a;
    return {glm::dvec3(1 + sign * s.x * s.x * a, sign * b, -sign * s.x),
            glm::dvec3(b, sign + s.y * s.y * a, -s.y), s};
}

// Share of a disc of radius 1 beyond a straight edge at `d` from its centre, positive: the centre is lit.
double disc_share(double d) {
    if (d >= 1) return 1;
    if (d <= -1) return 0;
    return 0.5 + (std::asin(d) + d * std::sqrt(1 - d * d)) / std::numbers::pi;
}

// An edge that hangs `distance_m` above the image's centre, seen from the sun at an angle.
struct Edge {
    double distance_m, angle_deg, offset_m = 0;
};

struct Setting {
    double tilt_deg = 0;
    std::vector<Edge> edges;
    uint32_t seed = 1;
    bool mirrored = false;                                 // hands over sun points with x negated
    int radius = 4;                                        // of the taps
    std::function<double(int x, int y)> step_m = nullptr;  // moves the receiver along its normal
    std::function<bool(int x, int y)> averted = nullptr;   // pixels that look away from the sun
    std::function<bool(int x, int y)> above = nullptr;     // pixels whose surface lies above the edges
    double sun_radius_deg = small_sun_deg;
    double sun_elevation_deg = 45;  // over the receiver
    uint32_t frame = 0;             // others know the one before
};

struct Receiver {
    glm::dvec3 normal, sun;
};

Receiver receiver_of(const Setting& setting) {
    const double tilt = glm::radians(setting.tilt_deg), elevation = glm::radians(setting.sun_elevation_deg);
    const glm::dvec3 n(0, std::sin(tilt), std::cos(tilt));
    return {n, std::sin(elevation) * n + std::cos(elevation) * glm::dvec3(1, 0, 0)};
}

double pixel_m(const Camera& camera) {
    return middle_m * 2 / (extent.height * std::abs(camera.clip_from_view[5]));
}

Camera narrow_camera() {
    Camera camera = camera_at({0, 0, 0}, 0, extent);
    camera.clip_from_view[0] *= 40;
    camera.clip_from_view[5] *= 40;
    return camera;
}

// The distance at which the penumbra is `width_px` wide on a receiver seen face on and lit along its normal.
double distance_for(double width_px, double sun_radius_deg = small_sun_deg) {
    return 0.5 * width_px * pixel_m(narrow_camera()) / std::tan(glm::radians(sun_radius_deg));
}

// Whether the ray from `at` (light space, from the image's centre) to a point of the disc passes an edge.
bool is_lit(const Edge& edge, const glm::dvec3& at, double tangent, const glm::dvec2& point) {
    const double angle = glm::radians(edge.angle_deg);
    const glm::dvec2 across = glm::dvec2(at) + (edge.distance_m - at.z) * tangent * point;
    return glm::dot(across, glm::dvec2(std::cos(angle), std::sin(angle))) < edge.offset_m;
}

// By a grid of points: where edges and the receiver's own horizon cut the disc together.
double share_of_disc(const std::function<bool(const glm::dvec2&)>& lit) {
    constexpr int side = 40;
    int inside = 0, free = 0;
    for (int i = 0; i < side * side; ++i) {
        const glm::dvec2 q = (2.0 * (glm::dvec2(i % side, i / side) + 0.5)) / double(side) - 1.0;
        if (glm::dot(q, q) > 1) continue;
        ++inside;
        free += lit(q);
    }
    return double(free) / inside;
}

struct Result {
    std::vector<double> now, past, truth;
    std::vector<bool> bit, counted;
};

// `cpu`: with the workgroups of a software device, else of a GPU.
ViewRun run_with(int radius, bool cpu = true) {
    std::string text = gather_alone;
    text.replace(text.find("RADIUS"), 6, std::to_string(radius));
    ViewRunOptions options;
    options.cpu = cpu;
    options.captures = {"gathered"};
    options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}};
    return ViewRun(shadow_pipeline(text), extent, options);
}

Result gather(ViewRun& run, const Setting& setting) {
    const Camera camera = narrow_camera();
    const Receiver receiver = receiver_of(setting);
    const glm::dvec3 n = receiver.normal, sun = receiver.sun;
    const double sun_radius = glm::radians(setting.sun_radius_deg), tangent = std::tan(sun_radius);
    const glm::dmat3 axes = light_axes(sun);
    const glm::dvec3 centre = glm::transpose(axes) * glm::dvec3(0, 0, -middle_m);

    std::mt19937 random(setting.seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<uint32_t> points, given;
    while (points.size() < size_t{extent.width} * extent.height) {
        const glm::vec2 p(uniform(random), uniform(random));
        if (glm::dot(p, p) > 1) continue;
        points.push_back(glm::packSnorm2x16(p));
        given.push_back(glm::packSnorm2x16(setting.mirrored ? glm::vec2(-p.x, p.y) : p));
    }

    const size_t pixels = size_t{extent.width} * extent.height;
    const uint32_t across = extent.width / 8;
    Result result{
        {}, {}, std::vector<double>(pixels), std::vector<bool>(pixels), std::vector<bool>(pixels, true)};
    std::vector<float> depth(pixels);
    std::vector<uint32_t> lit(size_t{across} * (extent.height / 4)), receivers(lit.size(), ~0u),
        sunward(lit.size()), blockers(3 * lit.size());
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const size_t i = size_t{y} * extent.width + x, word = size_t{y / 4} * across + x / 8;
            const glm::dvec2 ndc =
                2.0 * (glm::dvec2(x, y) + 0.5) / glm::dvec2(extent.width, extent.height) - 1.0;
            const glm::dvec3 way(ndc.x / camera.clip_from_view[0], ndc.y / camera.clip_from_view[5], -1);
            const double step = setting.step_m ? setting.step_m(int(x), int(y)) : 0;
            const double z = (n.z * -middle_m + step) / glm::dot(n, way);
            depth[i] = static_cast<float>(camera.near_m / z);
            const glm::dvec3 at = glm::transpose(axes) * (z * way) - centre;
            const glm::dvec2 point = glm::unpackSnorm2x16(points[i]);
            bool hit = false;
            double hit_m = 0;
            const auto meets_own_plane = [&](const glm::dvec2& q) {
                return glm::dot(n, axes * glm::dvec3(tangent * q, 1)) <= 0;
            };
            result.truth[i] = 1;
            for (const Edge& edge : setting.edges) {
                if (setting.above && setting.above(int(x), int(y))) break;
                const double angle = glm::radians(edge.angle_deg), height = edge.distance_m - at.z;
                const glm::dvec2 normal(std::cos(angle), std::sin(angle));
                const double rho = height * tangent,
                             inside = edge.offset_m - glm::dot(glm::dvec2(at), normal);
                // Edges never cover each other's part of the disc in these tests.
                result.truth[i] += disc_share(inside / rho) - 1;
                if (is_lit(edge, at, tangent, point)) continue;
                hit = true;
                hit_m = std::max(hit_m, height);
            }
            if (setting.sun_elevation_deg < setting.sun_radius_deg)
                result.truth[i] = share_of_disc([&](const glm::dvec2& q) {
                    return !meets_own_plane(q) && std::ranges::all_of(setting.edges, [&](const Edge& edge) {
                        return is_lit(edge, at, tangent, q);
                    });
                });
            hit = hit || meets_own_plane(point);
            const uint32_t bit = 1u << (y % 4 * 8 + x % 8);
            if (setting.averted && setting.averted(int(x), int(y))) {
                result.counted[i] = false;
                continue;  // dark, whatever the ray says
            }
            sunward[word] |= bit;
            result.bit[i] = !hit;
            if (!hit) lit[word] |= bit;
            if (hit_m > 0) {  // the receiver itself is no blocker
                const auto steps = static_cast<uint32_t>((std::log2(hit_m) + 32) * 64 + 0.5);
                blockers[3 * word] += 1;
                blockers[3 * word + 1] += steps;
                blockers[3 * word + 2] += steps * steps;
            }
        }
    run.set("depth", depth);
    run.set("normal", std::vector<uint64_t>(pixels, glm::packHalf4x16(glm::vec4(glm::vec3(n), 0))));
    run.set("motion", std::vector<uint64_t>(pixels, 0));
    const blocks::Sun block{{{float(sun.x), float(sun.y), float(sun.z)}}, float(sun_radius)};
    run.set("sun", std::as_bytes(std::span(&block, 1)));
    run.set("visibility_words", lit);
    run.set("receiver_words", receivers);
    run.set("sunward_words", sunward);
    run.set("blockers", blockers);
    run.set("ray_points", given);
    run.frame(frame_between(camera, camera, extent, setting.frame, setting.frame == 0));
    for (const auto& words : captured<std::array<uint32_t, 2>>(run.view(), "gathered")) {
        result.now.push_back((words[0] & 0x7ff) / 2046.0);
        result.past.push_back((words[0] >> 11 & 0x7ff) / 2046.0);
    }
    return result;
}

bool in_penumbra(double v) {
    return v >= 1.0 / 256 && v <= 255.0 / 256;
}

struct Share {
    double signal = 0, error = 0;
    double n_eff() const { return signal / error; }
};

void add(Share& share, const Result& r, const std::function<bool(int, int)>& counted = {}) {
    for (size_t i = 0; i < r.now.size(); ++i) {
        if (!r.counted[i] || (counted && !counted(int(i % extent.width), int(i / extent.width)))) continue;
        if (in_penumbra(r.truth[i])) share.signal += r.truth[i] * (1 - r.truth[i]);
        share.error += (r.now[i] - r.truth[i]) * (r.now[i] - r.truth[i]);
    }
}

class Gather : public GpuTest {
  protected:
    Result gather(const Setting& setting) {
        const auto [run, made] = runs_.try_emplace(setting.radius);
        if (made) run->second = std::make_unique<ViewRun>(run_with(setting.radius));
        return test::gather(*run->second, setting);
    }
    double n_eff(Setting setting, uint32_t seeds = 4) {
        Share share;
        for (setting.seed = 1; setting.seed <= seeds; ++setting.seed) add(share, gather(setting));
        return share.n_eff();
    }

  private:
    std::map<int, std::unique_ptr<ViewRun>> runs_;  // by the radius of the taps
};

// White noise: the shipped tracer's blue noise does better (docs/denoiser.md).
TEST_F(Gather, CountsItsNeighboursRaysAtEveryAngle) {
    for (const double angle : {0.0, 17.0, 45.0, 70.0, 90.0, 110.0, 135.0, 160.0}) {
        SCOPED_TRACE(angle);
        EXPECT_GT(n_eff({.edges = {{distance_for(8), angle}}}), 35);
        EXPECT_GT(n_eff({.edges = {{distance_for(16), angle}}}), 60);
    }
}

// Which invocation works on which cell depends on the workgroup's shape and on the order of its list.
TEST_F(Gather, SaysTheSameInEveryWorkgroup) {
    ViewRun narrow = run_with(4), square = run_with(4, false);
    const Setting setting{.edges = {{distance_for(12), 17}},
                          .averted = [](int x, int y) { return (x / 5 + y / 3) % 4 == 0; }};
    EXPECT_EQ(penumbra::test::gather(narrow, setting).now, penumbra::test::gather(square, setting).now);
}

TEST_F(Gather, AsksMoreNeighboursWhereItIsToldTo) {
    const auto at = [&](int radius) {
        return n_eff({.edges = {{distance_for(16), 17}}, .radius = radius}, 6);
    };
    const double few = at(3), usual = at(4), many = at(5);
    EXPECT_GT(usual, 1.1 * few);
    EXPECT_GT(many, 1.1 * usual);
}

// A sun whose axis is mirrored between tracer and denoiser: every neighbour's ray is taken to test another
// place than it does: 19 to 32 instead of 52 to 61 (90 degrees is not among these: such an edge does not
// depend on the mirrored axis).
TEST_F(Gather, FailsThatWithAMirroredSun) {
    for (const double angle : {0.0, 17.0, 45.0, 135.0, 160.0}) {
        SCOPED_TRACE(angle);
        const std::vector<Edge> edge = {{distance_for(8), angle}};
        EXPECT_LT(n_eff({.edges = edge, .mirrored = true}), 0.65 * n_eff({.edges = edge}));
    }
}

// The mean over many seeds is the truth: what is left of the squared error of the mean is what the deviation
// between seeds explains.
TEST_F(Gather, IsUnbiasedInAStraightPenumbra) {
    for (const double width : {4.0, 8.0, 24.0}) {
        SCOPED_TRACE(width);
        Setting setting{.edges = {{distance_for(width), 17}}};
        constexpr int seeds = 24;
        std::vector<double> sum, squares, truth;
        for (setting.seed = 1; setting.seed <= seeds; ++setting.seed) {
            const Result r = gather(setting);
            sum.resize(r.now.size());
            squares.resize(r.now.size());
            truth = r.truth;
            for (size_t i = 0; i < r.now.size(); ++i) {
                sum[i] += r.now[i];
                squares[i] += r.now[i] * r.now[i];
            }
        }
        double signal = 0, bias2 = 0, mean_error = 0;
        size_t n = 0;
        for (size_t i = 0; i < truth.size(); ++i) {
            if (!in_penumbra(truth[i])) continue;
            const double mean = sum[i] / seeds, variance = (squares[i] - sum[i] * mean) / (seeds - 1);
            bias2 += (mean - truth[i]) * (mean - truth[i]) - variance / seeds;
            mean_error += mean - truth[i];
            signal += truth[i] * (1 - truth[i]);
            ++n;
        }
        EXPECT_GT(signal / std::max(bias2, 1e-9), width < 8 ? 150 : 400);  // as effective samples
        EXPECT_LT(std::abs(mean_error / double(n)), 0.01);
    }
}

TEST_F(Gather, IsTheRayItselfBelowAPixel) {
    const Result r = gather({.edges = {{distance_for(0.9), 17}}});
    for (size_t i = 0; i < r.now.size(); ++i) ASSERT_EQ(r.now[i], r.bit[i] ? 1 : 0) << i;
}

// No halo: beyond the penumbra by more than the distance's fixed point (half of 1/64 octave) everything is
// exact.
TEST_F(Gather, IsExactBesideThePenumbra) {
    for (const double width : {2.0, 8.0, 32.0}) {
        const Result r = gather({.edges = {{distance_for(width), 17}}});
        const Result wider = gather({.edges = {{1.03 * distance_for(width), 17}}});
        for (size_t i = 0; i < r.now.size(); ++i) {
            if (wider.truth[i] > 0 && wider.truth[i] < 1) continue;
            ASSERT_EQ(r.now[i], wider.truth[i]) << width << ", " << i;
        }
    }
}

// All rays say "lit" of a sudden: where a cell's own rays have said so before, that is all there is, and
// where they have not, drift has to judge between them. Most of the dark cells had no work in the first
// frame.
TEST_F(Gather, KeepsAPastThatItsRaysContradict) {
    ViewRun run = run_with(4);
    const Result before = test::gather(run, {.edges = {{distance_for(2), 20}}});
    const Result after = test::gather(run, {.edges = {}, .frame = 1});
    const auto cell_of = [](size_t i) { return std::pair(i % extent.width / 4, i / extent.width / 4); };
    std::set<std::pair<size_t, size_t>> dark_cells;
    for (size_t i = 0; i < before.bit.size(); ++i)
        if (!before.bit[i]) dark_cells.insert(cell_of(i));
    ASSERT_GT(dark_cells.size(), before.bit.size() / 16 / 4);
    for (size_t i = 0; i < before.bit.size(); ++i) {
        ASSERT_EQ(after.now[i], 1) << "pixel " << i;
        if (!dark_cells.contains(cell_of(i))) continue;
        ASSERT_NEAR(after.past[i], before.now[i], 1.0 / 1023) << "pixel " << i;
    }
}

TEST_F(Gather, HoldsAtGrazingViews) {
    for (const double tilt : {60.0, 75.0, 85.0})
        for (const double angle : {0.0, 17.0, 45.0, 90.0, 135.0}) {
            SCOPED_TRACE(testing::Message() << tilt << " degrees, edge at " << angle);
            EXPECT_GT(n_eff({.tilt_deg = tilt, .edges = {{distance_for(8), angle}}}), tilt < 80 ? 8 : 1.5);
            EXPECT_GT(n_eff({.tilt_deg = tilt, .edges = {{distance_for(24), angle}}}), tilt < 80 ? 40 : 12);
        }
}

// A step in the receiver: rays of the other side are somebody else's, unless they lie on the same plane.
TEST_F(Gather, KeepsTwoReceiversApart) {
    Setting flat{.edges = {{distance_for(12), 17}}}, step = flat;
    step.step_m = [](int x, int) { return x < 44 ? 0.3 : 0.0; };
    const auto near_step = [](int x, int) { return x >= 38 && x < 50; };
    Share without, with;
    for (flat.seed = step.seed = 1; flat.seed <= 6; ++flat.seed, ++step.seed) {
        add(without, gather(flat), near_step);
        add(with, gather(step), near_step);
    }
    EXPECT_GT(with.n_eff(), 0.3 * without.n_eff());
    EXPECT_GT(with.n_eff(), 15);
}

// A ledge over a floor: what hides the floor from the sun lies below the ledge. The sun stands straight
// above, so that both see it through the same place.
TEST_F(Gather, AsksNobodyOnAnotherPlane) {
    Setting setting{.edges = {{distance_for(12), 90}}, .sun_elevation_deg = 90};
    setting.above = [](int x, int) { return x < 44; };
    setting.step_m = [&](int x, int y) { return setting.above(x, y) ? 0.3 : 0.0; };
    for (setting.seed = 1; setting.seed <= 3; ++setting.seed) {
        const Result r = gather(setting);
        for (int y = 0; y < int(extent.height); ++y)
            for (int x = 36; x < 44; ++x)
                ASSERT_GT(r.now[size_t(y) * extent.width + x], 0.99) << x << ", " << y;
    }
}

// Surfaces that look away from the sun are dark for a reason of their own.
TEST_F(Gather, DoesNotTakeDarkFacesForBlockers) {
    Setting setting{.edges = {{distance_for(12), 0, 1.0}}};  // the edge lies outside of the image
    setting.averted = [](int x, int y) { return (x + y) % 7 == 0; };
    const Result r = gather(setting);
    for (size_t i = 0; i < r.now.size(); ++i) ASSERT_EQ(r.now[i], r.counted[i] ? 1 : 0) << i;
}

TEST_F(Gather, IsAsGoodAtTheBorder) {
    Share border, inside;
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const Result r = gather({.edges = {{distance_for(24), 0}}, .seed = seed});
        const auto at_border = [](int, int y) { return y < 4 || y >= int(extent.height) - 4; };
        add(border, r, at_border);
        add(inside, r, [&](int x, int y) { return !at_border(x, y); });
    }
    EXPECT_GT(border.n_eff(), 0.3 * inside.n_eff());
}

// A sun that has half set behind the receiver's own plane, beside an edge: rays to its lower half meet the
// receiver, whatever the blockers do. They are no samples of the edge, and their share of the disc is known:
// sheared as if a blocker had stopped them, they leave 67 to 72 effective samples instead of 95 to 138.
TEST_F(Gather, KnowsWhatTheReceiversOwnPlaneHides) {
    for (const double elevation : {-0.8, 0.0, 0.8}) {
        SCOPED_TRACE(elevation);
        Setting setting{.sun_radius_deg = 2, .sun_elevation_deg = elevation};
        const glm::dmat3 axes = light_axes(receiver_of(setting).sun);
        const glm::dvec2 sideways(axes[0].y, axes[1].y);  // the image's vertical, across the light
        setting.edges = {{distance_for(12, 2), glm::degrees(std::atan2(sideways.y, sideways.x))}};
        // Where blockers are near: on the lit side there is nothing to shear by, and the own ray is all.
        const auto beside_the_edge = [](int, int y) { return y >= 28 && y < 36; };
        Share share;
        for (setting.seed = 1; setting.seed <= 4; ++setting.seed)
            add(share, gather(setting), beside_the_edge);
        EXPECT_GT(share.n_eff(), 83);
    }
}

// Two edges at distances of 1 : 4 whose penumbrae lie side by side: no single distance is right.
TEST_F(Gather, SurvivesSeveralBlockers) {
    const double far = distance_for(24), near = distance_for(6), px = pixel_m(narrow_camera());
    EXPECT_GT(n_eff({.edges = {{far, 0, 14 * px}, {near, 180, 2 * px}}}), 8);
}

}  // namespace
}  // namespace penumbra::test
