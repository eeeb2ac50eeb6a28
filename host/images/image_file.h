// SPDX-License-Identifier: MIT
// EXR in full precision, PNG for the eye. Files appear whole or not at all: they are written beside their
// name and renamed. Links are followed, and devices and pipes are written into.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/diagnostic.h"

namespace penumbra {

// An output file could not be written; the text names it and says why.
class FileError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

enum class PlaneType { half, real, uint };

// One named channel, rows from the top.
struct Plane {
    std::string name;
    PlaneType type = PlaneType::real;
    std::vector<float> values;    // half (rounded when written) and real
    std::vector<uint32_t> words;  // uint
};

struct PlanarImage {
    uint32_t width = 0, height = 0;
    std::vector<Plane> planes;
    bool light = false;  // "R", "G", "B" are radiance, of which there is no largest

    const Plane* find(std::string_view name) const;
};

// Throws FileError; std::invalid_argument where a plane's size is not width * height.
void write_exr(const std::filesystem::path& path, const PlanarImage& image);

// Any scan-line or tiled EXR; planes in the file's (alphabetical) order. Sub-sampled channels are an error.
std::optional<PlanarImage> read_exr(const std::filesystem::path& path, Diagnostics& diagnostics);

// What a screen shows of radiance, as a film takes it: 1 - e^-x. Small values are as they are, none is cut
// off.
float exposed(float radiance);

// 8-bit PNG of linear RGB triples, sRGB-encoded and clamped. NaN is shown as magenta, so that it is seen.
void write_png_color(const std::filesystem::path& path, uint32_t width, uint32_t height,
                     std::span<const float> rgb);

// The same of radiance, exposed.
void write_png_light(const std::filesystem::path& path, uint32_t width, uint32_t height,
                     std::span<const float> rgb);

// 8-bit PNG, grey = value * 255 without a transfer curve (visibility). NaN is shown as magenta.
void write_png_linear(const std::filesystem::path& path, uint32_t width, uint32_t height,
                      std::span<const float> values);

// A PNG file's bytes, of 8-bit RGBA texels, always the same for the same texels. Throws FileError.
std::vector<std::byte> png_of_rgba(uint32_t width, uint32_t height, std::span<const uint8_t> rgba);

// Replaces the file's contents in one step, but of what is no regular file. Throws FileError.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace penumbra
