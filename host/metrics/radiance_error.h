// SPDX-License-Identifier: MIT
// Errors of demodulated radiance (what arrives under a pixel's lobe; shaders/reflections/lobe.glsl) by class
// of roughness. Sums over pixels, frames and seeds, kept apart from the ratios made of them.
//
// N_eff of a class: the sum of the expected squared errors of one ray per pixel, over that of the image's
// squared errors, both summed over the colour channels. The truth knows the first from its own rays; its own
// noise is taken from the second.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace penumbra {

constexpr double darkest_squared = 0.01;  // of relative errors: keeps black from dividing by nothing

// Upper ends of the classes but the last, in perceptual roughness.
inline constexpr std::array<float, 4> roughness_class_ends{0.05f, 0.15f, 0.3f, 0.5f};
inline constexpr size_t roughness_classes = roughness_class_ends.size() + 1;
size_t roughness_class(float roughness);

struct RadiancePlanes {
    std::array<std::span<const float>, 3> rgb;
};

// Planes of the image that `penumbra reference --signal` writes; all of one size.
struct RadianceTruth {
    uint32_t width = 0;  // of a row
    RadiancePlanes signal;
    std::span<const float> receiver;   // 1: a surface
    std::span<const float> roughness;  // perceptual
    std::span<const float> ray_error;  // expected squared error of one ray, summed over the channels
    std::span<const float> noise;      // the same of the truth itself
};

struct RadianceErrorSums {
    struct Class {
        uint64_t pixels = 0;
        double ray_errors = 0, squares = 0, noise = 0;
        double image = 0, truth = 0;  // sums of luminance
    };
    std::array<Class, roughness_classes> classes;
    double relative = 0;     // sum of squares over (luminance^2 + .01)
    uint64_t fireflies = 0;  // pixels of which is_firefly() holds
    // Pixels of the whole image that are no number. Where they are receivers they count as black, with an
    // error that is no smaller than one ray's, than all of the truth, and than what darkest_squared is of it.
    uint64_t nonfinite = 0;
    // Of what the error has changed since the frame before: squares over (luminance^2 + .01), and pixels.
    double changes = 0;
    uint64_t changed = 0;

    void add(const RadianceErrorSums& other);
    // Nothing where the class has no pixels or no error that is told from the truth's.
    std::optional<double> n_eff(size_t roughness_class) const;
    std::optional<double> n_eff() const;
    std::optional<double> bias() const;    // of the mean luminance, relative
    std::optional<double> relmse() const;  // with the truth's noise in it
    // Root of the mean relative square by which the error changes from frame to frame: what a person sees
    // crawl. An error that stays is none, but a pixel that is no number in either frame changes by all of the
    // truth. Nothing without two frames in a row.
    std::optional<double> flicker() const;
    uint64_t pixels() const;
};

// A pixel is a firefly where its luminance exceeds twice the truth's largest within so many pixels, and that
// by .1: brighter than anything near it may be, so neither an edge out of place nor a blur is one.
inline constexpr uint32_t firefly_reach = 4;
constexpr bool is_firefly(double luminance, double largest_near) {
    return luminance > 2 * largest_near + 0.1;
}

// One frame. Throws std::invalid_argument where planes differ in size.
RadianceErrorSums radiance_errors(const RadiancePlanes& image, const RadianceTruth& truth);

// The same with its change since the frame before, whose image and truth have the same size.
RadianceErrorSums radiance_errors(const RadiancePlanes& image, const RadianceTruth& truth,
                                  const RadiancePlanes& image_before, const RadiancePlanes& truth_before);

}  // namespace penumbra
