// SPDX-License-Identifier: MIT
// The robust form of the node taa before what is thinner than a pixel, which comes and goes with the jitter:
// it ends no history, does not crawl, and takes its colour along when it leaves.
#include <cmath>
#include <functional>
#include <glm/glm.hpp>

#include "tests/taa_run.h"

namespace penumbra::test {
namespace {

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

}  // namespace
}  // namespace penumbra::test
