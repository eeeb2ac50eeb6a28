// SPDX-License-Identifier: MIT
// Hard cases 13 to 25 and 56: where rays start, what they meet, what must stay attached. Whole pipelines
// where the question is one of pictures, the processor's traversal (bit for bit that of the shader) where it
// is one of rays.
#include <xmmintrin.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <limits>

#include "host/bvh/bvh.h"
#include "host/generated/noise.h"
#include "tests/bvh_oracle.h"
#include "tests/hard_cases/hard_cases.h"

namespace penumbra::test {
namespace {

using Oracle = decltype(against({}, {}, 0.0));  // clear, blocked, either

constexpr float whole_ray = std::numeric_limits<float>::infinity();

Ray ray_between(const glm::vec3& from, const glm::vec3& to) {
    const glm::vec3 d = to - from;
    return {{from.x, from.y, from.z}, {d.x, d.y, d.z}, 0, whole_ray};
}

std::vector<Triangle> triangles_of(const Shape& shape) {
    std::vector<Triangle> out(shape.indices.size() / 3);
    for (size_t i = 0; i < shape.indices.size(); ++i)
        for (int a = 0; a < 3; ++a) out[i / 3].v[i % 3][a] = shape.positions[shape.indices[i]][a];
    return out;
}

// Moeller and Trumbore 1997 as it is usually written, in single precision.
bool moeller_trumbore(const Triangle& t, const Ray& ray, float epsilon) {
    const glm::vec3 v0 = glm::make_vec3(t.v[0]), e1 = glm::make_vec3(t.v[1]) - v0,
                    e2 = glm::make_vec3(t.v[2]) - v0;
    const glm::vec3 d = glm::make_vec3(ray.direction), p = glm::cross(d, e2);
    const float det = glm::dot(e1, p);
    if (std::abs(det) <= epsilon) return false;
    const glm::vec3 s = glm::make_vec3(ray.origin) - v0;
    const float u = glm::dot(s, p) / det;
    if (u < 0 || u > 1) return false;
    const glm::vec3 q = glm::cross(s, e1);
    const float v = glm::dot(d, q) / det;
    return v >= 0 && u + v <= 1 && glm::dot(e2, q) / det > ray.t_min;
}

// ---- 13, 22, 56: where rays start

Shape scaled(Shape shape, double by) {
    for (glm::vec3& p : shape.positions) p *= float(by);
    return shape;
}

TEST_F(HardCase, AFloorUnderALowSunDoesNotShadeItselfAtAnyScale) {
    for (const double scale : {1e-3, 1.0, 1e3, 1e5}) {
        Shot shot = scene_shot("floor" + std::to_string(scale),
                               {{"floor", scaled(ground(10, 10, 1, 1), scale)}}, {320, 180});
        shot.camera = {{0, glm::dvec3(0.3, 3, 4) * scale, {0, 0, 0}, {0, 1, 0}}};
        shot.near *= scale;
        shot.sun = {{0, {std::cos(0.7), std::tan(glm::radians(1.0)), std::sin(0.7)}}};
        shot.sun_angular_radius_deg = 0.2665;
        const auto acne = [&](const RunOptions& options) {
            ShotRun run("raw", shot, options);
            const std::vector<float> v = run.frame(0, true);
            return share(count_if(v, [](float x) { return x < 1; }), v.size());
        };
        const double naive = acne({.settings = {"nodes.trace.params.origin=published"}}), ours = acne({});
        figure(("case 13, share of a lit floor that shades itself at scale " + std::to_string(scale)).c_str(),
               naive, ours);
        EXPECT_EQ(ours, 0);
        EXPECT_GE(naive, scale < 1e4 ? 0 : 0.01);
    }
}

// Floor pixels in the core shadow of a sheet that stands on the floor, up to 4 cm from it. A pixel is 8 mm
// there.
struct Band {
    std::vector<float> values;
};

Band beside_the_sheet(const std::string& pipeline, uint32_t frames, double radius_deg, double height,
                      const RunOptions& options) {
    Shot shot = scene_shot(
        "sheet" + std::to_string(height),
        {{"floor", ground(2, 2, 2, 2)}, {"sheet", box({-1, 0, -0.0005}, {1, height, 0.0005})}}, {320, 180});
    shot.camera = {{0, {0, 0.6, -0.6}, {0, 0, -0.05}, {0, 1, 0}}};
    shot.sun = {{0, {0, 1, 1}}};
    shot.sun_angular_radius_deg = radius_deg;
    RunOptions with_depth = options;
    with_depth.captures = {"view_depth"};
    ShotRun run(pipeline, shot, with_depth);
    const std::vector<float> v = run.up_to(frames - 1), z = run.plane("view_depth");
    const Camera camera = camera_at(shot, 0, 320.0 / 180);
    const Extent extent{320, 180};
    const PlaneImages floor = see_plane({}, camera, camera, extent);
    Band band;
    for (size_t i = 0; i < v.size(); ++i) {
        if (!(std::abs(z[i] - floor.view_depth[i]) < 1e-3f)) continue;
        const double uv_x = (double(i % 320) + 0.5) / 320, uv_y = (double(i / 320) + 0.5) / 180;
        const glm::dvec3 world = glm::make_vec3(camera.position.data()) +
                                 double(z[i]) * (glm::dmat3(glm::make_mat3(camera.world_from_view.data())) *
                                                 glm::dvec3((2 * uv_x - 1) / camera.clip_from_view[0],
                                                            (2 * uv_y - 1) / camera.clip_from_view[5], -1));
        const double away = -0.0005 - world.z;
        if (away > 0 && away < std::min(0.04, 0.9 * height) && std::abs(world.x) < 0.3)
            band.values.push_back(v[i]);
    }
    return band;
}

TEST_F(HardCase, AShadowStartsAtTheFootOfAThinSheet) {
    const auto leak = [](const RunOptions& options) {
        const Band band = beside_the_sheet("raw", 1, 0, 0.2, options);
        EXPECT_GT(band.values.size(), 500u);
        return share(count_if(band.values, [](float v) { return v > 0.05f; }), band.values.size());
    };
    const double naive = leak({.settings = {"nodes.trace.params.origin=published"}}), ours = leak({});
    figure("case 22, share of the first 4 cm behind a sheet that is lit", naive, ours);
    EXPECT_EQ(ours, 0);
    EXPECT_GT(naive, 0.3);
}

// One pixel of shadow between light and light: after a jitter's period of 16 frames it is there.
TEST_F(HardCase, AContactShadowOfOnePixelSurvivesTheDenoiser) {
    const auto brightest = [](const std::string& pipeline, uint32_t frames) {
        const Band band = beside_the_sheet(pipeline, frames, 0.2665, 0.008, {});
        EXPECT_GT(band.values.size(), 50u);
        return band.values.empty() ? 1 : std::ranges::max(band.values);
    };
    for (const uint32_t frames : {1u, 8u, 16u}) {
        const std::string after = " after frames: " + std::to_string(frames);
        figure(("case 56, brightest pixel of a contact shadow" + after).c_str(),
               brightest("fidelityfx", frames), brightest("shadows_fast", frames));
        figure(("case 56, of the rays" + after).c_str(), NAN, brightest("raw", frames));
    }
    const float naive = brightest("fidelityfx", 16), ours = brightest("shadows_fast", 16);
    EXPECT_LT(ours, 0.1);
    EXPECT_GT(naive, 0.1);
}

// ---- 21: facets

// A convex solid of few facets: what faces the sun is lit, whatever its neighbours do. Naive: who shades it
// with the normals of the ball that it stands for lights parts whose facets are turned away, and these are
// dark.
TEST_F(HardCase, AFacetedBallCastsNothingOnItsLitFacets) {
    std::vector<ProfilePoint> profile;
    for (int i = 0; i <= 8; ++i) {
        const double angle = (i / 8.0 - 0.5) * 0.98 * M_PI;
        profile.push_back({std::sin(angle), std::cos(angle)});
    }
    Shot shot = scene_shot("ball", {{"ball", lathe(profile, 8)}}, {160, 96});
    shot.camera = {{0, {-1.5, 0.6, 1.8}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = 0.2665;
    ShotRun run("raw", shot, {.captures = {"view_depth", "guide_normal"}});
    const std::vector<float> v = run.frame(0, true), z = run.plane("view_depth");
    const std::array normal = {run.plane("guide_normal", 0), run.plane("guide_normal", 1),
                               run.plane("guide_normal", 2)};
    const Camera camera = camera_at(shot, 0, 160.0 / 96);
    const glm::dvec3 sun = glm::normalize(shot.sun[0].to_sun);
    size_t ball = 0, naive = 0, facing = 0, dark = 0;
    for (size_t i = 0; i < v.size(); ++i) {
        if (!(z[i] > 0)) continue;
        ++ball;
        const glm::dvec3 facet = 2.0 * glm::dvec3(normal[0][i], normal[1][i], normal[2][i]) - 1.0;
        const glm::dvec2 uv((double(i % 160) + 0.5) / 160, (double(i / 160) + 0.5) / 96);
        const glm::dvec3 on_ball = glm::make_vec3(camera.position.data()) +
                                   double(z[i]) * (glm::dmat3(glm::make_mat3(camera.world_from_view.data())) *
                                                   glm::dvec3((2 * uv.x - 1) / camera.clip_from_view[0],
                                                              (2 * uv.y - 1) / camera.clip_from_view[5], -1));
        // 10 bits of a normal and the sun's radius.
        if (glm::dot(facet, sun) > 0.01) {
            ++facing;
            dark += v[i] < 1;
        }
        naive += glm::dot(glm::normalize(on_ball), sun) > 0.05 && v[i] == 0;
    }
    figure("case 21, share of a ball of 8x8 facets that its own light calls lit and its rays dark",
           share(naive, ball), share(dark, ball));
    EXPECT_GT(facing, ball / 4);
    EXPECT_EQ(dark, 0u);
    EXPECT_GT(naive, ball / 100);
}

// ---- 14, 15, 20: what rays meet

TEST(HardRays, NothingLeavesAClosedMeshThroughAnEdgeOrAVertex) {
    const std::vector<ProfilePoint> profile = {{-1, 0.3}, {-0.7, 0.8}, {0.1, 1}, {0.6, 0.7}, {1, 0.25}};
    const Shape solid = lathe(profile, 17);
    const std::vector<Triangle> triangles = triangles_of(solid);
    const Bvh bvh = build_bvh(triangles);
    SceneRandom random(14);
    size_t naive = 0, ours = 0;
    constexpr size_t rays = 200'000;
    for (size_t i = 0; i < rays; ++i) {
        const Triangle& t = triangles[size_t(random.in(0, double(triangles.size())))];
        const glm::vec3 a = glm::make_vec3(t.v[i % 3]), b = glm::make_vec3(t.v[(i + 1) % 3]);
        const float along = i % 4 == 0 ? 0.0f : float(random.in(0, 1));  // every fourth at a vertex
        const glm::vec3 inside(float(random.in(-0.1, 0.1)), float(random.in(-0.1, 0.1)),
                               float(random.in(-0.1, 0.1)));
        const Ray ray = ray_between(inside, a + along * (b - a));
        ours += !occluded(bvh, ray);
        naive +=
            std::ranges::none_of(triangles, [&](const Triangle& x) { return moeller_trumbore(x, ray, 0); });
    }
    figure("case 14, rays of 200 000 that leave a closed mesh at an edge", double(naive), double(ours));
    EXPECT_EQ(ours, 0u);
    EXPECT_GT(naive, 0u);
}

// Needles of `aspect` to 1 as long as `length`, met across from `distance`: shares of those certainly hit
// that are missed.
struct Needles {
    size_t certain = 0, naive = 0, ours = 0;
};

Needles needles(float length, float aspect, float distance) {
    SceneRandom random(20);
    const auto vector = [&] {
        return glm::vec3(float(random.in(-1, 1)), float(random.in(-1, 1)), float(random.in(-1, 1)));
    };
    Needles result;
    for (int i = 0; i < 5'000; ++i) {
        const glm::vec3 a = 0.1f * length * vector(), along = glm::normalize(vector());
        const glm::vec3 across = glm::normalize(glm::cross(along, glm::vec3(0.3f, 0.5f, 0.7f)));
        const glm::vec3 corners[3] = {a - across * (0.5f * length / aspect),
                                      a + across * (0.5f * length / aspect), a + along * length};
        Triangle needle;
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis) needle.v[k][axis] = corners[k][axis];
        const glm::vec3 target = (corners[0] + corners[1]) * 0.45f + corners[2] * 0.1f;
        const Ray ray = ray_between(target + glm::cross(along, across) * distance, target);
        if (against(needle, ray, 0x1p-22) != Oracle::blocked) continue;
        ++result.certain;
        result.ours += !occluded(build_bvh({&needle, 1}), ray);
        result.naive += !moeller_trumbore(needle, ray, 1e-6f);
    }
    return result;
}

TEST(HardRays, NeedlesOfAHundredThousandToOneAreMet) {
    const Needles ahead = needles(0.1f, 1e5f, 0.2f);
    figure("case 20, share of needles 1e5 : 1 that are missed", share(ahead.naive, ahead.certain),
           share(ahead.ours, ahead.certain));
    EXPECT_GT(ahead.certain, 1'000u);
    EXPECT_EQ(ahead.ours, 0u);
    EXPECT_GT(ahead.naive, ahead.certain / 2);
    for (const float aspect : {1e2f, 1e3f, 1e4f, 1e5f, 1e6f}) {
        const Needles beside = needles(0.1f, aspect, 0.001f);
        figure(("case 20, the same beside the ray's start, aspect " + std::to_string(int(aspect))).c_str(),
               share(beside.naive, beside.certain), share(beside.ours, beside.certain));
        EXPECT_GT(beside.certain, 100u);
        EXPECT_EQ(beside.ours, 0u);
    }
}

// ---- 19: surfaces on surfaces

TEST_F(HardCase, ASurfaceOnASurfaceCastsNothing) {
    size_t naive = 0, rays = 0, dark = 0, pixels = 0;
    for (const double gap : {0.0, 1e-7, 1e-6}) {
        Shape upper = ground(4, 4, 3, 3);
        for (glm::vec3& p : upper.positions) p.y = float(gap);
        const std::string key = "decal" + std::to_string(gap * 1e7);
        const auto image = [&](const std::string& name, const std::vector<Placed>& shapes) {
            ShotRun run("raw", scene_shot(key + name, shapes, {160, 96}));
            return run.frame(0, true);
        };
        const std::vector<float> one = image("a", {{"floor", ground(4, 4, 3, 3)}, {"decal", upper}}),
                                 other = image("b", {{"decal", upper}, {"floor", ground(4, 4, 3, 3)}});
        dark += count_if(one, [](float v) { return v < 1; });
        pixels += one.size();
        EXPECT_EQ(one, other) << gap;
        // Naive: from the lower surface as it is.
        if (gap == 0) continue;
        const Bvh bvh = build_bvh(triangles_of(upper));
        SceneRandom random(19);
        for (int i = 0; i < 1000; ++i, ++rays)
            naive += occluded(
                bvh, ray_between({float(random.in(-3, 3)), 0, float(random.in(-3, 3))}, {0.4f, 9, 0.2f}));
    }
    figure("case 19, share of rays that a decal above stops (naive), of dark pixels (ours)",
           share(naive, rays), share(dark, pixels));
    EXPECT_EQ(dark, 0u);
    EXPECT_EQ(naive, rays);
}

// ---- 25: numbers below the smallest normal one

TEST(HardRays, FlushingDenormalNumbersChangesNoAnswer) {
    Shape solid = lathe(std::vector<ProfilePoint>{{-1, 0.3}, {0.1, 1}, {1, 0.25}}, 9);
    solid.append(ground(3, 3, 4, 4));
    for (size_t i = 0; i < solid.positions.size(); i += 3) solid.positions[i].y += 1e-39f;
    const std::vector<Triangle> triangles = triangles_of(solid);
    const Bvh bvh = build_bvh(triangles);
    std::vector<Ray> rays;
    SceneRandom random(25);
    for (int i = 0; i < 50'000; ++i) {
        Ray ray = ray_between({float(random.in(-2, 2)), float(random.in(-1, 2)), float(random.in(-2, 2))},
                              {float(random.in(-2, 2)), float(random.in(-1, 2)), float(random.in(-2, 2))});
        ray.direction[i % 3] = i % 2 ? 1e-40f : ray.direction[i % 3];
        ray.origin[(i + 1) % 3] = i % 5 ? ray.origin[(i + 1) % 3] : -1e-41f;
        rays.push_back(ray);
    }
    const auto answers = [&](unsigned flags) {
        const unsigned before = _mm_getcsr();
        _mm_setcsr(before | flags);
        std::vector<bool> hit;
        for (const Ray& ray : rays) hit.push_back(occluded(bvh, ray));
        _mm_setcsr(before);
        return hit;
    };
    constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
    const std::vector<bool> kept = answers(0), flushed = answers(flush_to_zero | denormals_are_zero);
    size_t differ = 0, wrong = 0;
    for (size_t i = 0; i < kept.size(); ++i) {
        if (kept[i] == flushed[i]) continue;
        ++differ;
        wrong += truth(triangles, rays[i]) != Oracle::either;
    }
    figure(
        "case 25, answers of 50 000 that change with denormal numbers: all (naive), those not within "
        "rounding (ours)",
        double(differ), double(wrong));
    EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace penumbra::test
