// SPDX-License-Identifier: MIT
// The node `cover` where geometry or numbers are at their worst, against exact areas from where their rays
// start: needles, specks, triangles given twice or seen edge-on, walls that touch the receiver; scenes of any
// size, far from their frame's origin; a sun that is a point. And its budget: what is given up gets rays.
#include <algorithm>
#include <random>

#include "tests/cover_run.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

class CoverCases : public GpuTest {};

struct Error {
    double rms = 0, worst = 0;
    size_t pixels = 0, partial = 0;
    double worst_pixel[2] = {};
};

// Every `step`-th pixel of each row; `allowed` is what rounding may do to one.
Error error_of(const CoverRun& run, uint32_t step = 1) {
    Error out;
    double squares = 0;
    for (uint32_t y = 0; y < run.size()[1]; ++y)
        for (uint32_t x = y % step; x < run.size()[0]; x += step) {
            if (!run.is_receiver(x, y)) continue;
            const double exact = exact_visibility(run, x, y),
                         e = double(run.visibility[run.at(x, y)]) - exact;
            ++out.pixels;
            out.partial += exact > 0 && exact < 1;
            squares += e * e;
            if (std::abs(e) > out.worst)
                out.worst = std::abs(e), out.worst_pixel[0] = x, out.worst_pixel[1] = y;
        }
    out.rms = std::sqrt(squares / double(std::max<size_t>(out.partial, 1)));
    return out;
}

void print(const std::string& name, const Error& e) {
    std::printf("%s: rms %.4f over %zu pixels of penumbra of %zu, largest %.4f at %.0f, %.0f\n", name.c_str(),
                e.rms, e.partial, e.pixels, e.worst, e.worst_pixel[0], e.worst_pixel[1]);
}

Shape triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    return {{a, b, c}, {0, 1, 2}};
}

Shape soup(uint32_t kind) {
    std::mt19937 random(kind + 5);
    std::uniform_real_distribution<float> in(-1, 1);
    Shape out;
    const auto point = [&] { return glm::vec3(2 * in(random), 0.8f + 0.6f * in(random), 2 * in(random)); };
    for (int i = 0; i < 12; ++i) {
        const glm::vec3 a = point(), b = point(), to_sun = glm::normalize(glm::vec3(0.4f, 0.8f, 0.2f));
        const glm::vec3 tiny = 1e-4f * glm::vec3(in(random), in(random), in(random));
        switch (kind) {
            case 0:
                out.append(triangle(a, b, point()));
                break;
            case 1:
                out.append(triangle(a, b, b + tiny));
                break;  // needles
            case 2:
                out.append(triangle(a, a + 20.0f * tiny, a + 2e-3f * in(random)));
                break;  // specks
            case 3:
                out.append(triangle(a, b, a + 0.7f * to_sun));
                break;  // edge-on to some
            case 4:     // twice, and its back
                out.append(triangle(a, b, b + glm::vec3(0.3f, 0, 0.2f)));
                out.append(triangle(a, b, b + glm::vec3(0.3f, 0, 0.2f)));
                out.append(triangle(b, a, b + glm::vec3(0.3f, 0, 0.2f)));
                break;
            case 5: {  // through the floor, its corners behind every start
                glm::vec3 c = point();
                c.y = -1.5f;
                out.append(triangle(a, b, c));
                break;
            }
            default: {  // walls that stand a millimetre and less over the floor, and in it
                const float gap = 1e-3f * float(i % 3), x = 2 * in(random), z = 2 * in(random);
                out.append(triangle({x, gap, z}, {x + 0.5f, gap, z + 0.3f}, {x, 0.4f, z}));
            }
        }
    }
    return out;
}

TEST_F(CoverCases, AwkwardTrianglesHideWhatTheyHide) {
    const char* names[] = {
        "any", "needles", "specks", "edge-on", "twice", "through the floor", "walls on the floor"};
    for (uint32_t kind = 0; kind < 7; ++kind) {
        Shot shot = scene_shot("soup" + std::to_string(kind),
                               {{"soup", soup(kind)}, {"floor", ground(6, 6, 1, 1)}}, {96, 54});
        shot.camera = {{0, {0.3, 3.2, 4.1}, {0, 0, 0}, {0, 1, 0}}};
        CoverRun run(shot);
        run.frame(3);
        const Error error = error_of(run);
        print(names[kind], error);
        EXPECT_LT(error.rms, 0.012);
        EXPECT_LT(error.worst, 0.05);
        // Rays from the same pixels agree within their own noise.
        RunOptions options;
        options.settings = {"nodes.trace.params.rays_per_pixel=64"};
        ShotRun rays("raw", shot, options);
        const std::vector<float> traced = rays.frame(3, true);
        double worst = 0;
        for (size_t i = 0; i < traced.size(); ++i)
            worst = std::max(worst, std::abs(double(traced[i]) - double(run.visibility[i])));
        EXPECT_LT(worst, 0.16);
        EXPECT_LT(rms(traced, run.visibility), 0.02);
    }
}

Shape scaled(Shape shape, double by) {
    for (glm::vec3& p : shape.positions) p = glm::vec3(by * glm::dvec3(p));
    return shape;
}

TEST_F(CoverCases, AnySizeOfSceneIsAsGood) {
    for (const double scale : {1e-3, 1.0, 37.0, 1e3, 1e6}) {
        Shot shot = scene_shot(
            "scale" + std::to_string(scale),
            {{"soup", scaled(soup(0), scale)}, {"floor", scaled(ground(6, 6, 1, 1), scale)}}, {80, 45});
        shot.camera = {{0, scale * glm::dvec3(0.3, 3.2, 4.1), {0, 0, 0}, {0, 1, 0}}};
        shot.near *= scale;
        CoverRun run(shot);
        run.frame(3);
        const Error error = error_of(run);
        print("scale " + std::to_string(scale), error);
        EXPECT_LT(error.rms, 0.009);
        EXPECT_LT(error.worst, 0.03);
    }
}

// A start X from the frame's origin is rounded to u X on each axis, after some six sums: by up to 6 sqrt(3) u
// X across the light, which moves a line of a corner at distance r by 6 sqrt(3) u X / (r radius) of the
// light's, and the share by 2 / pi of that; besides the edge's own 12 u r / (l sin radius), small here. Two
// edges may add up.
TEST_F(CoverCases, FarFromTheOriginItIsOffByRoundingAlone) {
    for (const double far : {10.0, 1e3, 1e4}) {
        // Something else there puts the frame's origin half way.
        Shape other =
            triangle(glm::vec3(0, 0, -2 * far), glm::vec3(0.01, 0, -2 * far), glm::vec3(0, 0.01, -2 * far));
        Shot shot =
            scene_shot("far" + std::to_string(far),
                       {{"soup", soup(0)}, {"floor", ground(6, 6, 1, 1)}, {"other", other}}, {80, 45});
        shot.camera = {{0, {0.3, 3.2, 4.1}, {0, 0, 0}, {0, 1, 0}}};
        CoverRun run(shot);
        run.frame(3);
        const Error error = error_of(run);
        print("origin " + std::to_string(far) + " m away", error);
        const double rounding =
            2 * 2 / M_PI * 6 * std::sqrt(3.0) * 0x1p-24 * far / (0.2 * std::tan(glm::radians(1.5)));
        EXPECT_LT(error.worst, 0.03 + rounding);
        EXPECT_LT(error.rms, 0.009 + 0.25 * rounding);
    }
}

TEST_F(CoverCases, APointForASunIsOneRay) {
    for (const char* name : {"colonnade", "engine", "trees"}) {
        Shot shot = shipped_shot(name, {256, 144});
        shot.sun_angular_radius_deg = 0;
        CoverRun run(shot);
        run.frame(3);
        ShotRun rays("raw", shot);
        const std::vector<float> traced = rays.frame(3, true);
        size_t differ = 0, partial = 0;
        for (size_t i = 0; i < traced.size(); ++i) {
            differ += traced[i] != run.visibility[i];
            partial += run.visibility[i] != 0 && run.visibility[i] != 1;
        }
        std::printf("%s: %zu of %zu pixels differ, %zu are partial\n", name, differ, traced.size(), partial);
        EXPECT_LE(differ, traced.size() / 2000);
        EXPECT_LE(partial, traced.size() / 2000);
    }
}

TEST_F(CoverCases, WhatIsGivenUpGetsRays) {
    const Shot shot = shipped_shot("trees", {160, 90});
    const auto image = [&](const std::string& pipeline, const std::vector<std::string>& settings,
                           std::map<std::string, uint32_t>* counters = nullptr) {
        RunOptions options;
        options.settings = settings;
        ShotRun run(pipeline, shot, options);
        const auto v = run.up_to(3);
        if (counters) *counters = counters_of(run.session().view(), "cover");
        return v;
    };
    std::map<std::string, uint32_t> counters;
    const std::vector<float> covered = image("covered", {}),
                             best = image("covered", {"nodes.cover.params.samples=256"});
    EXPECT_TRUE(image("hybrid_shadows", {"nodes.cover.params.budget=1048576"}, &counters) == covered);
    EXPECT_EQ(counters.at("left"), 0u);
    const std::vector<float> sixteen = image("raw", {"nodes.trace.params.rays_per_pixel=16"});
    const double of_rays = rms(sixteen, best);
    for (const int budget : {1, 20, 60, 1024}) {
        const std::vector<float> v =
            image("hybrid_shadows", {"nodes.cover.params.budget=" + std::to_string(budget)}, &counters);
        std::printf("budget %d: %u of %u pixels left to rays, rms %.4f (of rays alone %.4f)\n", budget,
                    counters.at("left"), counters.at("left") + counters.at("pixels"), rms(v, best), of_rays);
        EXPECT_LT(rms(v, best), 1.1 * of_rays);
        size_t undecided = 0;
        for (size_t i = 0; i < v.size(); ++i) undecided += std::abs(double(v[i]) - double(best[i])) > 0.5;
        EXPECT_LE(undecided, 1u) << "a ray may look past a fold that coverage does not";
        if (budget == 1) {
            EXPECT_GT(counters.at("left"), 500u);
        }
    }
}

TEST_F(CoverCases, TwoRunsAndAnyMemoryGiveTheSameBits) {
    for (const char* pipeline : {"covered", "hybrid_shadows"}) {
        std::vector<std::vector<float>> first;
        for (const int variant : {0, 1, 2, 3}) {
            SessionOptions options;
            const Shot shot = shipped_shot("trees", {128, 72});
            options.size = shot.size;
            options.captures = {"visibility", "hits"};
            options.alias = variant != 2;
            if (variant == 3) options.poison = 0xffffffffu;
            const auto session = open_session(
                shipped_pipeline(pipeline, pipeline == std::string("covered")
                                               ? std::vector<std::string>{}
                                               : std::vector<std::string>{"nodes.cover.params.budget=40"}),
                shot, options);
            std::vector<std::vector<float>> images;
            for (uint32_t frame = 0; frame < 4; ++frame) {
                session->run_frame(frame, frame == 0);
                images.push_back(captured_planes(session->view(), "visibility")[0]);
            }
            if (variant == 0) first = images;
            EXPECT_TRUE(images == first) << pipeline << ", variant " << variant;
        }
    }
}

}  // namespace
}  // namespace penumbra::test
