// SPDX-License-Identifier: MIT
// A node from its four children: the least of their depths, and of five planes (the children's slopes and a level one)
// the one that lies highest over the common centre while it stays below all of the children's bounds. A chain whose
// cascade still has the revision that it was made from is kept.
#include "node.glsl"
#include "common/cascade_node.glsl"

CascadeNode child(ivec3 at) {
    if (params.mip_level == 0u) return cascade_node(texelFetch(cascade_bounds, at, 0));
    return cascade_node(imageLoad(cascade_pyramid_finer, at));
}

float sum_abs(vec2 v) { return abs(v.x) + abs(v.y); }

void make_node(ivec3 at) {
    const float child_m = cascades.c[at.z].texel_m * float(1u << params.mip_level);
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

// A layer beyond the cascades is read by nobody. The last level has one node, whose invocation notes what the chain was
// made from: all other levels have looked by then.
void main() {
    const ivec3 size = imageSize(cascade_pyramid);
    const ivec3 first = ivec3(gl_GlobalInvocationID * uvec3(PER_THREAD_X, PER_THREAD_Y, 1));
    if (first.z >= size.z || uint(first.z) >= min(cascades.count, 4u)) return;
    const uint revision = cascades.c[first.z].revision;
    if (revision != 0u && revision == pyramid_revisions[first.z]) return;
    const ivec2 end = min(first.xy + ivec2(PER_THREAD_X, PER_THREAD_Y), size.xy);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) make_node(ivec3(x, y, first.z));
    count_made(uint(max(end.x - first.x, 0) * max(end.y - first.y, 0)));
    if (size.x == 1 && size.y == 1 && first.x == 0 && first.y == 0) pyramid_revisions[first.z] = revision;
}
