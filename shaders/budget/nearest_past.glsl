// SPDX-License-Identifier: MIT
// What the previous frame knew of the surface that a pixel shows, by the nearest texel: enough to allot rays by, not to shade by.
//
// Includer has nearest_place.glsl and shadow_state.glsl and declares the image history and, of several lights that have it in common, nearest_places.

const float SURE_BELOW = 0.01;       // of 0 or of 1: no penumbra

struct PixelPast {
    bool known;       // else the other members mean nothing
    float visibility, count, residual;
    bool resampled;   // lay between texels
    bool beside_step; // and a texel around showed something above the surface, whose foot the point may be at
};

// `before`: previous_rays(), where things move.
PixelPast nearest_past(ivec2 p, ViewRays before) {
    NearestPlace place;
    if (HAS_NEAREST_PLACES)
        place = unpack_place(p, imageLoad(nearest_places, p).x);
    else
        place = nearest_place(p, before);
    const uint word = imageLoad(history, clamp(place.texel, ivec2(0), ivec2(frame.prev_size) - 1)).x;  // p may lie beside the frame
    return PixelPast(place.known && has_count(word), visibility_in(word), count_in(word), residual_in(word), place.resampled, place.beside_step);
}
