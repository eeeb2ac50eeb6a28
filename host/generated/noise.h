// SPDX-License-Identifier: MIT
// Random numbers and value noise for generated scenes: integers all the way to the last step, so that every
// machine makes the same scene (the standard library's distributions differ).
#pragma once

#include <cmath>
#include <cstdint>

namespace penumbra {

// PCG hash, O'Neill 2014 (RXS-M-XS 32).
inline uint32_t pcg(uint32_t state) {
    state = state * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

class SceneRandom {
  public:
    explicit SceneRandom(uint32_t seed) : state_(pcg(seed)) {}
    double in(double low, double high) {
        state_ = pcg(state_);
        return low + (high - low) * (state_ * 0x1p-32);
    }

  private:
    uint32_t state_;
};

// Value noise in -1..1 over a lattice of unit cells, smooth to the first derivative.
inline double value_noise(double x, double z, uint32_t seed) {
    const double x0 = std::floor(x), z0 = std::floor(z);
    const auto at = [&](double i, double j) {
        const auto u = static_cast<uint32_t>(static_cast<int32_t>(i)),
                   v = static_cast<uint32_t>(static_cast<int32_t>(j));
        return pcg(pcg(u + pcg(seed)) ^ v) * 0x1p-31 - 1;
    };
    const auto fade = [](double t) { return t * t * (3 - 2 * t); };
    const double tx = fade(x - x0), tz = fade(z - z0);
    const double low = at(x0, z0) + tx * (at(x0 + 1, z0) - at(x0, z0));
    const double high = at(x0, z0 + 1) + tx * (at(x0 + 1, z0 + 1) - at(x0, z0 + 1));
    return low + tz * (high - low);
}

// Octaves of half the size and `gain` times the height each.
inline double fractal_noise(double x, double z, int octaves, double gain, uint32_t seed) {
    double sum = 0, height = 1;
    for (int i = 0; i < octaves; ++i, height *= gain, x *= 2, z *= 2)
        sum += height * value_noise(x, z, seed + static_cast<uint32_t>(i));
    return sum;
}

}  // namespace penumbra
