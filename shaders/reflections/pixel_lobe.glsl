// SPDX-License-Identifier: MIT
// The lobe of what a pixel shows.
//
// Includer has common/camera.glsl, common/receiver_normal.glsl and reflections/lobe.glsl and declares: image receiver_normal,
// material where HAS_MATERIAL.

float pixel_roughness(ivec2 p) { return HAS_MATERIAL ? texelFetch(material, p, 0).y : 1.0; }

Lobe pixel_lobe(ivec2 p, float roughness) {
    return make_lobe(decode_receiver_normal(imageLoad(receiver_normal, p).xy), to_viewer(p), roughness);
}
