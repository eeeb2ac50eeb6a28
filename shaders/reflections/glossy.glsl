// SPDX-License-Identifier: MIT
// Published form: its roughness is the square of the perceptual one, kept in 8 bits.
//
// Includer declares: constant or param roughness_threshold.
float published_roughness(float perceptual) { return perceptual * perceptual; }
bool is_glossy(float roughness) { return roughness < params.roughness_threshold; }
bool is_mirror_like(float roughness) { return roughness < 1e-4; }
