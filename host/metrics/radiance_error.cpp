// SPDX-License-Identifier: MIT
#include "host/metrics/radiance_error.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace penumbra {
namespace {

double luminance(double r, double g, double b) {
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;  // ITU-R BT.709
}

std::optional<double> ratio(double ray_errors, double squares, double noise) {
    if (!(ray_errors > 0) || !(squares > noise)) return std::nullopt;
    return ray_errors / (squares - noise);
}

RadianceErrorSums::Class total(const RadianceErrorSums& sums) {
    RadianceErrorSums::Class all;
    for (const auto& c : sums.classes) {
        all.pixels += c.pixels;
        all.ray_errors += c.ray_errors;
        all.squares += c.squares;
        all.noise += c.noise;
        all.image += c.image;
        all.truth += c.truth;
    }
    return all;
}

std::vector<float> luminances(const RadiancePlanes& planes) {
    std::vector<float> out;
    out.reserve(planes.rgb[0].size());
    for (size_t i = 0; i < planes.rgb[0].size(); ++i)
        out.push_back(static_cast<float>(luminance(planes.rgb[0][i], planes.rgb[1][i], planes.rgb[2][i])));
    return out;
}

// The largest of each value's neighbours along one axis; what is no number is none.
std::vector<float> largest_along(const std::vector<float>& in, size_t width, bool along_x) {
    const size_t stride = along_x ? 1 : width, count = along_x ? width : in.size() / width;
    std::vector<float> out(in.size());
    for (size_t p = 0; p < in.size(); ++p) {
        const size_t at = along_x ? p % width : p / width, line = p - at * stride;
        const size_t first = at - std::min<size_t>(at, firefly_reach),
                     last = std::min<size_t>(at + firefly_reach, count - 1);
        for (size_t i = first; i <= last; ++i) out[p] = std::max(out[p], in[line + i * stride]);
    }
    return out;
}

bool finite(const RadiancePlanes& planes, size_t i) {
    return std::isfinite(planes.rgb[0][i]) && std::isfinite(planes.rgb[1][i]) &&
           std::isfinite(planes.rgb[2][i]);
}

}  // namespace

size_t roughness_class(float roughness) {
    return static_cast<size_t>(std::ranges::lower_bound(roughness_class_ends, roughness) -
                               roughness_class_ends.begin());
}

void RadianceErrorSums::add(const RadianceErrorSums& other) {
    for (size_t i = 0; i < classes.size(); ++i) {
        classes[i].pixels += other.classes[i].pixels;
        classes[i].ray_errors += other.classes[i].ray_errors;
        classes[i].squares += other.classes[i].squares;
        classes[i].noise += other.classes[i].noise;
        classes[i].image += other.classes[i].image;
        classes[i].truth += other.classes[i].truth;
    }
    relative += other.relative;
    changes += other.changes;
    changed += other.changed;
    fireflies += other.fireflies;
    nonfinite += other.nonfinite;
}

std::optional<double> RadianceErrorSums::n_eff(size_t index) const {
    const Class& c = classes.at(index);
    return ratio(c.ray_errors, c.squares, c.noise);
}

std::optional<double> RadianceErrorSums::n_eff() const {
    const Class all = total(*this);
    return ratio(all.ray_errors, all.squares, all.noise);
}

std::optional<double> RadianceErrorSums::bias() const {
    const Class all = total(*this);
    if (!(all.truth > 0)) return std::nullopt;
    return all.image / all.truth - 1;
}

std::optional<double> RadianceErrorSums::relmse() const {
    if (pixels() == 0) return std::nullopt;
    return relative / static_cast<double>(pixels());
}

std::optional<double> RadianceErrorSums::flicker() const {
    if (changed == 0) return std::nullopt;
    return std::sqrt(changes / static_cast<double>(changed));
}

uint64_t RadianceErrorSums::pixels() const {
    return total(*this).pixels;
}

RadianceErrorSums radiance_errors(const RadiancePlanes& image, const RadianceTruth& truth) {
    const size_t size = truth.receiver.size();
    for (const auto& plane :
         {image.rgb[0], image.rgb[1], image.rgb[2], truth.signal.rgb[0], truth.signal.rgb[1],
          truth.signal.rgb[2], truth.roughness, truth.ray_error, truth.noise})
        if (plane.size() != size) throw std::invalid_argument("radiance_errors: planes differ in size");
    if (truth.width == 0 || size % truth.width != 0)
        throw std::invalid_argument("radiance_errors: no whole number of rows");
    const std::vector<float> should_be = luminances(truth.signal),
                             near = largest_along(largest_along(should_be, truth.width, true), truth.width,
                                                  false);
    RadianceErrorSums sums;
    for (size_t i = 0; i < size; ++i) {
        const bool number = finite(image, i);
        sums.nonfinite += !number;
        if (!(truth.receiver[i] > 0)) continue;
        std::array<double, 3> e{};
        double square = 0;
        for (size_t c = 0; c < 3; ++c) {
            if (number) e[c] = image.rgb[c][i];
            square += std::pow(e[c] - truth.signal.rgb[c][i], 2);
        }
        // The truth may be black here, too.
        if (!number) square = std::max(square + darkest_squared, double(truth.ray_error[i]));
        RadianceErrorSums::Class& c = sums.classes[roughness_class(truth.roughness[i])];
        const double is = luminance(e[0], e[1], e[2]),
                     should =
                         luminance(truth.signal.rgb[0][i], truth.signal.rgb[1][i], truth.signal.rgb[2][i]);
        ++c.pixels;
        c.ray_errors += truth.ray_error[i];
        c.squares += square;
        c.noise += truth.noise[i];
        c.image += is;
        c.truth += should;
        sums.relative += square / (should * should + darkest_squared);
        sums.fireflies += is_firefly(is, static_cast<double>(near[i]));
    }
    return sums;
}

RadianceErrorSums radiance_errors(const RadiancePlanes& image, const RadianceTruth& truth,
                                  const RadiancePlanes& image_before, const RadiancePlanes& truth_before) {
    RadianceErrorSums sums = radiance_errors(image, truth);
    for (const auto* planes : {&image_before, &truth_before})
        for (const auto& plane : planes->rgb)
            if (plane.size() != truth.receiver.size())
                throw std::invalid_argument("radiance_errors: frames differ in size");
    const std::vector<float> should_be = luminances(truth.signal);
    for (size_t i = 0; i < should_be.size(); ++i) {
        if (!(truth.receiver[i] > 0)) continue;
        const bool numbers = finite(image, i) && finite(image_before, i);
        double square = numbers ? 0 : darkest_squared;
        for (size_t c = 0; c < 3; ++c) {
            double change = truth.signal.rgb[c][i];
            if (numbers)
                change = double(image.rgb[c][i]) - change -
                         (double(image_before.rgb[c][i]) - truth_before.rgb[c][i]);
            square += std::pow(change, 2);
        }
        sums.changes += square / (std::pow(double(should_be[i]), 2) + darkest_squared);
        ++sums.changed;
    }
    return sums;
}

}  // namespace penumbra
