// SPDX-License-Identifier: MIT
// Cells of 4x4 pixels of which some have much to do and most have nothing. A workgroup settles all of its cells, lists those
// that are left, and only then works on them, side by side: invocations that run in step do not wait for one busy
// neighbour (at the edge of a shadow, a third of them would). The list has no order that matters: a cell's work is its own.
//
// Includer has shadow_state.glsl, defines the two functions and calls for_each_cell(). An invocation settles
// PER_THREAD_X x PER_THREAD_Y pixels.

bool is_settled(ivec2 cell);  // writes what there is to write, if it is
void work_on(ivec2 cell);

const uint MOST_CELLS = 64u;  // of a workgroup: 32x32 pixels
shared uint left_count;
shared uint left_cells[MOST_CELLS];  // x + 65536 y

void for_each_cell() {
    const ivec2 per_lane = ivec2(PER_THREAD_X, PER_THREAD_Y) / CELL;
    if (gl_LocalInvocationIndex == 0u) left_count = 0u;
    barrier();
    for (int y = 0; y < per_lane.y; ++y)
        for (int x = 0; x < per_lane.x; ++x) {
            const ivec2 cell = ivec2(gl_GlobalInvocationID.xy) * per_lane + ivec2(x, y);
            if (all(lessThan(cell, cell_grid())) && !is_settled(cell))
                left_cells[atomicAdd(left_count, 1u)] = uint(cell.x) | uint(cell.y) << 16;
        }
    barrier();
    const uint lanes = gl_WorkGroupSize.x * gl_WorkGroupSize.y, n = left_count;
    for (uint i = gl_LocalInvocationIndex; i < n; i += lanes) {
        const uint cell = left_cells[i];
        work_on(ivec2(cell & 0xffffu, cell >> 16));
    }
}
