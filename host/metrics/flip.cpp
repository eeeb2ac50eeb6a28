// SPDX-License-Identifier: MIT
// From the paper's formulas; section numbers are the paper's. The colour difference compares what an observer
// at that distance can resolve (contrast sensitivity filters), in a space where distances mean something; the
// feature difference compares edges and points of the unfiltered luminance; the latter raises the former.
#include "host/metrics/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <stdexcept>

namespace penumbra {
namespace {

using glm::dvec2, glm::dvec3, glm::dmat3;

// Rows of the sRGB primaries' XYZ (IEC 61966-2-1, from the chromaticities; white D65). glm has columns.
const dmat3 xyz_from_rgb(0.41238656, 0.21263682, 0.01933062, 0.35759149, 0.71518298, 0.11919716, 0.18045049,
                         0.0721802, 0.95037259);

dvec3 white() {
    return xyz_from_rgb * dvec3(1);
}

// 4.1: a linear opponent space, in which filtering does not shift hues.
dvec3 opponent(const dvec3& rgb) {
    const dvec3 r = xyz_from_rgb * rgb / white();
    return {116 * r.y - 16, 500 * (r.x - r.y), 200 * (r.y - r.z)};
}

dvec3 rgb_of_opponent(const dvec3& o) {
    const double y = (o.x + 16) / 116;
    static const dmat3 rgb_from_xyz = glm::inverse(xyz_from_rgb);
    return rgb_from_xyz * (dvec3(y + o.y / 500, y, y - o.z / 200) * white());
}

// CIELAB with the chroma of dark colours damped (Hunt effect), 4.1.3.
dvec3 hunt_lab(const dvec3& rgb) {
    constexpr double delta = 6.0 / 29;
    const auto f = [](double t) {
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
    };
    const dvec3 r = xyz_from_rgb * rgb / white();
    const double light = 116 * f(r.y) - 16;
    return {light, 0.01 * light * 500 * (f(r.x) - f(r.y)), 0.01 * light * 200 * (f(r.y) - f(r.z))};
}

double hyab(const dvec3& a, const dvec3& b) {
    return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

constexpr double color_exponent = 0.7;  // 4.1.4
constexpr double split_at = 0.4, split_to = 0.95;

// 4.1.4: large differences are all alike, small ones are spread over most of the range.
double spread(double difference) {
    static const double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), color_exponent);
    const double d = std::pow(difference, color_exponent), knee = split_at * largest;
    if (d < knee) return split_to / knee * d;
    return split_to + (d - knee) / (largest - knee) * (1 - split_to);
}

// A row of weights about 0.
struct Kernel {
    int reach = 0;
    std::vector<double> weights;
};

// 4.1.1: the contrast sensitivity of a channel, a sum of up to two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 /
// b) of x degrees, as separable terms with a common normalisation.
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr Sensitivity achromatic{1, 0.0047, 0, 1e-5}, red_green{1, 0.0053, 0, 1e-5},
    blue_yellow{34.1, 0.04, 13.5, 0.025};

int sensitivity_reach(double ppd) {
    return static_cast<int>(
        std::ceil(3 * std::sqrt(blue_yellow.b1 / (2 * glm::pi<double>() * glm::pi<double>())) * ppd));
}

Kernel gaussian(double b, double ppd) {
    Kernel kernel{sensitivity_reach(ppd), {}};
    for (int i = -kernel.reach; i <= kernel.reach; ++i)
        kernel.weights.push_back(std::exp(-std::pow(glm::pi<double>() * i / ppd, 2) / b));
    return kernel;
}

double sum_of(const Kernel& kernel) {
    double sum = 0;
    for (const double w : kernel.weights) sum += w;
    return sum;
}

using Channel = std::vector<double>;

// Along one axis; the image goes on beyond its border as its last pixel.
Channel convolve(const Channel& in, uint32_t width, uint32_t height, const Kernel& kernel, bool along_x) {
    Channel out(in.size());
    const int limit = static_cast<int>(along_x ? width : height) - 1;
    const size_t stride = along_x ? 1 : width;
    for (size_t p = 0; p < in.size(); ++p) {
        const int at = static_cast<int>(along_x ? p % width : p / width);
        const size_t line = p - static_cast<size_t>(at) * stride;
        double sum = 0;
        for (int i = -kernel.reach; i <= kernel.reach; ++i)
            sum += kernel.weights[static_cast<size_t>(i + kernel.reach)] *
                   in[line + static_cast<size_t>(std::clamp(at + i, 0, limit)) * stride];
        out[p] = sum;
    }
    return out;
}

Channel see(const Channel& in, uint32_t width, uint32_t height, const Sensitivity& s, double ppd) {
    Channel out(in.size(), 0);
    double weight = 0;
    for (const auto& [a, b] : {std::pair{s.a1, s.b1}, std::pair{s.a2, s.b2}}) {
        if (a == 0) continue;
        const Kernel kernel = gaussian(b, ppd);
        const double scale = a * std::sqrt(glm::pi<double>() / b);
        weight += scale * std::pow(sum_of(kernel), 2);
        const Channel part =
            convolve(convolve(in, width, height, kernel, true), width, height, kernel, false);
        for (size_t p = 0; p < out.size(); ++p) out[p] += scale * part[p];
    }
    for (double& value : out) value /= weight;
    return out;
}

// 4.2: first and second derivatives of a Gaussian as wide as a visible feature; the positive and the negative
// part of each sum to one.
constexpr double feature_degrees = 0.082;

struct FeatureKernels {
    Kernel smooth, edge, point;
};

FeatureKernels feature_kernels(double ppd) {
    const double sigma = 0.5 * feature_degrees * ppd;
    const int reach = static_cast<int>(std::ceil(3 * sigma));
    FeatureKernels k{{reach, {}}, {reach, {}}, {reach, {}}};
    for (int i = -reach; i <= reach; ++i) {
        const double g = std::exp(-0.5 * i * i / (sigma * sigma));
        k.smooth.weights.push_back(g);
        k.edge.weights.push_back(-i * g);
        k.point.weights.push_back((i * i / (sigma * sigma) - 1) * g);
    }
    const double smooth = sum_of(k.smooth);
    for (double& w : k.smooth.weights) w /= smooth;
    for (Kernel* kernel : {&k.edge, &k.point}) {
        double positive = 0, negative = 0;
        for (const double w : kernel->weights) (w > 0 ? positive : negative) += std::abs(w);
        for (double& w : kernel->weights) w /= w > 0 ? positive : negative;
    }
    return k;
}

struct Features {
    Channel edge, point;  // lengths of the gradients
};

Features find_features(const Channel& luminance, uint32_t width, uint32_t height, double ppd) {
    const FeatureKernels k = feature_kernels(ppd);
    const auto length = [&](const Kernel& derivative) {
        const Channel x = convolve(convolve(luminance, width, height, derivative, true), width, height,
                                   k.smooth, false),
                      y = convolve(convolve(luminance, width, height, k.smooth, true), width, height,
                                   derivative, false);
        Channel out(x.size());
        for (size_t p = 0; p < x.size(); ++p) out[p] = std::hypot(x[p], y[p]);
        return out;
    };
    return {length(k.edge), length(k.point)};
}

// What is made of one image.
struct Seen {
    std::vector<dvec3> color;
    Features features;
};

Seen look_at(uint32_t width, uint32_t height, std::span<const glm::vec3> image, double ppd) {
    std::array<Channel, 3> channels;
    Channel luminance;
    for (const glm::vec3& rgb : image) {
        const dvec3 o = opponent(glm::clamp(dvec3(rgb), 0.0, 1.0));
        for (int c = 0; c < 3; ++c) channels[static_cast<size_t>(c)].push_back(o[c]);
        luminance.push_back((o.x + 16) / 116);
    }
    Seen seen{{}, find_features(luminance, width, height, ppd)};
    const std::array sensitivities{achromatic, red_green, blue_yellow};
    for (size_t c = 0; c < 3; ++c) channels[c] = see(channels[c], width, height, sensitivities[c], ppd);
    for (size_t p = 0; p < image.size(); ++p)
        seen.color.push_back(hunt_lab(
            glm::clamp(rgb_of_opponent({channels[0][p], channels[1][p], channels[2][p]}), 0.0, 1.0)));
    return seen;
}

}  // namespace

std::vector<float> flip_map(uint32_t width, uint32_t height, std::span<const glm::vec3> reference,
                            std::span<const glm::vec3> image, double pixels_per_degree) {
    const size_t pixels = size_t{width} * height;
    if (reference.size() != pixels || image.size() != pixels || pixels == 0)
        throw std::invalid_argument("flip_map: images of different sizes");
    const Seen a = look_at(width, height, reference, pixels_per_degree),
               b = look_at(width, height, image, pixels_per_degree);
    std::vector<float> map;
    map.reserve(pixels);
    for (size_t p = 0; p < pixels; ++p) {
        const double color = spread(hyab(a.color[p], b.color[p]));
        const double feature = std::sqrt(std::max(std::abs(a.features.edge[p] - b.features.edge[p]),
                                                  std::abs(a.features.point[p] - b.features.point[p])) *
                                         glm::one_over_root_two<double>());
        map.push_back(static_cast<float>(std::pow(color, 1 - std::min(feature, 1.0))));
    }
    return map;
}

std::optional<FlipPool> pool_flip(std::vector<float> values) {
    if (values.empty()) return std::nullopt;
    std::sort(values.begin(), values.end());
    double sum = 0;
    for (const float v : values) sum += static_cast<double>(v);
    FlipPool pool;
    pool.mean = sum / static_cast<double>(values.size());
    pool.p95 = static_cast<double>(values[(values.size() - 1) * 95 / 100]);
    double below = 0;
    for (const float v : values) {
        below += static_cast<double>(v);
        pool.weighted_median = static_cast<double>(v);
        if (2 * below >= sum) break;
    }
    return pool;
}

}  // namespace penumbra
