// SPDX-License-Identifier: MIT
// What a pixel shows, and whether another shows the same surface with much the same lobe.
//
// Includer has common/camera.glsl, common/receiver_normal.glsl, common/rounded.glsl and common/pixels.glsl and declares: image surface;
// constant LOBE.
#include "common/surface_texel.glsl"
#include "common/view_rays.glsl"

struct Shown {
    vec3 x, n;   // camera-relative
    float z, roughness;
};

uvec2 surface_texel(ivec2 p) { return inside_frame(p) ? imageLoad(surface, p).xy : uvec2(0u); }

// Sky has z 0.
Shown shown(ivec2 p) {
    const uvec2 texel = surface_texel(p);
    const float z = surface_depth(texel);
    return Shown(position(p, z), surface_normal(texel), z, LOBE == LOBE_DIFFUSE ? 1.0 : surface_roughness(texel));
}

// Of the pixel so far away from the one that `rays` are around.
Shown shown(ivec2 q, ViewRays rays, ivec2 offset) {
    const uvec2 texel = surface_texel(q);
    const float z = surface_depth(texel);
    return Shown(seen_at(rays, vec2(offset), z), surface_normal(texel), z, LOBE == LOBE_DIFFUSE ? 1.0 : surface_roughness(texel));
}

const float ON_PLANE = 0.01;  // of the depth

bool on_plane(Shown here, Shown there) { return abs(dot(here.n, there.x - here.x)) < ON_PLANE * here.z; }

bool alike(float roughness, float other) { return abs(roughness - other) <= 0.03 + 0.1 * roughness; }

bool same_surface(Shown here, Shown there) {
    return there.z > 0.0 && dot(here.n, there.n) > 0.9 && on_plane(here, there) && alike(here.roughness, there.roughness);
}

// The same of texels. No root is taken of a normal's length.
bool near_normal(Shown here, uvec2 there) {
    const vec3 n = surface_normal_unscaled(there);
    const float cosine = dot(here.n, n);
    return cosine > 0.0 && cosine * cosine > 0.81 * dot(n, n);
}

bool like_lobe(Shown here, uvec2 there) {
    return near_normal(here, there) && (LOBE == LOBE_DIFFUSE || alike(here.roughness, surface_roughness(there)));
}
