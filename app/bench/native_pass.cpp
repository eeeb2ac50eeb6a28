// SPDX-License-Identifier: MIT
#include "app/bench/native_pass.h"

#include <algorithm>
#include <glm/gtc/packing.hpp>
#include <glm/packing.hpp>
#include <random>

#if defined(__x86_64__)
#include <immintrin.h>
#define PENUMBRA_AVX2 __attribute__((target("avx2,fma,f16c")))
#endif

namespace penumbra {

NativeImages native_images(uint32_t width, uint32_t height) {
    NativeImages images{width, height, width + 2 * NativeImages::border, {}, {}, {}};
    const size_t texels = size_t(images.stride) * (height + 2 * NativeImages::border);
    images.signal.assign(texels, 0);
    images.depth.assign(texels, 1e15F);
    images.normal.assign(texels, 0);
    std::minstd_rand random(1);
    std::uniform_real_distribution<float> unit;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const bool wall = 3 * x > 2 * width;
            const float away = float(wall ? x : y) / float(wall ? width : height);
            const glm::vec3 n = wall ? glm::vec3(1, 0, 0) : glm::vec3(0, 0.8F, 0.6F);
            images.signal[images.at(x, y)] = glm::packHalf2x16({unit(random), 0.25F * unit(random)});
            images.depth[images.at(x, y)] = (wall ? 6.0F : 10.0F) - 4 * away;
            images.normal[images.at(x, y)] = glm::packUnorm3x10_1x2(glm::vec4(0.5F * n + 0.5F, 0));
        }
    return images;
}

void native_pass_plain(const NativeImages& images, std::vector<uint32_t>& out) {
    const auto normal = [&](size_t texel) {
        return 2.0F * glm::vec3(glm::unpackUnorm3x10_1x2(images.normal[texel])) - 1.0F;
    };
    for (uint32_t y = 0; y < images.height; ++y)
        for (uint32_t x = 0; x < images.width; ++x) {
            const size_t here = images.at(x, y);
            const glm::vec3 n = normal(here);
            const float by_tolerance = 1 / (native_tolerance * images.depth[here]);
            float mean = 0, variance = 0, weights = 0;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const size_t there = here + ptrdiff_t(dy) * images.stride + dx;
                    const glm::vec2 s = glm::unpackHalf2x16(images.signal[there]);
                    const float cosine = std::max(glm::dot(n, normal(there)), 0.0F);
                    const float off = (images.depth[there] - images.depth[here]) * by_tolerance;
                    const float square = cosine * cosine;
                    const float w =
                        native_kernel[dx & 1] * native_kernel[dy & 1] * square * square / (1 + off * off);
                    mean += w * s.x;
                    variance += w * w * s.y;
                    weights += w;
                }
            out[here] = glm::packHalf2x16({mean / weights, variance / (weights * weights)});
        }
}

#if defined(__x86_64__)

// What has AVX2 has F16C, for which clang 14 has no name.
bool has_avx2() {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}

namespace {

struct Signal {
    __m256 mean, variance;
};

PENUMBRA_AVX2 Signal signal_at(const uint32_t* texels) {
    const __m256i words = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(texels));
    const __m256i apart = _mm256_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15,  //
                                           0, 1, 4, 5, 8, 9, 12, 13, 2, 3, 6, 7, 10, 11, 14, 15);
    const __m256i halves = _mm256_permute4x64_epi64(_mm256_shuffle_epi8(words, apart), 0xd8);
    return {_mm256_cvtph_ps(_mm256_castsi256_si128(halves)),
            _mm256_cvtph_ps(_mm256_extracti128_si256(halves, 1))};
}

PENUMBRA_AVX2 __m256i packed(const Signal& s) {
    const __m128i mean = _mm256_cvtps_ph(s.mean, _MM_FROUND_TO_NEAREST_INT);
    const __m128i variance = _mm256_cvtps_ph(s.variance, _MM_FROUND_TO_NEAREST_INT);
    return _mm256_set_m128i(_mm_unpackhi_epi16(mean, variance), _mm_unpacklo_epi16(mean, variance));
}

struct Codes {
    __m256 x, y, z;  // 0 .. 1023
};

PENUMBRA_AVX2 Codes normal_at(const uint32_t* texels) {
    const __m256i words = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(texels)),
                  mask = _mm256_set1_epi32(1023);
    return {_mm256_cvtepi32_ps(_mm256_and_si256(words, mask)),
            _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(words, 10), mask)),
            _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(words, 20), mask))};
}

}  // namespace

PENUMBRA_AVX2 void native_pass_avx2(const NativeImages& images, std::vector<uint32_t>& out) {
    const __m256 one = _mm256_set1_ps(1), zero = _mm256_setzero_ps(), step = _mm256_set1_ps(2.0F / 1023);
    for (uint32_t y = 0; y < images.height; ++y)
        for (uint32_t x = 0; x < images.width; x += 8) {
            const size_t here = images.at(x, y);
            const __m256 z = _mm256_loadu_ps(&images.depth[here]);
            const __m256 by_tolerance = _mm256_div_ps(_mm256_set1_ps(1 / native_tolerance), z);
            const Codes own = normal_at(&images.normal[here]);
            // The cosine of two normals is a sum over the neighbour's codes, whose factors are the own one's.
            const __m256 nx = _mm256_fmsub_ps(own.x, step, one), ny = _mm256_fmsub_ps(own.y, step, one),
                         nz = _mm256_fmsub_ps(own.z, step, one);
            const __m256 offset = _mm256_add_ps(nx, _mm256_add_ps(ny, nz));
            const __m256 fx = _mm256_mul_ps(nx, step), fy = _mm256_mul_ps(ny, step),
                         fz = _mm256_mul_ps(nz, step);
            __m256 mean = zero, variance = zero, weights = zero;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const size_t there = here + ptrdiff_t(dy) * images.stride + dx;
                    const Signal s = signal_at(&images.signal[there]);
                    const Codes n = normal_at(&images.normal[there]);
                    const __m256 off =
                        _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(&images.depth[there]), z), by_tolerance);
                    const __m256 cosine = _mm256_max_ps(
                        zero,
                        _mm256_fmadd_ps(n.x, fx, _mm256_fmadd_ps(n.y, fy, _mm256_fmsub_ps(n.z, fz, offset))));
                    const __m256 square = _mm256_mul_ps(cosine, cosine);
                    const __m256 spatial = _mm256_set1_ps(native_kernel[dx & 1] * native_kernel[dy & 1]);
                    const __m256 w = _mm256_div_ps(_mm256_mul_ps(spatial, _mm256_mul_ps(square, square)),
                                                   _mm256_fmadd_ps(off, off, one));
                    mean = _mm256_fmadd_ps(w, s.mean, mean);
                    variance = _mm256_fmadd_ps(_mm256_mul_ps(w, w), s.variance, variance);
                    weights = _mm256_add_ps(weights, w);
                }
            const __m256 by_weights = _mm256_div_ps(one, weights);
            const Signal filtered{_mm256_mul_ps(mean, by_weights),
                                  _mm256_mul_ps(variance, _mm256_mul_ps(by_weights, by_weights))};
            _mm256_storeu_si256(reinterpret_cast<__m256i*>(&out[here]), packed(filtered));
        }
}

#else

bool has_avx2() {
    return false;
}
void native_pass_avx2(const NativeImages&, std::vector<uint32_t>&) {}

#endif

}  // namespace penumbra
