// SPDX-License-Identifier: MIT
// What a triangle looks like where a ray hits it: the layout of host/materials/hit_surfaces.h.
//
// Includer declares: uniform usamplerBuffer surfaces, surface_texels.

struct HitSurface {
    vec3 point, normal;  // in the scene's frame; the normal faces where the ray came from
    vec3 base_color, emissive;
    bool moves;
};

// IEC 61966-2-1.
vec3 srgb_to_linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045))); }

// `place`: first word, width - 1 | height - 1 << 16; repeated beyond its edges, whatever the file's samplers say.
vec3 hit_texture(uvec2 place, vec2 uv) {
    if (place.x == ~0u) return vec3(1.0);
    const uvec2 size = uvec2(place.y & 0xffffu, place.y >> 16) + 1u;
    const uvec2 at = min(uvec2(fract(uv) * vec2(size)), size - 1u);
    const uint word = texelFetch(surface_texels, int(place.x + at.y * size.x + at.x)).x;
    return srgb_to_linear(unpackUnorm4x8(word).rgb);
}

// Where the ray meets the triangle's plane; its corners' weights by areas, so that a point beside it has some too.
HitSurface hit_surface(uint triangle, vec3 point, vec3 direction) {
    const int texel = int(1u + 4u * triangle);
    const uvec4 t0 = texelFetch(surfaces, texel), t1 = texelFetch(surfaces, texel + 1), t2 = texelFetch(surfaces, texel + 2),
                t3 = texelFetch(surfaces, texel + 3);
    const vec3 a = uintBitsToFloat(t0.xyz), b = uintBitsToFloat(uvec3(t0.w, t1.xy)), c = uintBitsToFloat(uvec3(t1.zw, t2.x));
    const vec3 ab = b - a, ac = c - a, n = cross(ab, ac);
    const float area2 = max(dot(n, n), 1e-37);
    const float weight_b = dot(cross(point - a, ac), n) / area2, weight_c = dot(cross(ab, point - a), n) / area2;
    const vec2 uv = (1.0 - weight_b - weight_c) * uintBitsToFloat(t2.yz) + weight_b * uintBitsToFloat(uvec2(t2.w, t3.x)) +
                    weight_c * uintBitsToFloat(t3.yz);
    const int material = int(texelFetch(surfaces, 0).z + 3u * (t3.w & 0x7fffffffu));
    const uvec4 base = texelFetch(surfaces, material), emissive = texelFetch(surfaces, material + 1),
                textures = texelFetch(surfaces, material + 2);
    const vec3 facing = n * inversesqrt(area2) * (dot(n, direction) > 0.0 ? -1.0 : 1.0);
    return HitSurface(point, facing, uintBitsToFloat(base.xyz) * hit_texture(textures.xy, uv),
                      uintBitsToFloat(emissive.xyz) * hit_texture(textures.zw, uv), t3.w >> 31 != 0u);
}
