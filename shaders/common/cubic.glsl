// SPDX-License-Identifier: MIT
// Weights of four neighbours at -1, 0, 1, 2 for a position t between 0 and 1: Catmull-Rom.
vec4 cubic_weights(float t) {
    return 0.5 * vec4(t * (-1.0 + t * (2.0 - t)), 2.0 + t * t * (3.0 * t - 5.0), t * (1.0 + t * (4.0 - 3.0 * t)),
                      t * t * (t - 1.0));
}
