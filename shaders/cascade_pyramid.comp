// SPDX-License-Identifier: MIT
// A node from its four children: the least of their depths, and of five planes (the children's slopes and a level one)
// the one that lies highest over the common centre while it stays below all of the children's bounds.
#include "node.glsl"
#include "common/cascade_node.glsl"

CascadeNode child(ivec3 at) {
    if (params.mip_level == 0u) return cascade_node(texelFetch(cascade_bounds, at, 0));
    return cascade_node(imageLoad(cascade_pyramid_finer, at));
}

float sum_abs(vec2 v) { return abs(v.x) + abs(v.y); }

void main() {
    const ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, imageSize(cascade_pyramid)))) return;
    const uint cascade = uint(at.z);
    const float child_m =
        cascade < cascades.count ? cascades.c[cascade].texel_m * float(1u << params.mip_level) : 0.0;

    CascadeNode children[4];
    float least = NO_SURFACE;
    for (int i = 0; i < 4; ++i) {
        children[i] = child(ivec3(2 * at.xy + ivec2(i & 1, i >> 1), at.z));
        least = min(least, children[i].least);
    }
    float level = least;
    vec2 slope = vec2(0.0);
    if (least < NO_SURFACE) {
        level = NOTHING_KNOWN;
        vec2 tried = vec2(0.0);
        for (int candidate = 0; candidate < 5; ++candidate) {
            const vec2 g = candidate < 4 && !is_empty(children[candidate & 3]) ? children[candidate & 3].slope : vec2(0.0);
            if (candidate > 0 && g == tried) continue;  // neighbours often share a plane
            tried = g;
            float lowest = NO_SURFACE;
            for (int i = 0; i < 4; ++i) {
                const CascadeNode c = children[i];
                const float rise = dot(g, child_m * (vec2(i & 1, i >> 1) - 0.5));
                const float from_plane = c.level - rise - 0.5 * child_m * sum_abs(c.slope - g);
                const float from_least = c.least - rise - 0.5 * child_m * sum_abs(g);
                if (!is_empty(c)) lowest = min(lowest, max(from_plane, from_least));
            }
            if (lowest > level) {
                level = lowest;
                slope = g;
            }
        }
    }
    imageStore(cascade_pyramid, at, vec4(least, level, slope));
}
