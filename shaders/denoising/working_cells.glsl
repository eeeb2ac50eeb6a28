// SPDX-License-Identifier: MIT
// Cells of 4x4 pixels of which some have much to do and most have nothing. A workgroup settles all of its cells, lists those
// that are left, and only then works on them, side by side: invocations that run in step do not wait for one busy
// neighbour (at the edge of a shadow, a third of them would). The list has no order that matters: a cell's work is its own.
//
// Includer has shadow_state.glsl, defines the function, calls settle_cells() and then works on left_cells. An invocation
// settles PER_THREAD_X x PER_THREAD_Y pixels, a workgroup 32x32 (the node's `dispatch` and `classes`).

// Writes what there is to write, if it is. `below_last`: the cell above it came before.
bool is_settled(ivec2 cell, bool below_last);

const int CELLS_ACROSS = 8;  // of a workgroup
const uint MOST_CELLS = 64u;
shared uint left_count;
shared uint left_cells[MOST_CELLS];  // their numbers in the workgroup

// Pixel i of a cell, from its first one.
ivec2 in_cell(int i) { return ivec2(i & 3, i >> 2); }

ivec2 cell_of(uint number) {
    return CELLS_ACROSS * ivec2(gl_WorkGroupID.xy) + ivec2(number % uint(CELLS_ACROSS), number / uint(CELLS_ACROSS));
}
uint number_of(ivec2 cell) {
    const ivec2 local = cell & (CELLS_ACROSS - 1);
    return uint(local.x + CELLS_ACROSS * local.y);
}

uint lanes_in_workgroup() { return gl_WorkGroupSize.x * gl_WorkGroupSize.y; }

void settle_cells() {
    const ivec2 per_lane = ivec2(PER_THREAD_X, PER_THREAD_Y) / CELL;
    if (gl_LocalInvocationIndex == 0u) left_count = 0u;
    barrier();
    for (int y = 0; y < per_lane.y; ++y)
        for (int x = 0; x < per_lane.x; ++x) {
            const ivec2 cell = ivec2(gl_GlobalInvocationID.xy) * per_lane + ivec2(x, y);
            if (all(lessThan(cell, cell_grid())) && !is_settled(cell, y > 0 && per_lane.x == 1))
                left_cells[atomicAdd(left_count, 1u)] = number_of(cell);
        }
    barrier();
}
