// SPDX-License-Identifier: MIT
// The unit in which costs carry over from one machine to another: a 3x3 edge-aware pass over mean and
// variance, depth and normals, written by hand for eight pixels at a time (AVX2, FMA, F16C) and run by one
// thread. Elsewhere a plain loop takes its place: a unit of that machine's own, several times as large.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace penumbra {

// Rows of `stride` texels; `border` of them lie around the image, so that no tap needs a test.
struct NativeImages {
    static constexpr uint32_t border = 8;
    uint32_t width, height, stride;  // width: a multiple of 8
    std::vector<uint32_t> signal;    // mean and variance, halves
    std::vector<float> depth;        // metres; far outside the image, where nothing weighs anything
    std::vector<uint32_t> normal;    // 10 bits per axis
    size_t at(uint32_t x, uint32_t y) const { return size_t(y + border) * stride + x + border; }
};

// Noise on two planes that meet in an edge.
NativeImages native_images(uint32_t width, uint32_t height);

constexpr float native_kernel[2] = {1.0F, 0.5F};  // per axis: centre, side
constexpr float native_tolerance = 0.02F;         // of the depth

bool has_avx2();  // this processor, and what else the pass by hand needs

// Filters images.signal into `out`, which has the same size. By hand only where has_avx2().
void native_pass_avx2(const NativeImages& images, std::vector<uint32_t>& out);
void native_pass_plain(const NativeImages& images, std::vector<uint32_t>& out);

// The one that this processor can run.
inline void native_pass(const NativeImages& images, std::vector<uint32_t>& out) {
    has_avx2() ? native_pass_avx2(images, out) : native_pass_plain(images, out);
}

}  // namespace penumbra
