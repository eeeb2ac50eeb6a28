// SPDX-License-Identifier: MIT
#include "host/metrics/radiance_error.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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

uint64_t RadianceErrorSums::pixels() const {
    return total(*this).pixels;
}

RadianceErrorSums radiance_errors(const RadiancePlanes& image, const RadianceTruth& truth) {
    const size_t size = truth.receiver.size();
    for (const auto& plane :
         {image.rgb[0], image.rgb[1], image.rgb[2], truth.signal.rgb[0], truth.signal.rgb[1],
          truth.signal.rgb[2], truth.roughness, truth.ray_error, truth.noise})
        if (plane.size() != size) throw std::invalid_argument("radiance_errors: planes differ in size");
    RadianceErrorSums sums;
    for (size_t i = 0; i < size; ++i) {
        const double e[] = {image.rgb[0][i], image.rgb[1][i], image.rgb[2][i]};
        if (!std::isfinite(e[0]) || !std::isfinite(e[1]) || !std::isfinite(e[2])) {
            ++sums.nonfinite;
            continue;
        }
        if (!(truth.receiver[i] > 0)) continue;
        double square = 0;
        for (size_t c = 0; c < 3; ++c) square += std::pow(e[c] - truth.signal.rgb[c][i], 2);
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
        sums.relative += square / (should * should + 0.01);
        sums.fireflies += is > 4 * should + 1;
    }
    return sums;
}

}  // namespace penumbra
