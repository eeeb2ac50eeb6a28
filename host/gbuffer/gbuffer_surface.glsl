// SPDX-License-Identifier: MIT
// Depth, normal, motion and albedo of the nearest surface (conventions: host inputs of these names). Motion is
// formed from the interpolated *change* of the clip position: interpolation errors then scale with the motion, where
// a difference of two interpolated positions would keep those of the positions. Depth is that of the triangle's plane at the pixel's
// very centre: interpolated, it is that of a point up to half a step of the rasteriser's grid beside it, which is far more than
// rounding, and shadow rays would have to start that much off the surface (shaders/common/ray_offset.glsl). It is a colour: written as the
// fragment's depth, it would keep the device from testing depths before shading. MATERIALS: what reflections ask for besides (host
// inputs `material`, `emissive`).
#include "gbuffer.glsl"
#include "common/mask_texel.glsl"

layout(constant_id = 0) const bool ALPHA_TESTED = false;
layout(constant_id = 1) const bool TEXTURED = true;  // false: all of the material's textures are white

layout(set = 1, binding = 0) uniform sampler2D base_color_texture;
#ifdef MATERIALS
layout(set = 0, binding = 0) uniform Drawn { Draw draw; };
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D emissive_texture;
layout(location = 4) out vec2 out_material;  // metallic, perceptual roughness
layout(location = 5) out vec4 out_emissive;
#endif

layout(location = 0) in vec3 clip_change;
layout(location = 1) in vec2 texture_uv;
layout(location = 2) flat in vec3 normal;
layout(location = 3) in vec3 base_color;
layout(location = 4) flat in float plane_offset;
layout(location = 5) flat in uint hidden;

layout(location = 0) out float out_depth;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_motion;
layout(location = 3) out vec4 out_albedo;

// Where the point was behind the previous camera it had no place in the image: any uv outside it says so.
const vec2 off_screen = vec2(16.0);
const float largest_half = 65504.0;

// The same decision as a shadow ray's: of the full-size image, by its 8 bits.
bool is_hole() {
    const ivec2 texel = mask_texel(texture_uv, uvec2(textureSize(base_color_texture, 0)));
    return uint(texelFetch(base_color_texture, texel, 0).a * 255.0 + 0.5) < constants.least_alpha;
}

vec3 texel_of(sampler2D image) { return TEXTURED ? texture(image, texture_uv).rgb : vec3(1.0); }

// A plane that is seen from within has no depth there: the rasteriser's is taken.
float depth_of_plane(vec2 ndc) {
    const bool orthographic = constants.ray_0.w != 0.0;
    const vec3 there = constants.ray_0.xyz + ndc.x * constants.ray_x.xyz + ndc.y * constants.ray_y.xyz;
    const float z = orthographic ? (plane_offset - dot(normal, there)) / dot(normal, constants.ahead.xyz)
                                 : plane_offset / dot(normal, there);
    const float depth = (constants.ray_y.w + constants.ray_x.w * z) / (orthographic ? 1.0 : z);
    return z > 0.0 && depth > 0.0 && depth < 1.0 ? depth : gl_FragCoord.z;
}

void main() {
    const vec3 albedo = texel_of(base_color_texture) * base_color;  // while all neighbours are there
#ifdef MATERIALS
    out_material = texel_of(metallic_roughness_texture).bg * draw.metallic_roughness.xy;
    out_emissive = vec4(min(texel_of(emissive_texture) * draw.emissive.rgb, largest_half), 1.0);
#endif
    if (hidden != 0u || ALPHA_TESTED && is_hole()) discard;
    const vec2 ndc = gl_FragCoord.xy * constants.ndc_per_pixel - 1.0 - constants.jitter_ndc;
    out_depth = depth_of_plane(ndc);
    const float prev_w = 1.0 / gl_FragCoord.w + clip_change.z;
    // (c + dc) / (w + dw) - c / w with c / w = ndc.
    const vec2 motion = prev_w > 0.0 ? 0.5 * (clip_change.xy - ndc * clip_change.z) / prev_w : off_screen;
    out_normal = vec4(normal, 0.0);
    out_motion = vec4(clamp(vec3(motion, clip_change.z), -largest_half, largest_half), 0.0);
    out_albedo = vec4(albedo, 1.0);
}
