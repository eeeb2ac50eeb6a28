// SPDX-License-Identifier: MIT
// What a pixel shows, and whether another shows the same surface with much the same lobe.
//
// Includer has common/camera.glsl, common/receiver_normal.glsl, common/rounded.glsl and common/pixels.glsl and declares: image surface;
// constant LOBE.
#include "common/surface_texel.glsl"

struct Shown {
    vec3 x, n;   // camera-relative
    float z, roughness;
};

// Sky has z 0.
Shown shown(ivec2 p) {
    if (!inside_frame(p)) return Shown(vec3(0.0), vec3(0.0), 0.0, 1.0);
    const uvec2 texel = imageLoad(surface, p).xy;
    const float z = surface_depth(texel);
    return Shown(position(p, z), surface_normal(texel), z, LOBE == LOBE_DIFFUSE ? 1.0 : surface_roughness(texel));
}

bool on_plane(Shown here, Shown there) { return abs(dot(here.n, there.x - here.x)) < 0.01 * here.z; }

bool alike(float roughness, float other) { return abs(roughness - other) <= 0.03 + 0.1 * roughness; }

bool same_surface(Shown here, Shown there) {
    return there.z > 0.0 && dot(here.n, there.n) > 0.9 && on_plane(here, there) && alike(here.roughness, there.roughness);
}
