// SPDX-License-Identifier: MIT
// Of several lights, how much the shadow of each matters where it is: by the share s that it gives of what all of them would shine there
// unshadowed. An error of its mask is one of s in the picture: further rays gain s^2 of what they gain under a light that is alone, and
// first rays, of which the error falls about as their number rises, are best cast in proportion to s.
//
// Includer has rounded.glsl and ray_worth.glsl.

// The share is kept as s^2 is in the histogram of gains: in so many of its steps below 1.
const float LEAST_SHARE_OF_LIGHT = 0.0009765625;
const uint STEPS_PER_CLASS = 24u;  // an octave of s

// Pixels are counted by it.
const uint SHARE_CLASSES = 10u;
const uint PROVED_PIXELS = 3u * SHARE_CLASSES;  // behind the counts of each class: pixels that need no ray

uint steps_of_share(float lux, float lux_of_all) {
    if (!(lux_of_all > 0.0)) return 0u;  // where nothing shines nobody is brighter than another
    return rounded(-2.0 * log2(clamp(lux / lux_of_all, LEAST_SHARE_OF_LIGHT, 1.0)) * GAIN_STEPS);
}

uint share_class(uint steps) { return min(steps / STEPS_PER_CLASS, SHARE_CLASSES - 1u); }

// Where `pooled` has the sums over several lights: their pixel_counts, first rays and gains.
const uint POOLED_FIRST_RAYS = 3u * SHARE_CLASSES, POOLED_GAINS = POOLED_FIRST_RAYS + 1u;
