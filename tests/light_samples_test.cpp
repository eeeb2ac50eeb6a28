// SPDX-License-Identifier: MIT
// The samples of a light's disc and their table of half-planes: what the table promises entry by entry; that
// a straight edge costs the rounding to whole samples and nothing else, without a bias; what corners and
// slivers cost besides; and that the correction for the sun's cap is right to ten degrees.
#include "nodes/tables/light_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "host/truth/light_visibility.h"
#include "tests/cover_model.h"
#include "tests/coverage_oracle.h"

namespace penumbra::test {
namespace {

using std::numbers::pi;

const std::vector<LightSample>& samples(uint32_t count) {
    static std::map<uint32_t, std::vector<LightSample>> made;
    auto& points = made[count];
    if (points.empty()) points = light_samples(count);
    return points;
}

const CoverModel& flat(uint32_t count) {
    static std::map<uint32_t, CoverModel> made;
    auto found = made.find(count);
    // A sun so small that its cap is a disc.
    if (found == made.end())
        found = made.emplace(count, CoverModel(count, 1e-6, half_plane_table(samples(count)))).first;
    return found->second;
}

// A line of the plane at distance 1, from a line of the unit disc.
glm::dvec3 on_light(const CoverModel& model, const glm::dvec3& l) {
    return {l.x, l.y, l.z * model.radius()};
}

class LightSamples : public ::testing::TestWithParam<uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Counts, LightSamples, ::testing::ValuesIn(light_sample_counts),
                         [](const auto& test) { return std::to_string(test.param); });

TEST_P(LightSamples, AreDistinctPointsOfTheDiscOnTheirGrid) {
    const auto& points = samples(GetParam());
    ASSERT_EQ(points.size(), GetParam());
    std::set<LightSample> all(points.begin(), points.end());
    EXPECT_EQ(all.size(), points.size());
    double x = 0, y = 0;
    for (const LightSample& p : points) {
        EXPECT_LT(std::hypot(p[0], p[1]), 1);
        for (const double c : p) EXPECT_NEAR(c * 32767, std::round(c * 32767), 1e-9);
        x += p[0];
        y += p[1];
    }
    EXPECT_LT(std::hypot(x, y) / GetParam(), 0.5 / GetParam());  // the middle, within half a sample's share
    EXPECT_TRUE(light_samples(GetParam()) == points) << "another set from the same seed";
}

TEST_P(LightSamples, EntriesGrowByTheNextSampleAlongTheNormal) {
    const uint32_t count = GetParam(), words = count / 32;
    const auto& points = samples(count);
    const std::vector<uint32_t> table = half_plane_table(points);
    ASSERT_EQ(table.size(), size_t{HALF_PLANE_DIRECTIONS} * (count + 1) * words);
    for (uint32_t bin = 0; bin < HALF_PLANE_DIRECTIONS; ++bin) {
        const auto n = half_plane_normal(bin);
        EXPECT_NEAR(std::hypot(n[0], n[1]), 1, 1e-12);
        EXPECT_GT(n[1], 0);
        const auto has = [&](uint32_t k, uint32_t i) {
            return (table[(size_t{bin} * (count + 1) + k) * words + i / 32] >> i % 32 & 1) != 0;
        };
        for (uint32_t k = 0; k <= count; ++k) {
            uint32_t held = 0;
            double nearest_in = 2, farthest_out = -2;
            for (uint32_t i = 0; i < count; ++i) {
                const double along = points[i][0] * n[0] + points[i][1] * n[1];
                held += has(k, i);
                if (has(k, i)) nearest_in = std::min(nearest_in, along);
                if (!has(k, i)) farthest_out = std::max(farthest_out, along);
                if (k > 0 && has(k - 1, i)) {
                    ASSERT_TRUE(has(k, i));
                }
            }
            ASSERT_EQ(held, k);
            ASSERT_GE(nearest_in, farthest_out);
        }
    }
}

// Two triangles at an edge ask for e and -e: the same entry, once as it is and once as its complement.
TEST_P(LightSamples, OppositeLinesAreExactComplements) {
    const CoverModel& model = flat(GetParam());
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> in(0, 1);
    CoverMask all;
    for (uint32_t w = 0; w < GetParam() / 32; ++w) all.words[w] = ~0u;
    for (int i = 0; i < 200'000; ++i) {
        glm::dvec3 e(normal(random), normal(random), model.radius() * normal(random));
        if (i % 5 == 0) e.y = 0;
        if (i % 7 == 0) e.x = 0;
        if (i % 11 == 0) e.z = 0;
        const double dither = 0.002 + 0.996 * (i % 13 ? in(random) : 0);
        if (e == glm::dvec3(0)) continue;  // of an edge that points at the receiver: its triangle has no area
        const auto one = model.line(e, dither), other = model.line(-e, dither);
        ASSERT_LE(one.k, GetParam());
        ASSERT_LT(one.bin, HALF_PLANE_DIRECTIONS);
        if (e.x != 0 || e.y != 0) {
            ASSERT_EQ(one.k, other.k);
            ASSERT_EQ(one.bin, other.bin);
            ASSERT_NE(one.flip, other.flip);
        }
        CoverMask a = model.positive(one), b = model.positive(other), both = a;
        both &= b;
        a |= b;
        ASSERT_TRUE(a == all);
        ASSERT_EQ(both.count(), 0u);
    }
}

// The square's, which rectangles and tubes are: as many samples on a side as the area has, for any line, and
// each of the eight ways to lie.
TEST_P(LightSamples, OfTheSquareAreEvenToo) {
    const uint32_t count = GetParam();
    const auto points = light_samples(count, LightShape::square);
    std::set<LightSample> all(points.begin(), points.end());
    ASSERT_EQ(all.size(), count);
    for (const LightSample& p : points) EXPECT_LT(std::max(std::abs(p[0]), std::abs(p[1])), 1);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(0, 1);
    double squares = 0, box_squares = 0;
    constexpr int lines = 4000;
    for (int i = 0; i < lines; ++i) {
        const double angle = 2 * pi * in(random);
        const std::array<double, 2> n{std::cos(angle), std::sin(angle)};
        const double c = (2 * in(random)-1) * (std::abs(n[0]) + std::abs(n[1])), x = 2 * in(random)-1,
                     y = 2 * in(random)-1;
        double beyond = 0, boxed = 0;
        for (const LightSample& p : points) {
            beyond += p[0] * n[0] + p[1] * n[1] + c >= 0;
            boxed += p[0] < x && p[1] < y;
        }
        const double error = beyond / count - half_square_area(n, c),
                     box_error = boxed / count - (x + 1) * (y + 1) / 4;
        squares += error * error;
        box_squares += box_error * box_error;
    }
    const double rms = std::sqrt(squares / lines), box = std::sqrt(box_squares / lines);
    std::printf("%u samples: rms %.4f of lines, %.4f of corners\n", count, rms, box);
    // Random points: sqrt(1/6 .. 1/4 / count), .036 for 128.
    EXPECT_LT(rms, 1.2 / count);
    EXPECT_LT(box, 1.6 / count);
}

TEST(HalfSquare, HasTheAreaOfItsPolygon) {
    for (double angle = 0; angle < 2 * pi; angle += 0.37)
        for (double c = -1.6; c <= 1.6; c += 0.1) {
            const glm::dvec2 n(std::cos(angle), std::sin(angle)), along(-n.y, n.x);
            const std::vector<glm::dvec2> beyond{-c * n - 9.0 * along, -c * n + 9.0 * along,
                                                 (9 - c) * n + 9.0 * along, (9 - c) * n - 9.0 * along};
            EXPECT_NEAR(half_square_area({n.x, n.y}, c), square_share(beyond), 1e-9) << angle << " " << c;
        }
    EXPECT_EQ(half_square_area({0, 1}, 2), 1);
    EXPECT_EQ(half_square_area({1, 0}, -2), 0);
}

TEST(HalfDisc, HasTheAreaOfTheIntegral) {
    for (double c = -1; c <= 1; c += 1.0 / 64) {
        const ConvexPart part = {{0.6, -0.8, c}};
        EXPECT_NEAR(half_disc_area(c), hidden_share({&part, 1}, 0), 1e-9) << c;
        EXPECT_NEAR(half_disc_area(c) + half_disc_area(-c), 1, 1e-12);
    }
    EXPECT_EQ(half_disc_area(-2), 0);
    EXPECT_EQ(half_disc_area(2), 1);
}

TEST(HalfDisc, IsThePolynomialOfTheShader) {
    double worst = 0;
    for (int i = -20'000; i <= 20'000; ++i) {
        const double c = i / 20'000.0;
        worst = std::max(worst, std::abs(flat(64).share(c) - half_disc_area(c)));
        EXPECT_GE(flat(64).share(c), 0);
        EXPECT_LE(flat(64).share(c), 1);
    }
    std::printf("area off by up to %.2g\n", worst);
    EXPECT_LT(worst, 2.5e-4);
    EXPECT_NEAR(flat(64).share(1), 1, 4.1e-6);
}

// floor(x + d) with d uniform is x on average and x - f or x - f + 1 with f its fraction: an error of
// variance f (1 - f), 1/6 over all f. So N samples round an area by sqrt(1/6) / N, and nothing else is wrong
// with a straight edge but the polynomial.
TEST_P(LightSamples, AStraightEdgeCostsTheRoundingAlone) {
    const CoverModel& model = flat(GetParam());
    const double count = GetParam(), rounding = std::sqrt(1.0 / 6) / count;
    std::mt19937 random(2);
    std::uniform_real_distribution<double> in(0, 1);
    double squares = 0, worst = 0, worst_mean = 0;
    int lines = 0;
    constexpr int dithers = 64;
    for (int i = 0; i < 20'000; ++i) {
        const double angle = 2 * pi * in(random), c = 2 * in(random)-1;
        const glm::dvec3 e = on_light(model, {std::cos(angle), std::sin(angle), c});
        double mean = 0;
        for (int d = 0; d < dithers; ++d, ++lines) {
            const double error = model.positive(e, (d + 0.5) / dithers).count() / count - half_disc_area(c);
            squares += error * error;
            worst = std::max(worst, std::abs(error));
            mean += error / dithers;
        }
        worst_mean = std::max(worst_mean, std::abs(mean));
    }
    const double rms = std::sqrt(squares / lines);
    std::printf("%.0f samples: rms %.5f (rounding alone %.5f), largest %.4f, bias of a line up to %.5f\n",
                count, rms, rounding, worst, worst_mean);
    EXPECT_LT(rms, 1.01 * std::hypot(rounding, 2.5e-4));
    EXPECT_GT(rms, 0.98 * rounding);
    EXPECT_LT(worst, 1 / count + 4e-4);
    // Half a step of the dithers, the polynomial, and the length of the normal, within 9e-5, at 2 / pi.
    EXPECT_LT(worst_mean, 0.5 / dithers / count + 2.5e-4 + 6e-5);
}

// Dithers that ignored the fraction, as rounding to the nearest does, have a bias that this sees: up to half
// a sample.
TEST_P(LightSamples, NeedTheDitherToBeUnbiased) {
    const CoverModel& model = flat(GetParam());
    double worst = 0;
    for (double c = -0.5; c < 0.5; c += 1e-3) {
        const double share = model.positive(on_light(model, {0.6, 0.8, c}), 0.5).count() / double(GetParam());
        worst = std::max(worst, std::abs(share - half_disc_area(c)));
    }
    EXPECT_GT(worst, 0.4 / GetParam());
}

// Where two lines cross, samples are what they are: neither is a corner's area rounded, nor are the samples
// of a direction's bin sorted along the line itself.
struct Shapes {
    double wedges = 0, strips = 0, hair = 0;  // rms
};
Shapes errors_of(uint32_t count) {
    const CoverModel& model = flat(count);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(0, 1);
    const auto error = [&](const glm::dvec3& a, const glm::dvec3& b) {
        const double dither = in(random);
        CoverMask mask = model.positive(on_light(model, a), dither);
        mask &= model.positive(on_light(model, b), dither);
        const ConvexPart part = {a, b};
        return mask.count() / double(count) - hidden_share({&part, 1}, 0);
    };
    const auto line = [](double angle, double c) { return glm::dvec3(std::cos(angle), std::sin(angle), c); };
    Shapes rms;
    constexpr int n = 20'000;
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * pi * in(random), c = 2 * in(random)-1;
        // A corner anywhere in the disc, of any opening.
        const double r = std::sqrt(in(random)), at = 2 * pi * in(random), second = 2 * pi * in(random);
        const glm::dvec2 corner(r * std::cos(at), r * std::sin(at));
        const auto through = [&](double a) {
            return line(a, -(corner.x * std::cos(a) + corner.y * std::sin(a)));
        };
        const double wedge = error(through(angle), through(second));
        const double width = 0.02 + 0.3 * in(random);
        const double strip = error(line(angle, c), line(angle + pi, width - c));
        const double hair = error(line(angle, c), line(angle + pi, 0.1 / count - c));
        rms.wedges += wedge * wedge / n;
        rms.strips += strip * strip / n;
        rms.hair += hair * hair / n;
    }
    return {std::sqrt(rms.wedges), std::sqrt(rms.strips), std::sqrt(rms.hair)};
}

TEST_P(LightSamples, CornersAndStripsCostLittleMore) {
    const Shapes rms = errors_of(GetParam());
    std::printf("%u samples: rms of wedges %.5f, of strips %.5f, of hairs %.5f\n", GetParam(), rms.wedges,
                rms.strips, rms.hair);
    const std::map<uint32_t, Shapes> bounds = {
        {64, {0.0105, 0.007, 0.004}}, {128, {0.0062, 0.0036, 0.002}}, {256, {0.0039, 0.0018, 0.001}}};
    const Shapes& bound = bounds.at(GetParam());
    EXPECT_LT(rms.wedges, bound.wedges);
    EXPECT_LT(rms.strips, bound.strips);
    EXPECT_LT(rms.hair, bound.hair);
}

// The sun's samples are uniform over its cap, off which a plane through the receiver cuts what the polynomial
// with its bulge says.
TEST(SunCap, IsCutByGreatCirclesAsTheTableSays) {
    const auto worst_at = [](double degrees, bool corrected) {
        const double a = degrees * pi / 180;
        const CoverModel model(64, a, std::vector<uint32_t>{}), disc(64, 1e-6, std::vector<uint32_t>{});
        double worst = 0;
        for (double c = -1; c <= 1; c += 1.0 / 256) {
            const ConvexPart part = {{1, 0, c}};
            worst =
                std::max(worst, std::abs((corrected ? model : disc).share(c) - hidden_share({&part, 1}, a)));
        }
        return worst;
    };
    for (const double degrees : {0.2665, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0}) {
        const double off = worst_at(degrees, true), flat_off = worst_at(degrees, false);
        std::printf("%5.2f degrees: off by up to %.2g; as a disc %.2g\n", degrees, off, flat_off);
        if (degrees <= 10) {
            EXPECT_LT(off, 3e-4) << degrees;
        }
        EXPECT_LT(off, 1e-3) << degrees;
    }
    EXPECT_GT(worst_at(10, false), 6e-4);  // the correction is what does it
}

}  // namespace
}  // namespace penumbra::test
