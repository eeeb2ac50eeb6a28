// SPDX-License-Identifier: MIT
// The published search of the hybrid shadows sample (the classifier of AMD's FidelityFX, version 1.x; formulas as
// documented): Poisson taps of an ordinary shadow map in the disc that the sun's cone spans at the map's near plane. A
// tap that falls between two texels of a thin caster misses it, and the disc's radius is that of a caster at the near
// plane: it loses penumbrae and sends far more rays than it needs. Shipped as the baseline of every table. One departure:
// a pixel outside of all maps is undecided, where the sample answers "lit" or "shadowed" by accident.

const float PUBLISHED_BIAS = 0.002;         // of the depth range
const float PUBLISHED_NEAREST_HIT_M = 4e-2;

const uint LIT = 0u, SHADOWED = 1u, UNDECIDED = 2u;

struct Found {
    uint answer;
    float nearest_m, farthest_m;  // where the ray may meet something
};

Found search_published_in(Cascade c, int layer, vec3 at) {
    const ivec2 size = textureSize(cascade_maps, 0).xy;
    const float radius = tan(sun.angular_radius) * at.z * c.depth_m / c.texel_m + 1.0;
    const float limit = at.z - PUBLISHED_BIAS;
    float nearest = 1.0, farthest = 0.0, closest_blocker = 0.0;
    for (uint i = 0u; i < TAPS; ++i) {
        const ivec2 texel = ivec2(floor(at.xy * vec2(size) + POISSON[i] * radius + 0.5));
        if (all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, size))) {
            const float d = texelFetch(cascade_maps, ivec3(texel, layer), 0).x;
            nearest = min(nearest, d);
            farthest = max(farthest, d);
            if (d < limit) closest_blocker = max(closest_blocker, d);
        }
    }
    const uint answer = farthest <= limit ? SHADOWED : nearest >= limit ? LIT : UNDECIDED;
    const float from_m = max(at.z - closest_blocker - PUBLISHED_BIAS, 0.0) * c.depth_m;
    const float to_m = abs(at.z - nearest + PUBLISHED_BIAS) * c.depth_m;
    return Found(answer, max(from_m, PUBLISHED_NEAREST_HIT_M), to_m);
}

Found search_published(ivec2 p, float z) {
    // The sample's pixel lies at p / size, half a pixel off.
    const vec3 relative = position_at(vec2(p) / vec2(frame.size) - frame.jitter, z);
    Found found = Found(UNDECIDED, 0.0, WHOLE_RAY_M);
    bool inside = false;
    for (uint k = 0u; k < cascade_count(textureSize(cascade_maps, 0).z); ++k) {
        const Cascade c = cascades.c[k];
        const vec3 at = in_cascade(c, relative);
        if (!inside && is_usable(c) && all(greaterThan(at.xy, vec2(0.0))) && all(lessThan(at.xy, vec2(1.0)))) {
            inside = true;
            found = search_published_in(c, int(k), at);
        }
    }
    return found;
}
