// SPDX-License-Identifier: MIT
// The published shadow denoiser (FidelityFX Shadow Denoiser 1.x: prepare, tile classification, three filters)
// in double precision, pixel by pixel and without any of the shaders' arrangements: what the GPU nodes are
// compared with. Geometry comes in ready: positions and matrices are the shaders' business and are tested
// elsewhere.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace penumbra::model {

// Images are row-major, width * height.
template <typename T>
using Image = std::vector<T>;

struct DenoiserInputs {
    int width = 0, height = 0;
    Image<uint8_t> lit;                   // the ray of this frame; must be 0 where there is no receiver
    Image<double> view_depth;             // metres; 0: no receiver
    Image<double> expected_depth;         // view depth that the surface, if static, had in the previous frame
    Image<std::array<double, 3>> normal;  // any length but zero where there is a receiver
    Image<double> facing;                 // cosine between normal and direction to the viewer
    Image<std::array<double, 2>> motion;  // previous uv - uv
    bool reset = false;                   // the state means nothing
};

// A plane at one depth seen face on by a camera that stands still.
DenoiserInputs flat_receiver(int width, int height);

struct Signal {
    double visibility = 0, variance = 0;
};

struct Moments {
    double mean = 0, deviations = 0, count = 0;  // deviations: sum of squares
};

enum class BlockState : uint32_t { work = 0, lit = 1, shadowed = 2 };

// What the next frame reads.
struct DenoiserState {
    Image<double> view_depth;
    Image<Moments> moments;
    Image<Signal> history;  // the first filter's output
};

struct DenoiserFrame {
    Image<double> mean;  // 17x17, of the blocks with work
    Image<Signal> reprojected, filtered0, filtered1, filtered2;
    Image<Moments> moments;
    std::vector<BlockState> tile_meta;  // ceil(width / 8) * ceil(height / 8)
    Image<double> visibility;
};

// How results are rounded to rg16f, r11g11b10f and r8 when they are stored. Devices may do either for floats.
enum class Storage { exact, nearest, toward_zero };

struct DenoiserSettings {
    Storage storage = Storage::nearest;
    double clamp_sigma = 0.5;
    bool contrast = true;  // the published last pass
};

// The parts, for comparing one node at a time. `reprojected` and the filters' results are rounded as stored.
DenoiserFrame classify_tiles(const DenoiserInputs& in, const DenoiserState& before,
                             const DenoiserSettings& settings);
Image<Signal> filter(const DenoiserInputs& in, const std::vector<BlockState>& tile_meta,
                     const Image<Signal>& signal, int step, Storage storage);
double with_contrast(const Signal& signal);

// One frame of all of them; `state` becomes what the next frame reads.
DenoiserFrame denoise(const DenoiserInputs& in, DenoiserState& state, const DenoiserSettings& settings = {});

// x >= 0 in a float format with 5 exponent bits (bias 15) and `mantissa_bits`: 10 fp16, 6 and 5 of
// r11g11b10f.
double round_to_float(double x, int mantissa_bits, Storage storage);

}  // namespace penumbra::model
