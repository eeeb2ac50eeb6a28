// SPDX-License-Identifier: MIT
// The robust form of the node taa on images that the test fills itself, beside the published form where that
// fails: an edge under jitter becomes its area, what comes into view shows no ghost, a still image stays,
// nothing finite becomes infinite.
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>

#include "tests/taa_run.h"

namespace penumbra::test {
namespace {

// Errors of the coverage over the pixels that an edge crosses, over all frames of a jitter period.
struct EdgeError {
    double of_area = 0;  // rms
    double of_points =
        0;  // rms, against the share of the 16 jitter positions that lie inside: the average's own error
    double elsewhere = 0;  // largest, in pixels that the edge does not cross
};

struct Edge {
    double angle_deg, bright, z_behind;
};

EdgeError edge_error(bool cpu, const std::string& node, const Edge& edge, bool linear,
                     double& points_of_area) {
    const Extent extent{48, 40};
    Taa taa(extent, cpu, node);
    const double angle = edge.angle_deg * M_PI / 180, dark = 0.05;
    const glm::dvec2 across(std::cos(angle), std::sin(angle));
    const double offset = glm::dot(across, glm::dvec2(24.3, 20.2));
    const auto inside = [&](glm::dvec2 p) { return glm::dot(across, p) > offset; };
    const Picture picture = [&](glm::dvec2 p) {
        return inside(p) ? Sample{glm::dvec3(edge.bright), 5} : Sample{glm::dvec3(dark), edge.z_behind};
    };
    std::vector<double> area(taa.pixels()), points(taa.pixels());
    for (size_t i = 0; i < area.size(); ++i) {
        for (int s = 0; s < 4096; ++s)
            area[i] +=
                inside(taa.centre(i) + glm::dvec2((s % 64 + 0.5) / 64, (s / 64 + 0.5) / 64) - 0.5) / 4096.0;
        for (uint32_t f = 0; f < 16; ++f) {
            const auto jitter = halton_jitter(f, {1, 1});
            points[i] += inside(taa.centre(i) - glm::dvec2(jitter[0], jitter[1])) / 16.0;
        }
    }
    const auto space = [&](double c) { return linear ? c : compress(c); };
    EdgeError error;
    double crossed = 0, points_error = 0;
    const uint32_t settled = 64;
    for (uint32_t f = 0; f < settled + 16; ++f) {
        const auto out = taa.frame(picture, f == 0);
        for (size_t i = 0; f >= settled && i < out.size(); ++i) {
            const double coverage = (space(out[i].x) - space(dark)) / (space(edge.bright) - space(dark));
            if (area[i] > 0 && area[i] < 1) {
                error.of_area += (coverage - area[i]) * (coverage - area[i]);
                error.of_points += (coverage - points[i]) * (coverage - points[i]);
                points_error += (points[i] - area[i]) * (points[i] - area[i]);
                ++crossed;
            } else {
                error.elsewhere = std::max(error.elsewhere, std::abs(coverage - area[i]));
            }
        }
    }
    error.of_area = std::sqrt(error.of_area / crossed);
    error.of_points = std::sqrt(error.of_points / crossed);
    points_of_area = std::sqrt(points_error / crossed);
    return error;
}

// Sixteen points know an area to .04 to .06, whatever averages them. What the average adds to that is the
// ripple of its weights and what its box cuts off.
TEST_P(TaaOurs, AStillEdgeUnderJitterBecomesItsArea) {
    for (const Edge& edge : {Edge{20, 0.8, 5}, Edge{20, 0.8, 1000}, Edge{71, 0.8, 10}, Edge{3, 6, 10}}) {
        SCOPED_TRACE(testing::Message() << "angle " << edge.angle_deg << " behind at " << edge.z_behind);
        double points = 0;
        const EdgeError ours = edge_error(GetParam(), robust, edge, false, points);
        const EdgeError linear = edge_error(GetParam(), robust_linear, edge, true, points);
        const EdgeError theirs = edge_error(GetParam(), published, edge, false, points);
        std::printf(
            "edge %2.0f deg: 16 points %.4f; robust %.4f, of the points %.4f; linear %.4f, %.4f; published "
            "%.4f, %.4f\n",
            edge.angle_deg, points, ours.of_area, ours.of_points, linear.of_area, linear.of_points,
            theirs.of_area, theirs.of_points);
        for (const EdgeError& e : {ours, linear}) {
            EXPECT_LT(e.of_points, 0.012);
            EXPECT_LT(e.of_area, points + 0.005);
            EXPECT_LT(e.elsewhere, 0.005);
        }
        EXPECT_LT(ours.of_points, 0.6 * theirs.of_points);
    }
}

// A box moves away to the right by 8 pixels a frame. What it covered in the previous frame shows its own
// colour at once; the background has a texture, so that the colour box is wide enough to let a ghost through.
double ghost(bool cpu, const std::string& node, double depth_motion_m) {
    const Extent extent{96, 48};
    Taa taa(extent, cpu, node);
    double worst = 0;
    for (int frame = 0; frame < 6; ++frame) {
        const double left = 20 + 8.0 * frame, z = 5 + depth_motion_m * frame;
        const Picture picture = [&](glm::dvec2 p) {
            if (p.x >= left && p.x < left + 24 && p.y >= 12 && p.y < 36)
                return Sample{glm::dvec3(0.9, 0.1, 0.1), z, {frame ? -8.0 : 0.0, 0, -depth_motion_m}};
            const int stripe = static_cast<int>(std::floor(p.x / 2) + std::floor(p.y / 2)) & 1;
            return Sample{stripe ? glm::dvec3(0.25, 0.5, 0.3) : glm::dvec3(0.75, 0.8, 0.7), 10};
        };
        const auto out = taa.frame(picture, frame == 0, false), lit = taa.lit();
        const std::vector<float> held = taa.frames_held();
        for (size_t i = 0; frame > 0 && i < out.size(); ++i) {
            const glm::dvec2 p = taa.centre(i);
            if (p.x < left - 8 || p.x >= left - 1 || p.y < 12 || p.y >= 36)
                continue;  // uncovered, not beside the box
            for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(out[i][c] - lit[i][c]));
            if (node == robust) {
                EXPECT_EQ(held[i], 1) << "pixel " << i;
            }
        }
    }
    return worst;
}

TEST_P(TaaOurs, WhatComesIntoViewShowsNoGhost) {
    for (const double depth_motion_m : {0.0, 0.3}) {
        const double ours = ghost(GetParam(), robust, depth_motion_m),
                     theirs = ghost(GetParam(), published, depth_motion_m);
        std::printf("ghost: %.5f, published %.5f\n", ours, theirs);
        EXPECT_LT(ours, 1.0 / 255);
        EXPECT_GT(theirs, 10.0 / 255) << "the test would not see a ghost";
    }
}

// A surface keeps its history while it moves, also towards the camera where the host's motion says so.
TEST_P(TaaOurs, AMovingSurfaceKeepsItsHistory) {
    for (const double told : {1.0, 0.0}) {
        const Extent extent{64, 32};
        Taa taa(extent, GetParam(), robust);
        std::mt19937 random(7);
        double spread = 0, raw = 0;
        for (int frame = 0; frame < 24; ++frame) {
            const double dz = told > 0 ? -0.05 : 0;
            const Picture picture = [&](glm::dvec2) {
                const double noise = static_cast<double>(random() % 1024) / 1024;
                return Sample{
                    glm::dvec3(0.3 + 0.4 * noise), 8 + dz * frame, {frame ? -1.0 : 0.0, 0, -dz * told}};
            };
            const auto out = taa.frame(picture, frame == 0), lit = taa.lit();
            if (frame < 20) continue;
            for (size_t i = 0; i < out.size(); ++i) {
                if (taa.centre(i).x < 30) continue;
                spread += (out[i].x - 0.49) * (out[i].x - 0.49);
                raw += (lit[i].x - 0.5) * (lit[i].x - 0.5);
            }
        }
        EXPECT_LT(spread, raw / 8) << "told " << told;
    }
}

// Interpolation blurs the history once more in every frame: where it falls midway between texels few frames
// may count, or a texture that moves along would fade away.
TEST_P(TaaOurs, ATextureThatMovesStaysSharp) {
    Taa taa({48, 36}, GetParam(), robust);
    const double step = 0.5;  // px a frame, along both axes
    double kept = 0, whole = 0;
    for (int frame = 0; frame < 40; ++frame) {
        const auto wave = [&](glm::dvec2 p) {
            return std::sin(2 * M_PI / 4 * (p.x + p.y - 2 * step * frame));
        };
        const Picture picture = [&](glm::dvec2 p) {
            const double moved = frame ? -step : 0;
            return Sample{glm::dvec3(0.3 + 0.1 * wave(p)), 10, {moved, moved, 0}};
        };
        const auto out = taa.frame(picture, frame == 0);
        for (size_t i = 0; frame >= 20 && i < out.size(); ++i) {
            const glm::dvec2 p = taa.centre(i);
            if (p.x < 24 || p.y < 24) continue;  // what came in later than twenty frames ago
            kept += (out[i].x - 0.3) * wave(p);
            whole += 0.1 * wave(p) * wave(p);
        }
    }
    EXPECT_GT(kept / whole, 0.3);  // .14 where every frame counts
}

// A floor seen at grazing angles from a camera that moves forward and turns, rasterised with jitter: its
// depth changes by many metres from row to row, and every pixel that was on the screen still finds itself.
// Half of the frames say nothing in the motion's third component, which hosts may leave out.
TEST_P(TaaOurs, AFloorUnderAMovingCameraKeepsItsHistory) {
    const Extent extent{96, 64};
    Taa taa(extent, GetParam(), robust);
    taa.set_normal({0, 1, 0});
    const auto camera_of = [&](int f) { return camera_at({0.02 * f, 1.2, -0.05 * f}, 0.003 * f, extent); };
    // Floor point under a pixel, in the world, and where a camera sees a point.
    const auto axes = [](const Camera& c) {
        return glm::dmat3(glm::dvec3(c.world_from_view[0], c.world_from_view[1], c.world_from_view[2]),
                          glm::dvec3(c.world_from_view[3], c.world_from_view[4], c.world_from_view[5]),
                          glm::dvec3(c.world_from_view[6], c.world_from_view[7], c.world_from_view[8]));
    };
    const auto place = [](const Camera& c) {
        return glm::dvec3(c.position[0], c.position[1], c.position[2]);
    };
    const glm::dvec2 size(extent.width, extent.height);
    const auto seen = [&](const Camera& c, const glm::dvec3& world) {
        const glm::dvec3 v = glm::transpose(axes(c)) * (world - place(c));
        return glm::dvec3(
            size * (0.5 + 0.5 * glm::dvec2(c.clip_from_view[0] * v.x, c.clip_from_view[5] * v.y) / -v.z),
            -v.z);
    };
    FrameDescription description;
    const int frames = 12;
    const int blurred = 5;  // frames that count where the history is interpolated midway between texels
    size_t floor_pixels = 0, lost = 0;
    for (int f = 0; f < frames; ++f) {
        const Camera now = camera_of(f), before = camera_of(std::max(f - 1, 0));
        const std::array<double, 2> prev_jitter = description.jitter;
        description = frame_between(before, now, extent, static_cast<uint32_t>(f), f == 0);
        description.jitter = halton_jitter(static_cast<uint32_t>(f), description.size);
        description.prev_jitter = f == 0 ? description.jitter : prev_jitter;
        const Picture picture = [&](glm::dvec2 p) {
            const glm::dvec2 ndc = 2.0 * p / size - 1.0;
            const glm::dvec3 ray =
                axes(now) * glm::dvec3(ndc.x / now.clip_from_view[0], ndc.y / now.clip_from_view[5], -1);
            if (ray.y > -0.01) return Sample{{}, 0};
            const double z = -place(now).y / ray.y;
            const glm::dvec3 previous = seen(before, place(now) + z * ray);
            return Sample{
                glm::dvec3(0.5), z, {previous.x - p.x, previous.y - p.y, f % 2 ? previous.z - z : 0}};
        };
        taa.frame(picture, description, glm::dvec2(description.jitter[0], description.jitter[1]) * size);
        const std::vector<float> held = taa.frames_held();
        for (size_t i = 0; i < held.size(); ++i) {
            const glm::dvec2 p = taa.centre(i);
            // Below the horizon, and away from what the camera's motion brought in at the sides.
            if (p.y < 36 || p.y > 52 || p.x < 20 || p.x > 76) continue;
            ++floor_pixels;
            lost += int(held[i]) < std::min(f + 1, blurred);
        }
    }
    EXPECT_GT(floor_pixels, 500u);
    EXPECT_EQ(lost, 0u);
}

TEST_P(TaaOurs, AStillImageIsAFixedPoint) {
    const Extent extent{40, 24};
    for (const std::string& node : {robust, robust_linear}) {
        Taa taa(extent, GetParam(), node);
        std::mt19937 random(3);
        std::vector<Sample> samples(taa.pixels());
        for (Sample& s : samples) {
            for (int c = 0; c < 3; ++c)
                s.color[c] = std::pow(2.0, static_cast<double>(random() % 1600) / 100 - 10);
            s.z = random() % 4 ? 3 + static_cast<double>(random() % 100) / 10 : 0;
        }
        const Picture picture = [&](glm::dvec2 p) {
            return samples[static_cast<size_t>(p.y) * extent.width + static_cast<size_t>(p.x)];
        };
        for (uint32_t frame = 0; frame < 40; ++frame) {
            const auto out = taa.frame(picture, frame == 0, false), lit = taa.lit();
            for (size_t i = 0; i < out.size(); ++i)
                ASSERT_EQ(out[i], lit[i]) << "frame " << frame << " pixel " << i;
        }
    }
}

TEST_P(TaaOurs, StaysFiniteWhateverComesIn) {
    constexpr double nan_value = std::numeric_limits<double>::quiet_NaN(),
                     infinity = std::numeric_limits<double>::infinity();
    for (const std::string& node : {robust, robust_linear}) {
        Taa taa({67, 45}, GetParam(), node);
        std::mt19937 random(5);
        const auto one_of = [&](std::initializer_list<double> values) {
            return values.begin()[random() % values.size()];
        };
        const Picture bad = [&](glm::dvec2) {
            Sample s;
            for (int c = 0; c < 3; ++c)
                s.color[c] = one_of({0, 1e-7, 0.5, 1, 65504, 65504, 32768, infinity, -1, nan_value});
            s.motion = {one_of({0, 0.5, -3, 1e9, nan_value, infinity, -infinity}),
                        one_of({0, 0.2, nan_value, infinity}), one_of({0, 0.1, 65504, nan_value, infinity})};
            s.z = one_of({5, 5, 10, 0, nan_value, 1e-30, 1e30, -1});
            return s;
        };
        for (uint32_t frame = 0; frame < 12; ++frame) {
            const auto out = taa.frame(bad, frame == 0 || frame == 7);
            for (size_t i = 0; i < out.size(); ++i)
                for (int c = 0; c < 3; ++c)
                    ASSERT_TRUE(out[i][c] >= 0 && out[i][c] <= 65504)
                        << out[i][c] << " in frame " << frame << ", pixel " << i;
        }
        // A jitter's period of good frames later, what was bad is no longer taken for something thin.
        const glm::dvec3 good(0.25, 0.5, 0.75);
        for (int frame = 0; frame < 16; ++frame)
            taa.frame([&](glm::dvec2) { return Sample{good, 10}; }, false);
        for (const auto& c : taa.frame([&](glm::dvec2) { return Sample{good, 10}; }, false))
            ASSERT_LT(glm::length(c - good), 0.002);
    }
}

// A shadow that crosses a surface without any motion of its own: the box alone rejects what was dark.
TEST_P(TaaOurs, AMovingShadowLeavesNoTrail) {
    Taa taa({64, 32}, GetParam(), robust);
    double worst = 0;
    for (int frame = 0; frame < 24; ++frame) {
        const double edge = 10.0 + 2 * frame;
        const Picture picture = [&](glm::dvec2 p) { return Sample{glm::dvec3(p.x < edge ? 0.8 : 0.1), 10}; };
        const auto out = taa.frame(picture, frame == 0, false);
        for (size_t i = 0; i < out.size(); ++i)
            if (taa.centre(i).x < edge - 2.5) worst = std::max(worst, std::abs(out[i].x - 0.8));
    }
    EXPECT_LT(worst, 1.0 / 255);
}

INSTANTIATE_TEST_SUITE_P(DeviceClasses, TaaOurs, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "cpu" : "gpu"; });

}  // namespace
}  // namespace penumbra::test
