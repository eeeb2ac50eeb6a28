// SPDX-License-Identifier: MIT
// The published search of the hybrid shadows sample (the classifier of AMD's FidelityFX, version 1.x; formulas as
// documented): Poisson taps of an ordinary shadow map in the disc that the sun's cone spans at the map's near plane. A
// tap that falls between two texels of a thin caster misses it, and the disc's radius is that of a caster at the near
// plane: it loses penumbrae and sends far more rays than it needs. Shipped as the baseline of every table. One departure:
// a pixel outside of all maps is undecided, where the sample answers "lit" or "shadowed" by accident.

const float PUBLISHED_BIAS = 0.002;         // of the depth range
const float PUBLISHED_NEAREST_HIT_M = 4e-2;

// Points of the unit disc by best candidates (Mitchell 1991): every prefix is well spread.
const vec2 POISSON[32] = vec2[](
    vec2(0.0000, 0.0000), vec2(-0.9272, -0.3745), vec2(0.7881, 0.6155), vec2(0.7919, -0.6099),
    vec2(-0.7764, 0.6280), vec2(-0.1340, -0.9894), vec2(0.0090, 0.9621), vec2(0.9826, 0.0025),
    vec2(-0.5655, 0.0944), vec2(0.2324, -0.5360), vec2(-0.3606, -0.4570), vec2(0.2692, 0.4934),
    vec2(-0.2478, 0.5109), vec2(0.4837, -0.1054), vec2(-0.9938, 0.0876), vec2(0.4601, 0.8827),
    vec2(-0.4121, 0.9098), vec2(-0.6857, -0.7149), vec2(0.2896, -0.9570), vec2(0.6575, 0.2529),
    vec2(-0.0440, -0.3506), vec2(0.7887, -0.2758), vec2(0.3138, 0.1704), vec2(-0.3170, -0.1175),
    vec2(-0.6289, -0.2477), vec2(-0.1218, -0.6680), vec2(-0.2449, 0.1965), vec2(-0.4016, -0.8435),
    vec2(0.5262, -0.4355), vec2(-0.5457, 0.4076), vec2(0.5359, -0.7609), vec2(0.0338, 0.3023));

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
    for (uint k = 0u; k < cascades.count; ++k) {
        const Cascade c = cascades.c[k];
        const vec3 at = in_cascade(c, relative);
        if (!inside && is_usable(c) && all(greaterThan(at.xy, vec2(0.0))) && all(lessThan(at.xy, vec2(1.0)))) {
            inside = true;
            found = search_published_in(c, int(k), at);
        }
    }
    return found;
}
