// SPDX-License-Identifier: MIT
// How far off the surface, along its geometric normal, a shadow ray starts: by how far the reconstructed point may lie below
// the surface that the rasteriser saw. An error bound, not a constant, of three parts:
//
// - The grid, for a host whose depth the rasteriser interpolates (not the standalone host's, whose depth is of the pixel's very centre:
//   FRAME_DEPTH_AT_CENTRES). A rasteriser moves each corner of a triangle to
//   a grid of 2^-b pixels, b = subPixelPrecisionBits, by half a step s at most along either axis of the image, and keeps its depth. In
//   homogeneous coordinates depth is linear over the image, so what a pixel p within the moved triangle gets is sum w_i z_i with
//   p = sum w_i (c_i + e_i), w_i >= 0, sum w_i = 1, |e_i| <= s: the depth of the plane that was meant, at q = p - sum w_i e_i, no
//   farther from p than s along either axis (corners that clipping makes lie on the plane, and are moved alike). Reconstructed is
//   the point of p's view ray at q's depth; the surface has a point on q's ray there, so the two differ across the view axis alone,
//   by s pixels along either axis, and off the plane by s * span * (|n.right| + |n.up|) at most. Nothing where the surface faces the
//   camera; and no slope of a depth is in it, however large the triangle or grazing the view.
// - Rounding of reconstruction, shift to the scene's frame and the ray-triangle test. A bound of every step in turn would be some
//   20 ulps, of which no plane was ever seen to need more than 2: each is random. 3 leave a factor of two where it was worst
//   (tests/ray_start_test.cpp: planes of 1 m to 40 km, in triangles of 16 mm to 40 km). What this is worth: a point .5 mm beside a wall
//   419 m away starts on the right side of it; with 16 ulps it did not.
// - Rounding of the depth, interpolated and stored, moves the point along the view ray, of which the normal sees a part. How
//   exactly depth is interpolated Vulkan does not say; DEPTH_ROUNDINGS is what rasterisers were found to need, with room.
//
// And how much farther it starts along the way to the light. For the grid also decides whose pixel it is: a centre up to s past a
// triangle's edge shows that triangle's plane continued, s * span / |n.v| beyond its end. Where the next triangle rises that is below
// the ground, and a ray would find the ground from beneath: black pixels on sunlit terrain. Higher starts would move every
// oblique shadow; starts farther along the way move none, and overlook what stands nearer than that. (Who asks our own tree for a light
// does neither, but asks of every triangle so near whether the camera looks through it: common/looked_through.glsl.)
//
// Includer has common/camera.glsl.
const float ULPS = 3.0 * 1.1920929e-7;  // 2^-23
const float DEPTH_ROUNDINGS = 8.0;
const float MOST_GRAZING = 1.0 / 64.0;  // cosine; more grazing views see few pixels of anything

// Metres. `relative`: the point, camera-relative; `in_scene`: the same in the frame of the scene's triangles.
float robust_offset_m(ivec2 p, float z, vec3 n, vec3 relative, vec3 in_scene) {
    const vec3 largest = max(abs(relative), abs(in_scene));
    const float across = abs(dot(n, frame.world_from_view[0])) + abs(dot(n, frame.world_from_view[1]));
    return ULPS * (largest.x + largest.y + largest.z + z) +
           DEPTH_ROUNDINGS * depth_rounding_m(z) * abs(dot(n, to_viewer(p))) + frame.snap_px * across * pixel_span_m(z);
}

// No ray of a pixel at this depth, or nearer, starts farther from its point, whatever its normal.
float most_offset_m(float z, vec3 relative, vec3 in_scene) {
    const vec3 largest = max(abs(relative), abs(in_scene));
    return ULPS * (largest.x + largest.y + largest.z + z) + DEPTH_ROUNDINGS * depth_rounding_m(z) +
           (2.0 * frame.snap_px + frame.grid_px / MOST_GRAZING) * pixel_span_m(z);
}

// Metres along the surface that a pixel may show beyond the end of its triangle.
float beyond_edge_m(ivec2 p, float z, vec3 n) {
    return frame.grid_px * pixel_span_m(z) / max(abs(dot(n, to_viewer(p))), MOST_GRAZING);
}

// Of that, what a ray has to leave behind whose direction has this cosine with the normal: as much as lifts it over a neighbour that
// rises by 14 degrees, and not more than all of it. Where the axis of the light points into the surface it leads nowhere else.
float ahead_of_edge(float cosine) {
    const float RISE = 0.25;
    return cosine > 0.0 ? min(RISE / cosine, 1.0) : 0.0;
}
