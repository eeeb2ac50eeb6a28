// SPDX-License-Identifier: MIT
// What a pixel shows, and whether another shows the same surface with much the same lobe.
//
// Includer has common/camera.glsl, common/receiver_normal.glsl and common/pixels.glsl and declares: images view_depth, octahedral_normal;
// material where HAS_MATERIAL.

struct Shown {
    vec3 x, n;   // camera-relative
    float z, roughness;
};

// Sky has z 0.
Shown shown(ivec2 p) {
    if (!inside_frame(p)) return Shown(vec3(0.0), vec3(0.0), 0.0, 1.0);
    const float z = imageLoad(view_depth, p).x;
    return Shown(position(p, z), unpack_direction(imageLoad(octahedral_normal, p).x), z,
                 HAS_MATERIAL ? texelFetch(material, p, 0).y : 1.0);
}

bool on_plane(Shown here, Shown there) { return abs(dot(here.n, there.x - here.x)) < 0.01 * here.z; }

bool alike(float roughness, float other) { return abs(roughness - other) <= 0.03 + 0.1 * roughness; }

bool same_surface(Shown here, Shown there) {
    return there.z > 0.0 && dot(here.n, there.n) > 0.9 && on_plane(here, there) && alike(here.roughness, there.roughness);
}
