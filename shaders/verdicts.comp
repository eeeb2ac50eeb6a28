// SPDX-License-Identifier: MIT
// A classifier's words as colours. Whatever classifier: they all leave these three words per tile. A pixel that is open
// is red whatever its hit bit says, since the bit is trace's to write.
#include "node.glsl"
#include "common/pixels.glsl"
#include "common/tiles.glsl"

void for_pixel(ivec2 p) {
    const uint i = tile_index(p / TILE), bit = pixel_bit(p);
    vec3 color;
    if ((receiver_words[i] & bit) == 0u) color = vec3(0.0);
    else if ((undecided_words[i] & bit) != 0u) color = vec3(1.0, 0.0, 0.0);
    else if ((preloaded_hits[i] & bit) != 0u) color = vec3(0.0, 0.0, 1.0);
    else color = vec3(0.0, 1.0, 0.0);
    imageStore(verdicts, p, vec4(color, 1.0));
}

void main() { for_each_pixel(); }
