// SPDX-License-Identifier: MIT
// The points start as a Fibonacci spiral and are moved one at a time, kept where the squared distances from
// the ideal lines fall or, while it is warm, rise a little.
#include "nodes/tables/light_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace penumbra {
namespace {

using std::numbers::pi;

constexpr uint32_t annealed_directions = 32;
constexpr uint32_t moves_per_point = 400;
constexpr double grid = 32767;  // as images keep points: two signed 16-bit fractions

// PCG, as shaders/common/hash.glsl has it.
class Random {
  public:
    double next() {
        state_ = state_ * 747796405u + 2891336453u;
        const uint32_t word = ((state_ >> ((state_ >> 28) + 4u)) ^ state_) * 277803737u;
        return (word >> 22 ^ word) * 0x1p-32;
    }

  private:
    uint32_t state_ = 1;
};

LightSample on_grid(LightSample p) {
    return {std::round(p[0] * grid) / grid, std::round(p[1] * grid) / grid};
}
double along(const LightSample& p, const std::array<double, 2>& n) {
    return p[0] * n[0] + p[1] * n[1];
}

double half_area(LightShape shape, const std::array<double, 2>& n, double c) {
    return shape == LightShape::disc ? half_disc_area(c) : half_square_area(n, c);
}

// The place x along a direction behind which (seen from above) `share` of the light lies: half_area(-x) =
// share.
double place_of(LightShape shape, const std::array<double, 2>& n, double share) {
    double hi = shape == LightShape::disc ? 1 : std::abs(n[0]) + std::abs(n[1]), lo = -hi;
    for (int i = 0; i < 60; ++i) {
        const double x = 0.5 * (lo + hi);
        (half_area(shape, n, -x) > share ? lo : hi) = x;
    }
    return 0.5 * (lo + hi);
}

class Annealing {
  public:
    Annealing(uint32_t count, LightShape shape) : shape_(shape) {
        for (uint32_t i = 0; i < count; ++i) points_.push_back(on_grid(first_place(i, count)));
        for (uint32_t d = 0; d < annealed_directions; ++d) {
            const double angle = pi * (d + 0.5) / annealed_directions;
            normals_[d] = {std::cos(angle), std::sin(angle)};
            for (uint32_t k = 0; k < count; ++k) {
                ideal_[d].push_back(place_of(shape, normals_[d], 1 - (k + 0.5) / count));
                sorted_[d].push_back(along(points_[k], normals_[d]));
            }
            std::sort(sorted_[d].begin(), sorted_[d].end());
            errors_[d] = error_of(sorted_[d], d);
        }
    }

    std::vector<LightSample> run() {
        const auto count = static_cast<uint32_t>(points_.size());
        const uint32_t moves = moves_per_point * count;
        const double spacing = std::sqrt(pi / count);
        for (uint32_t m = 0; m < moves; ++m) {
            const double cold = 1 - double(m) / moves;  // 1 to 0
            const uint32_t i = std::min(static_cast<uint32_t>(random_.next() * count), count - 1);
            const double reach = spacing * (0.02 + cold), angle = 2 * pi * random_.next(),
                         r = reach * random_.next();
            const LightSample moved =
                on_grid({points_[i][0] + r * std::cos(angle), points_[i][1] + r * std::sin(angle)});
            const double allowed = 0.1 * cold * cold * total() / count * -std::log(1 - random_.next());
            if (inside(moved)) try_move(i, moved, allowed);
        }
        return points_;
    }

  private:
    // A spiral in the disc; in the square a Kronecker lattice by the roots of x^3 = x + 1.
    LightSample first_place(uint32_t i, uint32_t count) const {
        if (shape_ == LightShape::square) {
            const double root = 1.32471795724474602596, x = i / root, y = i / (root * root);
            return {2 * (x - std::floor(x)) - 1, 2 * (y - std::floor(y)) - 1};
        }
        const double angle = i * pi * (3 - std::sqrt(5.0)), radius = std::sqrt((i + 0.5) / count);
        return {radius * std::cos(angle), radius * std::sin(angle)};
    }

    bool inside(const LightSample& p) const {
        return shape_ == LightShape::disc ? p[0] * p[0] + p[1] * p[1] < 1
                                          : std::max(std::abs(p[0]), std::abs(p[1])) < 1;
    }

    double error_of(const std::vector<double>& sorted, uint32_t d) const {
        double sum = 0;
        for (size_t k = 0; k < sorted.size(); ++k)
            sum += (sorted[k] - ideal_[d][k]) * (sorted[k] - ideal_[d][k]);
        return sum;
    }

    double total() const { return std::accumulate(errors_.begin(), errors_.end(), 0.0); }

    void try_move(uint32_t i, const LightSample& moved, double allowed) {
        auto sorted = sorted_;
        auto errors = errors_;
        double change = 0;
        for (uint32_t d = 0; d < annealed_directions; ++d) {
            std::vector<double>& s = sorted[d];
            s.erase(std::lower_bound(s.begin(), s.end(), along(points_[i], normals_[d])));
            const double place = along(moved, normals_[d]);
            s.insert(std::lower_bound(s.begin(), s.end(), place), place);
            errors[d] = error_of(s, d);
            change += errors[d] - errors_[d];
        }
        if (change > allowed) return;
        points_[i] = moved;
        sorted_.swap(sorted);
        errors_ = errors;
    }

    LightShape shape_;
    std::array<std::vector<double>, annealed_directions> ideal_;  // ascending
    std::array<std::array<double, 2>, annealed_directions> normals_{};
    std::vector<LightSample> points_;
    std::array<std::vector<double>, annealed_directions> sorted_;
    std::array<double, annealed_directions> errors_{};
    Random random_;
};

}  // namespace

std::array<double, 2> half_plane_normal(uint32_t bin) {
    const double p = (bin + 0.5) / HALF_PLANE_DIRECTIONS * 2 - 1, y = 1 - std::abs(p),
                 length = std::hypot(p, y);
    return {p / length, y / length};
}

std::vector<LightSample> light_samples(uint32_t count, LightShape shape) {
    return Annealing(count, shape).run();
}

double half_disc_area(double c) {
    c = std::clamp(c, -1.0, 1.0);
    return 0.5 + (c * std::sqrt(1 - c * c) + std::asin(c)) / pi;
}

// The sum of two uniform numbers of unequal width: a trapezium's area.
double half_square_area(const std::array<double, 2>& n, double c) {
    const double x = std::abs(n[0]), y = std::abs(n[1]), wide = std::max(x, y), narrow = std::min(x, y);
    c = std::clamp(c, -(wide + narrow), wide + narrow);
    const double beyond = std::max(std::abs(c) - (wide - narrow), 0.0),
                 corner = narrow > 0 ? beyond * beyond / (8 * wide * narrow) : 0;
    return 0.5 + c / (2 * wide) - std::copysign(corner, c);
}

std::vector<uint32_t> half_plane_table(const std::vector<LightSample>& samples) {
    const auto count = static_cast<uint32_t>(samples.size());
    const uint32_t words = count / 32;
    std::vector<uint32_t> table(size_t{HALF_PLANE_DIRECTIONS} * (count + 1) * words);
    for (uint32_t bin = 0; bin < HALF_PLANE_DIRECTIONS; ++bin) {
        const std::array<double, 2> n = half_plane_normal(bin);
        std::vector<uint32_t> order(count);
        std::iota(order.begin(), order.end(), 0u);
        std::stable_sort(order.begin(), order.end(),
                         [&](uint32_t a, uint32_t b) { return along(samples[a], n) > along(samples[b], n); });
        uint32_t* entry = &table[size_t{bin} * (count + 1) * words];
        for (uint32_t k = 0; k < count; ++k, entry += words) {
            std::copy(entry, entry + words, entry + words);
            entry[words + order[k] / 32] |= 1u << order[k] % 32;
        }
    }
    return table;
}

}  // namespace penumbra
