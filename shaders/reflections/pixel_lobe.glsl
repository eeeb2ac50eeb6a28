// SPDX-License-Identifier: MIT
// The lobe of what a pixel shows.
//
// Includer has common/camera.glsl and reflections/lobe.glsl and declares: image material where HAS_MATERIAL.

float pixel_roughness(ivec2 p) { return HAS_MATERIAL ? texelFetch(material, p, 0).y : 1.0; }

Lobe pixel_lobe(ivec2 p, vec3 n, float roughness) { return make_lobe(n, to_viewer(p), roughness); }
