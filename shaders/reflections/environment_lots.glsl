// SPDX-License-Identifier: MIT
// Directions towards what is bright of the environment, and their density per steradian (host/materials/environment_lots.h).
//
// Includer has common/hash.glsl and reflections/environment.glsl and declares: uniform usamplerBuffer environment_lots.

// `direction` is a unit vector.
float lot_density(vec3 direction) {
    const uvec2 size = texelFetch(environment_lots, 0).xy;
    const uvec2 at = min(uvec2(environment_place(direction) * vec2(size)), size - 1u);
    return uintBitsToFloat(texelFetch(environment_lots, int(1u + at.y * size.x + at.x)).z);
}

// Evenly within a texel that is drawn by its lot. `number`: any hash.
vec3 draw_lot(uint number) {
    const uvec2 size = texelFetch(environment_lots, 0).xy;
    uint texel, unused;
    umulExtended(number, size.x * size.y, texel, unused);
    const uint a = noise_hash(number), b = noise_hash(a), c = noise_hash(b);
    const uvec4 lot = texelFetch(environment_lots, int(1u + texel));
    if (!(noise_unit(uvec2(a)).x < uintBitsToFloat(lot.x))) texel = lot.y;
    const vec2 within = noise_unit(uvec2(b, c));
    const float row = 3.141592653589793 / float(size.y), y = float(texel / size.x);
    const float height = mix(cos(y * row), cos((y + 1.0) * row), within.y), across = sqrt(max(1.0 - height * height, 0.0));
    const float longitude = 6.283185307179586 * (float(texel % size.x) + within.x) / float(size.x);
    return vec3(across * cos(longitude), height, across * sin(longitude));
}
