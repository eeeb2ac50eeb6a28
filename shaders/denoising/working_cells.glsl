// SPDX-License-Identifier: MIT
// Cells of 4x4 pixels of which some have much to do and most have nothing. A workgroup settles all of its cells, lists those
// that are left, and only then works on them, side by side: invocations that run in step do not wait for one busy
// neighbour (at the edge of a shadow, a third of them would). The list has no order that matters: a cell's work is its own.
//
// Includer has shadow_state.glsl, defines the function, calls settle_cells() and then works on left_cells. How many cells a
// workgroup has is the node's: `dispatch` and `classes` cover whole ones, in powers of two. A GPU's are few, so that a shadow's
// edge keeps many workgroups busy.

// Writes what there is to write, if it is. `below_last`: this invocation has just had the cell above it.
bool is_settled(ivec2 cell, bool below_last);

const uint CELLS_ACROSS = GROUP_X * PER_THREAD_X / uint(CELL), CELLS_DOWN = GROUP_Y * PER_THREAD_Y / uint(CELL);
const uint MOST_CELLS = CELLS_ACROSS * CELLS_DOWN;  // of a workgroup
shared uint left_count;
shared uint left_cells[MOST_CELLS];  // their numbers in the workgroup

// Pixel i of a cell, from its first one.
ivec2 in_cell(int i) { return ivec2(i & 3, i >> 2); }

ivec2 cell_of(uint number) {
    return ivec2(gl_WorkGroupID.xy * uvec2(CELLS_ACROSS, CELLS_DOWN) + uvec2(number % CELLS_ACROSS, number / CELLS_ACROSS));
}

uint lanes_in_workgroup() { return gl_WorkGroupSize.x * gl_WorkGroupSize.y; }

void settle_cells() {
    const uint lane = gl_LocalInvocationIndex, lanes = lanes_in_workgroup();
    if (lane == 0u) left_count = 0u;
    group_barrier();
    for (uint i = lane; i < MOST_CELLS; i += lanes) {
        const ivec2 cell = cell_of(i);
        if (all(lessThan(cell, cell_grid())) && !is_settled(cell, i != lane && lanes == CELLS_ACROSS))
            left_cells[atomicAdd(left_count, 1u)] = i;
    }
    group_barrier();
}
