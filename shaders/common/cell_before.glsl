// SPDX-License-Identifier: MIT
// Where the previous frame showed a cell, whose first pixel is `first`: one motion serves all of it. False: it did not.
//
// Includer has camera.glsl and shadow_state.glsl and declares, where things move, the image motion.
bool cell_before(ivec2 first, out ivec2 there) {
    there = first;
    if ((frame.flags & FRAME_RESET) != 0u || !HAS_MOTION && !pixels_have_pasts()) return false;
    if (HAS_MOTION) {
        const ivec2 middle = min(first + CELL / 2, ivec2(frame.size) - 1);
        const Reprojection before = reproject(middle, texelFetch(motion, middle, 0).xy);
        if (!before.on_screen) return false;
        there += ivec2(floor(before.uv * vec2(frame.prev_size))) - middle;
    }
    return true;
}
