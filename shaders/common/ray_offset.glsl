// SPDX-License-Identifier: MIT
// How far off the surface, along its geometric normal, a shadow ray starts: by how far the reconstructed point may lie below
// the surface that the rasteriser saw. An error bound, not a constant:
// - float rounding of reconstruction, shift to the scene's frame and the ray-triangle test: each is an ulp or two of the
//   largest number involved, 16 bound the sum;
// - rounding of the depth, interpolated and stored, moves the point along the view ray, of which the normal sees a part;
// - rasterisers snap vertices to a grid of 1/256 pixel: a pixel shows the surface at a place up to half of that beside it
//   on either axis of the image, of which the normal sees a part: nothing where it faces the camera.
//
// Includer has common/camera.glsl.
const float ULPS = 16.0 * 1.1920929e-7;  // 2^-23
const float DEPTH_ROUNDINGS = 8.0;
const float SNAP_PX = 0.5 / 256.0;

// Metres. `relative`: the point, camera-relative; `in_scene`: the same in the frame of the scene's triangles.
float robust_offset_m(ivec2 p, float z, vec3 n, vec3 relative, vec3 in_scene) {
    const vec3 largest = max(abs(relative), abs(in_scene));
    const float across = abs(dot(n, frame.world_from_view[0])) + abs(dot(n, frame.world_from_view[1]));
    return ULPS * (largest.x + largest.y + largest.z + z) +
           DEPTH_ROUNDINGS * depth_rounding_m(z) * abs(dot(n, to_viewer(p))) + SNAP_PX * across * pixel_span_m(z);
}
