// SPDX-License-Identifier: MIT
// The node `cover` against its own formulas in double precision over all triangles near each pixel's cone,
// without a tree: the two differ where a count was about to round either way alone. And the masks against an
// exact test of each sample's direction: none is wrong that is not beside an edge.
#include <algorithm>
#include <array>
#include <map>

#include "tests/cover_run.h"

namespace penumbra::test {
namespace {

constexpr double u = 0x1p-24;
double taxi(const glm::dvec3& v) {
    return std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
}

// Triangles by the cells of a grid across the sun's direction, each as wide as cones that reach it are.
class TrianglesAcross {
  public:
    TrianglesAcross(const CoverRun& run) : triangles_(run.triangles) {
        const SeenLight light = seen_light(run.to_sun(), run.angular_radius());
        axes_ = glm::transpose(light.axes);
        glm::dvec3 low(1e300), high(-1e300);
        const auto [width, height] = run.size();
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                if (!run.is_receiver(x, y)) continue;
                const glm::dvec3 p = axes_ * run.start(x, y);
                low = glm::min(low, p);
                high = glm::max(high, p);
            }
        low_ = low;
        cell_ = glm::max(glm::dvec2(high - low) / double(side), glm::dvec2(1e-9));
        const double spread = std::tan(run.angular_radius()) * 1.001;
        for (uint32_t i = 0; i < triangles_.size(); ++i) {
            glm::dvec3 first(1e300), last(-1e300);
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3 p = axes_ * corner(triangles_[i], k);
                first = glm::min(first, p);
                last = glm::max(last, p);
            }
            if (last.z < low.z) continue;
            const double reach = spread * (last.z - low.z) + 1e-6 * (last.z - low.z);
            const glm::dvec2 a = (glm::dvec2(first) - reach - glm::dvec2(low)) / cell_,
                             b = (glm::dvec2(last) + reach - glm::dvec2(low)) / cell_;
            if (b.x < 0 || b.y < 0 || a.x >= side || a.y >= side) continue;
            const auto clamped = [](double c) { return uint32_t(std::clamp(c, 0.0, side - 1.0)); };
            for (uint32_t y = clamped(a.y); y <= clamped(b.y); ++y)
                for (uint32_t x = clamped(a.x); x <= clamped(b.x); ++x) cells_[y * side + x].push_back(i);
        }
    }

    const std::vector<uint32_t>& near(const glm::dvec3& start) const {
        const glm::dvec2 c = (glm::dvec2(axes_ * start) - glm::dvec2(low_)) / cell_;
        const auto clamped = [](double v) { return uint32_t(std::clamp(v, 0.0, side - 1.0)); };
        return cells_[clamped(c.y) * side + clamped(c.x)];
    }

  private:
    static constexpr uint32_t side = 96;
    std::span<const Triangle> triangles_;
    glm::dmat3 axes_{1};
    glm::dvec3 low_{0};
    glm::dvec2 cell_{1};
    std::array<std::vector<uint32_t>, size_t{side} * side> cells_;
};

// The side of its plane on which the start is, as the node decides it; 0: within its corners' rounding.
double height_of(const glm::dvec3& start, const glm::dvec3 (&p)[3], const glm::dvec3 (&seen)[3]) {
    const double first = glm::dot(seen[0], glm::cross(seen[1], seen[2]));
    if (std::abs(first) > 32 * u * taxi(seen[0]) * taxi(seen[1]) * taxi(seen[2])) return first;
    const glm::dvec3 to_a = p[0] - start, ab = p[1] - p[0], ac = p[2] - p[0], n = glm::cross(ab, ac);
    const double height = glm::dot(n, to_a);
    if (std::abs(height) > 16 * u * taxi(ab) * taxi(ac) * taxi(to_a)) return height;
    const glm::dvec3 reach =
        glm::max(glm::max(glm::abs(to_a), glm::abs(p[1] - start)), glm::abs(p[2] - start));
    return std::abs(height) > 2 * u * std::max({reach.x, reach.y, reach.z}) * taxi(n) ? height : 0;
}

// Whether the camera sees the start through the triangle, whose plane is so close above it that the pixel may
// show its own triangle past that one's end: within the grid of the outline of the triangle as it is drawn,
// and within a tenth of that beside it where it rises far.
bool is_looked_through(const CoverRun& run, uint32_t x, uint32_t y, const glm::dvec3& start,
                       const glm::dvec3 (&p)[3]) {
    const glm::dvec3 way = run.to_camera(start), n = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    const double below = glm::dot(n, p[0] - start), to_camera = glm::dot(n, way);
    const double facing = std::abs(glm::dot(run.normal(x, y), glm::normalize(way)));
    const double past = run.grid_angle() * run.view_depth(x, y) / std::max(facing, 1.0 / 64);
    if (below * to_camera <= 0 || std::abs(below) > past) return false;
    double outside = -1e300;  // metres, across the view
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 a = p[k] - start, b = p[(k + 1) % 3] - start, across = glm::cross(b - a, way);
        outside = std::max(outside, -std::copysign(1.0, to_camera) * glm::dot(a, glm::normalize(across)));
    }
    const double grid = run.grid_angle() * glm::length(way);
    const double most_inside = 1.5 * grid + 4.5 * 0x1p-23 * (taxi(start) + taxi(way) + glm::length(way));
    return outside <= grid * std::max(1.5 - 6 * std::abs(below) / past, 0.1) && -outside <= most_inside;
}

struct SeenTriangle {
    glm::dvec3 v[3];
    double height = 0;  // 0: it hides nothing

    // Opposite to a corner; positive on the triangle's side.
    glm::dvec3 line(int opposite) const {
        return (height < 0 ? -1.0 : 1.0) * glm::cross(v[(opposite + 1) % 3], v[(opposite + 2) % 3]);
    }
};
// The same with the triangle that its leaf holds beside it, if any.
struct SeenPair : SeenTriangle {
    SeenTriangle mate;
    int apart = -1, mate_apart = -1;  // corners that the other does not have
};

SeenTriangle see(const CoverRun& run, uint32_t x, uint32_t y, const glm::dvec3& start, const glm::dmat3& axes,
                 uint32_t index) {
    const Triangle& t = run.triangles[index];
    const glm::dvec3 p[3] = {corner(t, 0), corner(t, 1), corner(t, 2)};
    SeenTriangle seen{{axes * (p[0] - start), axes * (p[1] - start), axes * (p[2] - start)}};
    seen.height = is_looked_through(run, x, y, start, p) ? 0 : height_of(start, p, seen.v);
    return seen;
}

// Those that hide a sample by the table or in truth, at least.
std::vector<SeenPair> seen_from(const CoverRun& run, const TrianglesAcross& across, uint32_t x, uint32_t y) {
    const glm::dvec3 start = run.start(x, y);
    const glm::dmat3 axes = glm::transpose(run.turned_axes(x, y));
    const double radius = std::tan(run.angular_radius());
    std::vector<SeenPair> out;
    for (const uint32_t i : across.near(start)) {
        SeenPair seen{see(run, x, y, start, axes, i), {}, -1, -1};
        if (seen.height == 0) continue;
        bool beside = false;
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 e = seen.line(k);
            beside |= e.z < -1.001 * radius * std::hypot(e.x, e.y);
        }
        if (beside) continue;
        if (const CoverRun::Mate& mate = run.mates[i]; mate.apart >= 0) {
            seen.mate = see(run, x, y, start, axes, mate.triangle);
            seen.apart = mate.apart;
            seen.mate_apart = mate.its_apart;
        }
        out.push_back(seen);
    }
    return out;
}

CoverMask own_plane(const CoverModel& model, const CoverRun& run, uint32_t x, uint32_t y) {
    CoverMask mask =
        model.positive(glm::transpose(run.turned_axes(x, y)) * run.normal(x, y), run.dither(x, y));
    for (uint32_t w = 0; w < model.count() / 32; ++w) mask.words[w] = ~mask.words[w];
    return mask;
}

// Whether any of the light lies behind the triangle.
bool meets(const CoverModel& model, const SeenTriangle& t) {
    glm::dvec3 lines[3];  // of the unit disc, normals of length 1
    bool middle = true;
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 e = (t.height < 0 ? -1.0 : 1.0) * glm::cross(t.v[k], t.v[(k + 1) % 3]);
        lines[k] = glm::dvec3(e.x, e.y, e.z / model.radius()) / std::max(std::hypot(e.x, e.y), 1e-300);
        middle = middle && e.z >= 0;
    }
    if (middle) return true;
    for (int k = 0; k < 3; ++k) {
        if (std::abs(lines[k].z) >= 1) continue;
        const glm::dvec2 n(lines[k]), foot = -n * lines[k].z, along(-n.y, n.x);
        double high = std::sqrt(1 - lines[k].z * lines[k].z), low = -high;
        for (int other = 1; other < 3; ++other) {
            const glm::dvec3& l = lines[(k + other) % 3];
            const double at = glm::dot(glm::dvec2(l), foot) + l.z, slope = glm::dot(glm::dvec2(l), along);
            if (slope > 0) low = std::max(low, -at / slope);
            if (slope < 0) high = std::min(high, -at / slope);
            if (slope == 0 && at < 0) high = -2;
        }
        if (low < high) return true;
    }
    return false;
}

// Each triangle of a convex pair lies within the other's outer edges, too.
CoverMask hidden_by(const CoverModel& model, const SeenPair& t, double dither) {
    CoverMask mask = model.triangle(t.v[0], t.v[1], t.v[2], t.height, dither);
    if (t.apart < 0 || t.mate.height == 0) return mask;
    const glm::dvec3& other = t.mate.v[t.mate_apart];
    bool convex = true;
    for (int k = 0; k < 3; ++k) {
        const double at = glm::dot(t.line(k), other);
        convex = convex && (k == t.apart ? at < 0 : at >= 0) &&
                 model.positive(t.line(k), dither).count() > 0 &&
                 model.positive(t.mate.line(k), dither).count() > 0;
    }
    for (int k = 0; convex && k < 3; ++k)
        if (k != t.mate_apart) mask &= model.positive(t.mate.line(k), dither);
    return mask;
}

enum class Of { all, met };

// By the triangles that meet the light, or by all whose masks are not empty: where corners are seen close
// together, the masks of those beside the light need not be, and which of these the walk finds is the boxes'
// business.
CoverMask mask_of(const CoverModel& model, const CoverRun& run, const std::vector<SeenPair>& seen, uint32_t x,
                  uint32_t y, Of which) {
    CoverMask mask = own_plane(model, run, x, y);
    for (const SeenPair& t : seen)
        if (which == Of::all || meets(model, t)) mask |= hidden_by(model, t, run.dither(x, y));
    return mask;
}

// How far beside a line the table may put the border of what it covers: a count rounded either way, samples
// that do not lie on the ideal lines of their ranks, and half a bin of directions.
double border_error(const std::vector<glm::dvec2>& points, const CoverModel& model) {
    const auto place = [&](double k) {  // the c of a share of k samples
        double low = -1, high = 1;
        for (int i = 0; i < 50; ++i) {
            const double c = 0.5 * (low + high);
            (model.share(c) * model.count() < k ? low : high) = c;
        }
        return low;
    };
    double ranks = 0, turn = 0;
    for (uint32_t bin = 0; bin < blocks::HALF_PLANE_DIRECTIONS; ++bin) {
        const auto direction = [](double b) {
            const double p = b / blocks::HALF_PLANE_DIRECTIONS * 2 - 1;
            return glm::normalize(glm::dvec2(p, 1 - std::abs(p)));
        };
        const glm::dvec2 n = direction(bin + 0.5);
        turn =
            std::max(turn, std::max(glm::length(n - direction(bin)), glm::length(n - direction(bin + 1.0))));
        std::vector<double> along;
        for (const glm::dvec2& p : points) along.push_back(glm::dot(p, n));
        std::sort(along.begin(), along.end(), std::greater<>());
        for (uint32_t k = 0; k <= model.count(); ++k) {
            if (k > 0) ranks = std::max(ranks, -place(k - 1.0) - along[k - 1]);
            if (k < model.count()) ranks = std::max(ranks, along[k] + place(k + 1.0));
        }
    }
    return ranks + turn;
}

struct Differences {
    uint32_t left = 0;
    size_t pixels = 0, partial = 0, beside = 0, differ = 0, largest = 0;
    size_t samples = 0, wrong_samples = 0, wrong_far = 0;
    double squares = 0, sum = 0;
    double worst_share = 0;
};

Differences compare(const Shot& shot, uint32_t frame, uint32_t samples) {
    CoverRun run(shot, {.samples = samples});
    run.frame(frame);
    const TrianglesAcross across(run);
    const CoverModel model(samples, run.angular_radius(), shipped_nodes());
    const std::vector<uint32_t> words = CoverModel::words_of(shipped_nodes(), "light_samples");
    std::vector<glm::dvec2> points;
    const uint32_t row = samples == 64 ? 0 : samples == 128 ? 1 : 2;
    for (uint32_t i = 0; i < samples; ++i)
        points.emplace_back(double(std::bit_cast<float>(words[(row * 256 + i) * 2])),
                            double(std::bit_cast<float>(words[(row * 256 + i) * 2 + 1])));
    const double border = border_error(points, model) + 0.01;  // the sun's bulge is below
    Differences out;
    out.left = run.left();
    for (uint32_t y = 0; y < shot.size[1]; ++y)
        for (uint32_t x = 0; x < shot.size[0]; ++x) {
            if (!run.is_receiver(x, y) || glm::dot(run.normal(x, y), run.to_sun()) <= 0.0) continue;
            const std::vector<SeenPair> seen = seen_from(run, across, x, y);
            const CoverMask mask = mask_of(model, run, seen, x, y, Of::met),
                            most = mask_of(model, run, seen, x, y, Of::all);
            const auto said = int(std::lround((1 - double(run.visibility[run.at(x, y)])) * samples));
            // Of the last samples that are left, rays say whether they are hidden.
            const bool by_rays = mask.count() + samples / 64 + 2 >= samples;
            const auto off =
                by_rays ? 0 : size_t(std::max({int(mask.count()) - said, said - int(most.count()), 0}));
            ++out.pixels;
            out.partial += mask.count() != 0 && mask.count() != samples;
            out.differ += off != 0;
            out.beside += most.count() - mask.count();
            out.largest = std::max(out.largest, off);
            if (mask.count() == 0 || mask.count() == samples) continue;
            // Each sample by itself.
            uint32_t truly = 0;
            const glm::dvec3 n = glm::transpose(run.turned_axes(x, y)) * run.normal(x, y);
            for (uint32_t i = 0; i < samples; ++i) {
                const double bulged = 1 - model.bulge() * (1 - glm::dot(points[i], points[i]));
                const glm::dvec3 d(points[i] * model.radius() * bulged, 1);
                bool hidden = glm::dot(n, d) <= 0;
                double nearest = std::abs(glm::dot(n, d)) / (std::hypot(n.x, n.y) * model.radius());
                for (const SeenPair& t : seen) {
                    const double sign = t.height < 0 ? -1 : 1;
                    bool inside = true;
                    for (int k = 0; k < 3; ++k) {
                        const glm::dvec3 e = sign * glm::cross(t.v[k], t.v[(k + 1) % 3]);
                        const double at = glm::dot(e, d);
                        inside &= at >= 0;
                        nearest = std::min(nearest, std::abs(at) / (std::hypot(e.x, e.y) * model.radius()));
                    }
                    hidden |= inside;
                }
                truly += hidden;
                ++out.samples;
                out.wrong_samples += hidden != mask.has(i);
                out.wrong_far += hidden != mask.has(i) && nearest > border;
            }
            const double share = (double(mask.count()) - truly) / samples;
            out.squares += share * share;
            out.sum += share;
            out.worst_share = std::max(out.worst_share, std::abs(share));
        }
    std::printf(
        "%s, sun of %.2f degrees, %u samples: %zu pixels, %zu partial; %zu counts differ from the twin's, by "
        "up to %zu; triangles "
        "beside the sun hide %zu samples; of %zu samples %zu lie on another side of an edge than their mask "
        "says, %zu of them farther than %.3f of the sun's radius from every edge; their share off by %.4f "
        "rms, "
        "%+.4f on average, up to %.4f\n",
        shot.name.c_str(), shot.sun_angular_radius_deg, samples, out.pixels, out.partial, out.differ,
        out.largest, out.beside, out.samples, out.wrong_samples, out.wrong_far, border,
        std::sqrt(out.squares / double(out.partial)), out.sum / double(out.partial), out.worst_share);
    return out;
}

class CoverTwin : public GpuTest, public ::testing::WithParamInterface<const char*> {};

// Rounding of edges moves a count by one in a pixel of a hundred. With a dither that a driver's reordering of
// sums takes half away, one in four differs.
TEST_P(CoverTwin, SaysTheSame) {
    const Differences found = compare(shipped_shot(GetParam(), {128, 72}), 15, 128);
    EXPECT_GT(found.partial, 90u);
    EXPECT_LE(found.differ, 2 + found.partial / 50);
    EXPECT_LE(found.largest, 2u);
    EXPECT_EQ(found.wrong_far, 0u);
    EXPECT_LT(found.wrong_samples, found.samples / 40);
    EXPECT_LT(found.worst_share, 0.06);
}

INSTANTIATE_TEST_SUITE_P(Shots, CoverTwin,
                         ::testing::Values("colonnade", "engine", "lamp", "trees", "fan", "heightfield"),
                         [](const auto& test) { return std::string(test.param); });

class CoverTwinOf : public GpuTest {};

TEST_F(CoverTwinOf, OtherCountsSayTheSame) {
    for (const uint32_t samples : {64u, 256u}) {
        const Differences found = compare(shipped_shot("lamp", {96, 54}), 3, samples);
        EXPECT_LE(found.differ, 2 + found.partial / 50);
        EXPECT_EQ(found.wrong_far, 0u);
    }
}

// Of triangles smaller than the distance between samples more is hidden than there is: a mask can be empty,
// but not less. Here only that the shader says what the formulas say.
TEST_F(CoverTwinOf, WideSunsSayTheSame) {
    for (const double angle_deg : {2.0, 10.0, 30.0}) {
        Shot shot = shipped_shot("lamp", {32, 18});
        shot.sun_angular_radius_deg = angle_deg;
        const Differences found = compare(shot, 3, 128);
        if (found.left != 0 && ends_long_loops())
            GTEST_SKIP() << found.left << " pixels were cut short by the driver";
        EXPECT_EQ(found.left, 0u);
        EXPECT_LE(found.differ, 2 + found.partial / 10);
        EXPECT_EQ(found.wrong_far, 0u);
    }
}

}  // namespace
}  // namespace penumbra::test
