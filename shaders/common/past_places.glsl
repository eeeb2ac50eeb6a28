// SPDX-License-Identifier: MIT
// Where the previous frame may have seen what arrives here: at the surface's own point, or, mirrored, at the image of what it
// reflects, along the view ray and as far behind the surface as the reflected thing lies before it. Normals are geometric, so
// a surface is a plane mirror as far as they know.
//
// Includer has common/camera.glsl and declares: image motion, where HAS_MOTION.

vec2 surface_motion(ivec2 p) { return HAS_MOTION ? texelFetch(motion, p, 0).xy : vec2(0.0); }

// uv; outside of 0..1 where there is none.
vec2 past_of_surface(ivec2 p) {
    const Reprojection past = reproject(p, surface_motion(p));
    return past.on_screen ? past.uv : vec2(-1.0);
}

// The view depths that the surface at x, z before the camera, may have had: of one that stood still, and of one that came nearer as
// the motion's third component says. A host that has none gives 0 there, which is also right of what travels along with the camera.
vec2 past_depths(ivec2 p, float z, vec3 x) { return vec2(previous_depth(x), z + (HAS_MOTION ? texelFetch(motion, p, 0).z : 0.0)); }

// Of the image of what a surface at `x` reflects from a distance.
vec2 past_of_image(vec3 x, float distance_m) {
    const vec3 image = (frame.flags & FRAME_ORTHOGRAPHIC) != 0u ? x - distance_m * frame.world_from_view[2]
                                                                : x * (1.0 + distance_m / max(length(x), 1e-6));
    const vec4 there = frame.prev_clip_from_rel * vec4(image, 1.0);
    if (!(there.w > 0.0)) return vec2(-1.0);
    return 0.5 + 0.5 * there.xy / there.w;
}

// Of the pixel's middle, as its surface's past: what is kept of a pixel is that of all its jittered points.
vec2 past_of_image(ivec2 p, float z, float distance_m) { return past_of_image(position_at(pixel_uv(p), z), distance_m); }
