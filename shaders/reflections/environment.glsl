// SPDX-License-Identifier: MIT
// Radiance from beyond the scene (host/materials/environment.h), bilinear: across the seam, and across a pole to the other side.
//
// Includer declares: uniform sampler2D environment, where HAS_ENVIRONMENT.

vec3 environment_texel(ivec2 at, ivec2 size) {
    const bool beyond = at.y < 0 || at.y >= size.y;
    const int y = at.y < 0 ? -1 - at.y : at.y >= size.y ? 2 * size.y - 1 - at.y : at.y;
    const int x = at.x + (beyond ? size.x / 2 : 0) + size.x;
    return texelFetch(environment, ivec2(x % size.x, y), 0).rgb;
}

// Where a direction, a unit vector, lies in it: 0 to 1 across and down. A pole has no longitude, and atan is undefined there.
vec2 environment_place(vec3 direction) {
    const bool pole = direction.x == 0.0 && direction.z == 0.0;
    const float longitude = pole ? 0.0 : atan(direction.z, direction.x) * 0.15915494309189535;
    return vec2(longitude - floor(longitude), acos(clamp(direction.y, -1.0, 1.0)) * 0.3183098861837907);
}

vec3 environment_radiance(vec3 direction) {
    if (!HAS_ENVIRONMENT) return vec3(0.0);
    const ivec2 size = textureSize(environment, 0);
    const vec2 at = environment_place(direction) * vec2(size) - 0.5;
    const vec2 first = floor(at), within = at - first;
    const ivec2 i = ivec2(first);
    return mix(mix(environment_texel(i, size), environment_texel(i + ivec2(1, 0), size), within.x),
               mix(environment_texel(i + ivec2(0, 1), size), environment_texel(i + ivec2(1, 1), size), within.x), within.y);
}
