// SPDX-License-Identifier: MIT
// The robust form of the node taa on images that the test fills itself, beside the published form where that
// fails: an edge under jitter becomes its area, what comes into view shows no ghost, a still image stays,
// nothing finite becomes infinite.
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <random>

#include "host/shots/shot.h"
#include "shaders/common/blocks.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

// The colours reach the node as an albedo under white ambient light.
std::string pipeline_text(const std::string& taa) {
    return R"({
  "penumbra": 1, "name": "taa", "inputs": { "depth": {}, "normal": {}, "motion": {}, "albedo": {}, "visibility": {}, "sun": {} },
  "outputs": ["color"],
  "nodes": {
    "guides": { "type": "guides" },
    "shade": { "type": "shade", "params": { "sun_color": [0, 0, 0], "ambient": [1, 1, 1] } },
    "taa": )" +
           taa + " } }";
}
const std::string robust =
    R"({ "type": "taa", "in": { "history": "color@-1", "view_depth_prev": "view_depth@-1" } })";
const std::string robust_linear =
    R"({ "type": "taa", "in": { "history": "color@-1", "view_depth_prev": "view_depth@-1" }, "params": { "weighting": "linear" } })";
const std::string published =
    R"({ "type": "taa", "in": { "history": "color@-1" }, "params": { "form": "published", "box": "rgb" } })";

// One sample of the picture: a surface that faces the camera, `z` metres in front of it. 0: sky.
struct Sample {
    glm::dvec3 color{0};
    double z = 10;
    glm::dvec3 motion{0};  // px, px, metres
};
using Picture = std::function<Sample(glm::dvec2 point)>;  // of a point of the image plane, in pixels

class Taa {
  public:
    Taa(Extent extent, bool cpu, const std::string& node)
        : extent_(extent), run_(shadow_pipeline(pipeline_text(node)), extent, options(cpu)) {
        run_.set("normal", std::vector<std::array<uint16_t, 4>>(pixels(), to_half4({0, 0, 1, 0})));
        run_.set("visibility", std::vector<uint8_t>(pixels(), 255));
        run_.set("sun", std::vector<blocks::Sun>{{{{0, 1, 0}}, 0.01f}});
    }

    size_t pixels() const { return size_t{extent_.width} * extent_.height; }
    glm::dvec2 centre(size_t i) const { return glm::dvec2(i % extent_.width, i / extent_.width) + 0.5; }

    // Pixel p sees the picture at its centre minus the jitter, as a raster moved by it does.
    std::vector<glm::dvec3> frame(const Picture& picture, bool reset, bool jittered = true) {
        FrameDescription description;
        description.camera = description.previous = camera_at({0, 0, 0}, 0, extent_);
        description.size = description.prev_size = {extent_.width, extent_.height};
        description.index = index_;
        description.flags = reset ? uint32_t{frame_reset} : 0u;
        if (jittered) description.jitter = halton_jitter(index_, description.size);
        description.prev_jitter = reset ? description.jitter : jitter_;
        jitter_ = description.jitter;
        ++index_;
        const glm::dvec2 shift(jitter_[0] * extent_.width, jitter_[1] * extent_.height);
        return frame(picture, description, shift);
    }

    std::vector<glm::dvec3> frame(const Picture& picture, const FrameDescription& description,
                                  glm::dvec2 shift) {
        std::vector<std::array<uint16_t, 4>> color, motion;
        std::vector<float> depth;
        for (size_t i = 0; i < pixels(); ++i) {
            const Sample s = picture(centre(i) - shift);
            color.push_back(to_half4({s.color.x, s.color.y, s.color.z, 1}));
            motion.push_back(
                to_half4({s.motion.x / extent_.width, s.motion.y / extent_.height, s.motion.z, 0}));
            depth.push_back(static_cast<float>(s.z == 0 ? 0 : 0.05 / s.z));
        }
        run_.set("albedo", color);
        run_.set("motion", motion);
        run_.set("depth", depth);
        run_.frame(description);
        return image("color");
    }
    std::vector<glm::dvec3> lit() { return image("lit"); }
    std::vector<float> frames_held() {
        std::vector<float> alpha = captured_planes(run_.view(), "color")[3];
        for (float& a : alpha) a = std::round(a * 32);  // what is left is below half a frame
        return alpha;
    }
    void set_normal(const glm::dvec3& n) {
        run_.set("normal", std::vector<std::array<uint16_t, 4>>(pixels(), to_half4({n.x, n.y, n.z, 0})));
    }

  private:
    static ViewRunOptions options(bool cpu) {
        ViewRunOptions o;
        o.cpu = cpu;
        o.formats = {{"depth", Format::r32f},
                     {"normal", Format::rgba16f},
                     {"motion", Format::rgba16f},
                     {"albedo", Format::rgba16f},
                     {"visibility", Format::r8}};
        o.captures = {"lit"};
        return o;
    }
    std::vector<glm::dvec3> image(const char* name) {
        const auto planes = captured_planes(run_.view(), name);
        std::vector<glm::dvec3> colors(planes[0].size());
        for (size_t i = 0; i < colors.size(); ++i) colors[i] = {planes[0][i], planes[1][i], planes[2][i]};
        return colors;
    }

    Extent extent_;
    ViewRun run_;
    uint32_t index_ = 0;
    std::array<double, 2> jitter_{0, 0};
};

class TaaOurs : public GpuTest, public ::testing::WithParamInterface<bool> {};

double compress(double c) {
    return c / (1 + c);
}

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

// A bar of a third of a pixel that stands still comes and goes with the jitter, and away from all nine pixels
// around with it; a pixel beside it keeps its history all the same, from the second frame on: what the frame
// after a cut shows may have been about to move. One of a pixel that moves on by three a
// frame is taken for such a bar where it was: its colour goes at once all the same, and what is left there is
// a blur of the texture.
TEST_P(TaaOurs, WhatIsThinnerThanAPixelEndsNoHistory) {
    const Extent extent{64, 32};
    Taa taa(extent, GetParam(), robust);
    std::vector<float> held;
    for (int frame = 0; frame < 16; ++frame) {
        const Picture picture = [&](glm::dvec2 p) {
            return std::abs(p.x - 32.4) < 1.0 / 6 ? Sample{glm::dvec3(0.9, 0.1, 0.1), 5}
                                                  : Sample{glm::dvec3(0.3), 10};
        };
        taa.frame(picture, frame == 0);
        held = taa.frames_held();
    }
    for (size_t i = 0; i < held.size(); ++i)
        EXPECT_GE(held[i], 15) << i % extent.width << ", " << i / extent.width;
}

TEST_P(TaaOurs, WhatIsThinAndLeavesTakesItsColourAlong) {
    const auto trail = [&](const std::string& node, double contrast) {
        const Extent extent{96, 32};
        Taa taa(extent, GetParam(), node);
        double worst = 0;
        for (int frame = 0; frame < 12; ++frame) {
            const double left = 20 + 3.0 * frame;
            const Picture picture = [&](glm::dvec2 p) {
                if (p.x >= left && p.x < left + 1)
                    return Sample{glm::dvec3(0.9, 0.1, 0.1), 5, {frame ? -3.0 : 0.0, 0, 0}};
                const int stripe = static_cast<int>(std::floor(p.x / 2) + std::floor(p.y / 2)) & 1;
                return Sample{glm::dvec3(0.5 + (stripe ? contrast : -contrast)), 10};
            };
            const auto out = taa.frame(picture, frame == 0, false), lit = taa.lit();
            for (size_t i = 0; frame > 0 && i < out.size(); ++i) {
                if (std::abs(taa.centre(i).x - (left - 2.5)) > 0.1) continue;  // where it was
                for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(out[i][c] - lit[i][c]));
            }
        }
        return worst;
    };
    for (const double contrast : {0.0, 0.2}) {
        const double ours = trail(robust, contrast), theirs = trail(published, contrast);
        std::printf("trail over contrast %.1f: %.5f, published %.5f\n", contrast, ours, theirs);
        EXPECT_LT(ours, contrast + 1.0 / 255);
        EXPECT_LE(ours, theirs);
    }
}

// Before a wall 10 m away: what is bright, and how far away it is.
struct Thin {
    const char* name;
    double z;
    glm::dvec2 step_px;                            // by which the wall moves in a frame
    std::function<bool(glm::dvec2 at_px)> bright;  // of a point in its plane, in the pixels of its distance
    bool by_itself = false;                        // it moves, before a camera and a wall that stand still
};

struct Crawl {
    double change = 0, error = 0;  // rms: of what changes from frame to frame and should not; of the picture
};

// A camera goes along slowly, and the picture is held against the mean of 64 samples of every pixel, after
// the compression that the node's averages are taken in.
Crawl crawl(bool cpu, const std::string& node, const Thin& thing) {
    const Extent extent{48, 36};
    Taa taa(extent, cpu, node);
    const glm::dvec2 size(extent.width, extent.height);
    const double wall = 10;
    const Camera still = camera_at({0, 0, 0}, 0, extent);
    const glm::dvec2 slope(still.clip_from_view[0], still.clip_from_view[5]);  // of clip over view
    const auto metres = [&](double z) { return 2 * z / (slope * size); };      // of a pixel
    const auto camera_of = [&](int f) {
        const glm::dvec2 at = thing.by_itself ? glm::dvec2(0) : metres(wall) * thing.step_px * double(f);
        return camera_at({at.x, at.y, 0}, 0, extent);
    };
    FrameDescription description;
    std::vector<double> before, truth_before;
    Crawl sum;
    size_t counted = 0;
    for (int f = 0; f < 40; ++f) {
        const std::array<double, 2> prev_jitter = description.jitter;
        description = frame_between(camera_of(std::max(f - 1, 0)), camera_of(f), extent,
                                    static_cast<uint32_t>(f), f == 0);
        description.jitter = halton_jitter(static_cast<uint32_t>(f), description.size);
        description.prev_jitter = f == 0 ? description.jitter : prev_jitter;
        const Picture picture = [&](glm::dvec2 p) {
            const glm::dvec2 from_middle = p - 0.5 * size;
            const auto motion = [&](double z) {
                return f == 0 ? glm::dvec3(0) : glm::dvec3(thing.step_px * wall / z, 0);
            };
            if (thing.bright(from_middle + thing.step_px * (wall / thing.z) * double(f)))
                return Sample{glm::dvec3(0.9), thing.z, motion(thing.z)};
            return Sample{glm::dvec3(0.2), wall, thing.by_itself ? glm::dvec3(0) : motion(wall)};
        };
        const auto out =
            taa.frame(picture, description, glm::dvec2(description.jitter[0], description.jitter[1]) * size);
        std::vector<double> now, truth;
        for (size_t i = 0; i < out.size(); ++i) {
            now.push_back(compress(out[i].x));
            double mean = 0;
            for (int s = 0; s < 64; ++s)
                mean +=
                    compress(
                        picture(taa.centre(i) + glm::dvec2(s % 8 + 0.5, s / 8 + 0.5) / 8.0 - 0.5).color.x) /
                    64;
            truth.push_back(mean);
            const glm::dvec2 c = taa.centre(i);
            if (f < 20 || c.x < 6 || c.x > size.x - 6 || c.y < 6 || c.y > size.y - 6) continue;
            sum.error += (now[i] - mean) * (now[i] - mean);
            const double change = now[i] - mean - (before[i] - truth_before[i]);
            sum.change += change * change;
            ++counted;
        }
        before = now;
        truth_before = truth;
    }
    return {std::sqrt(sum.change / double(counted)), std::sqrt(sum.error / double(counted))};
}

// A ledge of a third of a pixel is seen by a third of the jitter's samples; of bars that are nearly as far
// apart as pixels all nine around one are hit in one frame and none in the next, so that neither the surfaces
// nor the colours of one frame say what the pixel shows. None of it has gone away.
TEST_P(TaaOurs, ThinThingsDoNotCrawlBeforeASlowCamera) {
    const auto within = [](double x, double period, double width) {
        return x - period * std::floor(x / period) < width;
    };
    for (const Thin& thing :
         {Thin{"ledges", 9.8, {0.003, 0.03}, [&](glm::dvec2 p) { return within(p.y, 7.3, 0.33); }},
          Thin{"bars", 9.5, {0.03, 0.003}, [&](glm::dvec2 p) { return within(p.x, 1.04, 0.5); }},
          Thin{"bars far before it", 4, {0.03, 0.003}, [&](glm::dvec2 p) {
                   return within(p.x, 1.04, 0.5);
               }}}) {
        const Crawl ours = crawl(GetParam(), robust, thing), theirs = crawl(GetParam(), published, thing);
        std::printf("%s: change %.4f, published %.4f; error %.4f, published %.4f\n", thing.name, ours.change,
                    theirs.change, ours.error, theirs.error);
        const bool bars = thing.name != std::string("ledges");
        EXPECT_LT(ours.change, (bars ? 0.25 : 0.95) * theirs.change);
        EXPECT_LT(ours.error, bars ? 0.3 * theirs.error : 0.04);
    }
}

// A gate that is pulled up: its bars go along themselves, and what is thinner than a pixel, bars or the gaps
// between them, comes and goes with the jitter as if nothing moved. A bar that goes sideways instead takes
// its colour along.
TEST_P(TaaOurs, ThinThingsThatMoveByThemselvesDoNotCrawl) {
    const auto bars = [](double period, double width) {
        return [=](glm::dvec2 p) { return p.x - period * std::floor(p.x / period) < width; };
    };
    for (const Thin& thing : {Thin{"bars", 9, {0.003, 0.33}, bars(2.3, 0.5), true},
                              Thin{"gaps", 9, {0.003, 0.6}, bars(2.3, 2), true},
                              Thin{"a bar sideways", 9, {0.6, 0.003}, bars(30, 2), true}}) {
        const Crawl ours = crawl(GetParam(), robust, thing), theirs = crawl(GetParam(), published, thing);
        std::printf("%s: change %.4f, published %.4f; error %.4f, published %.4f\n", thing.name, ours.change,
                    theirs.change, ours.error, theirs.error);
        EXPECT_LT(ours.change, 0.03) << thing.name;
        EXPECT_LT(ours.error, 0.9 * theirs.error) << thing.name;
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
