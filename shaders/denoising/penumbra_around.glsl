// SPDX-License-Identifier: MIT
// The penumbra that the blockers around a cell of pixels make: those of 4x4 blocks of 8x8 pixels, weighted by how near they are. Where
// nobody has measured them it is as the parameter distance_m says, or narrower than a pixel: to take it for wider
// than it is blurs details, and how much the bits vary does not tell noise from leaves.
//
// Includer has tiles.glsl, shadow_state.glsl and this_frame.glsl, and declares the block sun and, perhaps, the image block_blockers.

Penumbra penumbra_by_blockers(ivec2 cell) {
    const vec2 centre = (vec2(cell * CELL) + 0.5 * float(CELL)) / vec2(BLOCK);
    const ivec2 first = ivec2(floor(centre - 0.5)) - 1, grid = block_grid();
    vec3 sums = vec3(0.0);  // hits, log2 of the distance, its square
    for (int y = 0; y < 4; ++y) {
        const int row = first.y + y;
        const float from_y = max(2.0 - abs(float(row) + 0.5 - centre.y), 0.0);
        const float by_y = row >= 0 && row < grid.y ? from_y * from_y : 0.0;
        vec3 sum = vec3(0.0);
        [[unroll]] for (int x = 0; x < 4; ++x) {
            const int column = first.x + x;
            const float from_x = max(2.0 - abs(float(column) + 0.5 - centre.x), 0.0);
            const float by_x = column >= 0 && column < grid.x ? from_x * from_x : 0.0;
            sum += by_x * imageLoad(block_blockers, clamp(ivec2(column, row), ivec2(0), grid - 1)).xyz;
        }
        sums += by_y * sum;
    }
    if (sums.x <= 0.0) return Penumbra(0.0, 0.0, 0.0);
    const float octaves = sums.y / sums.x;
    const float deviation = sqrt(max(sums.z / sums.x - octaves * octaves, 0.0));
    return Penumbra(exp2(octaves), HAS_LIGHT ? 1.0 : tan(sun.angular_radius), 0.6931472 * deviation);
}

const float NARROW_PENUMBRA_PX = 0.3;  // radius

Penumbra penumbra_at(ivec2 cell, Footprint foot) {
    if (HAS_BLOCK_BLOCKERS) return penumbra_by_blockers(cell);
    const float tangent = HAS_LIGHT ? 1.0 : tan(sun.angular_radius), narrow_m = NARROW_PENUMBRA_PX * sqrt(foot.s.s1 * foot.s.s2);
    if (tangent <= 0.0) return Penumbra(0.0, 0.0, 0.0);
    return Penumbra(params.distance_m > 0.0 ? params.distance_m : narrow_m / tangent, tangent, 0.0);
}
