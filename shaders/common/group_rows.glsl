// SPDX-License-Identifier: MIT
// A dispatch over a list, one workgroup per entry, is in rows: many devices limit it to 65 535 groups per axis.
#ifndef GROUP_ROWS_GLSL
#define GROUP_ROWS_GLSL

const uint GROUPS_PER_ROW = 32768u;

// Of a list of so many entries: the dispatch's groups along x and y.
uvec2 groups_in_rows(uint entries) { return uvec2(min(entries, GROUPS_PER_ROW), (entries + GROUPS_PER_ROW - 1u) / GROUPS_PER_ROW); }

// The entry of this workgroup; the last row has groups beyond the list's end.
uint entry_of_group() { return gl_WorkGroupID.y * GROUPS_PER_ROW + gl_WorkGroupID.x; }
#endif
