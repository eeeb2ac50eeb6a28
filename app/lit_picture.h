// SPDX-License-Identifier: MIT
// Whole pictures in linear radiance, judged as a display shows them: clipped at 1, as `render` writes PNGs.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "host/images/image_file.h"
#include "host/metrics/flip.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

struct Picture {
    uint32_t width = 0, height = 0;
    std::vector<glm::vec3> rgb;  // rows from the top
};

// Channels R, G and B of an EXR; nothing, with an error, where one is missing.
std::optional<Picture> read_picture(const std::filesystem::path& file, Diagnostics& diagnostics);

struct PictureError {
    double relmse = 0;           // mean of squares over (luminance^2 + .01) of linear radiance
    std::optional<double> bias;  // of the mean luminance, relative
    FlipPool flip;               // over all pixels
    uint64_t nonfinite = 0;      // pixels, which count as black
};
// Of the same size, and not empty.
// Whether all of a truth is finite; the first pixel that is not is an error of its file's.
bool is_finite(const Picture& truth, const std::filesystem::path& file, Diagnostics& diagnostics);

// `truth` is finite.
PictureError picture_error(const Picture& image, const Picture& truth);

// With channels R, G and B, as read_picture() reads them.
PlanarImage planar(const Picture& picture);

// Both in one PNG, the image on the left. Throws FileError.
void write_beside(const std::filesystem::path& file, const Picture& left, const Picture& right);

}  // namespace penumbra
