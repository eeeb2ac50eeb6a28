// SPDX-License-Identifier: MIT
// First phase of gather: cells with nothing but equal bits in reach, whose past has said nothing else, are what these say.
//
// Includer has working_cells.glsl, bit_rows.glsl, corners.glsl, shadow_state.glsl, sun_change.glsl and lit_or_sky(), and declares the images history and,
// where things move, motion, and the buffers idle_cells, idle_cells_prev and sunward_words.
#include "common/another_sun.glsl"
#include "common/cell_before.glsl"

// Have the rays of some pixel of a cell, all of which say `lit` now, said something else? Then there is a thin or faint
// penumbra, and one frame's agreement is no reason to forget it. One motion serves the whole cell: under a camera that moves
// hardly anything stays faint for long. Cells that were idle know without a look at their pixels.
// `known`: that past knows something of every pixel.
bool past_disagrees(ivec2 first, bool lit, out bool known) {
    known = false;
    const ivec2 last = ivec2(frame.prev_size) - 1;
    ivec2 there;
    if (is_another_sun() || !cell_before(first, there)) return false;
    bool idled = true;
    for (int i = 0; i < 4; ++i) {
        const ivec2 q = clamp(there + (CELL - 1) * corner(i), ivec2(0), last);
        const uint word = idle_word(idle_cells_prev[cell_index(q / CELL, frame.prev_size)]);
        idled = idled && idled_as(word, lit);
    }
    bool unlike = false;
    known = true;
    for (int i = 0; i < (idled ? 0 : CELL * CELL); ++i) {
        const uint word = imageLoad(history, clamp(there + in_cell(i), ivec2(0), last)).x;
        unlike = unlike || disagrees(word, lit);
        known = known && has_count(word);
    }
    return unlike;
}

// Whether anything that a workgroup's cells have in reach looks at the light. Of a light that is near most have nothing. Each subgroup asks for
// itself, so that none waits for another.
bool anything_looks() {
    const ivec2 around = ivec2(1, TILES_ABOVE), first = cell_of(0u) * CELL / TILE - around,
                across = cell_of(MOST_CELLS - 1u) * CELL / TILE + around - first + 1;
    uint words = 0u;
    for (int i = int(gl_SubgroupInvocationID); i < across.x * across.y; i += int(lanes_in_workgroup() / gl_NumSubgroups))
        words |= sunward_words[tile_index(clamp(first + ivec2(i % across.x, i / across.x), ivec2(0), tile_grid() - 1))];
    return subgroupOr(words) != 0u;
}

// Where nothing does: lit or not, nobody counts.
void settle_unasked_cells() {
    for (uint i = gl_LocalInvocationIndex; i < MOST_CELLS; i += lanes_in_workgroup()) {
        const ivec2 cell = cell_of(i);
        if (all(lessThan(cell, cell_grid()))) idle_cells[cell_index(cell)] = idle_word(pixels_of_cell(lit_or_sky(cell), cell));
    }
}

bool is_settled(ivec2 cell, bool below_last) {
    const ivec2 first = cell * CELL;
    if (below_last)
        load_rows_below(cell);
    else
        load_rows(cell);
    const uint said = said_within(R);
    bool works = has_both(said) || HAS_RAY_WORDS && said == 0u && sunward_words[tile_index(cell * CELL / TILE)] != 0u;
    bool known = false;
    for (int i = 0; i < (!works && said != 0u ? 1 : 0); ++i) works = past_disagrees(first, (said & 0xffffu) != 0u, known);
    if (HAS_RAY_BITS)
        for (int i = 0; i < (!works && said != 0u ? CELL * CELL : 0); ++i)
            works = works || further_disagree(further_at(first + in_cell(i)), (said & 0xffffu) != 0u);

    // Who has no ray is as the others are, and is known if it was before.
    const uint sunward = sunward_words[tile_index(cell * CELL / TILE)];
    uint counted = sunward;
    if (HAS_RAY_WORDS && !known) counted &= ray_words[tile_index(cell * CELL / TILE)];
    uint lit = lit_or_sky(cell);
    if (HAS_RAY_WORDS && said != 0u) lit = (said & 0xffffu) != 0u ? lit | sunward : lit & ~sunward;
    const uint idle = pixels_of_cell(lit, cell) | pixels_of_cell(counted, cell) << 16;
    idle_cells[cell_index(cell)] = idle_word(works ? NOT_IDLE : idle);
    return !works;
}
