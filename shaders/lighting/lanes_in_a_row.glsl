// SPDX-License-Identifier: MIT
// A software device's lanes stand side by side in a row of pixels and go down the image together. Each loads its own pixel and asks
// the lanes beside it for theirs: a shuffle is one instruction, a load a call. The two pixels beside the row are nobody's own; they
// are loaded for as many rows at once as there are pairs of lanes.
//
// Includer has the extension GL_KHR_shader_subgroup_shuffle, and is compiled by class. Where IN_A_ROW, a
// workgroup is one row of whole subgroups of two lanes or more, and all of them take part in every shuffle.
const bool IN_A_ROW = CLASS_CPU == 1;

int row_lane() { return int(gl_SubgroupInvocationID); }
int row_lanes() { return int(gl_SubgroupSize); }

// The column of an invocation; those of a subgroup are neighbours.
int column() {
    return int(IN_A_ROW ? gl_WorkGroupID.x * GROUP_X + gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID
                        : gl_GlobalInvocationID.x);
}

// Rows are counted from where the invocations start. In which of them a lane loads the pixel beside the row that is beside_row(), of this
// row and the next ones.
bool sides_are_due(int row) { return (row & row_lanes() / 2 - 1) == 0; }
ivec2 beside_row(int x, int y) {
    return ivec2(x - row_lane() + ((row_lane() & 1) == 0 ? -1 : row_lanes()), y + (row_lane() >> 1));
}
uint side_lane(int row) { return 2u * uint(row & row_lanes() / 2 - 1); }

float left_of(float own, float sides, int row) {
    const float side = subgroupShuffle(sides, side_lane(row)), neighbour = subgroupShuffle(own, uint(max(row_lane() - 1, 0)));
    return row_lane() == 0 ? side : neighbour;
}
float right_of(float own, float sides, int row) {
    const int last = row_lanes() - 1;
    const float side = subgroupShuffle(sides, side_lane(row) + 1u), neighbour = subgroupShuffle(own, uint(min(row_lane() + 1, last)));
    return row_lane() == last ? side : neighbour;
}
vec3 left_of(vec3 own, vec3 sides, int row) {
    return vec3(left_of(own.x, sides.x, row), left_of(own.y, sides.y, row), left_of(own.z, sides.z, row));
}
vec3 right_of(vec3 own, vec3 sides, int row) {
    return vec3(right_of(own.x, sides.x, row), right_of(own.y, sides.y, row), right_of(own.z, sides.z, row));
}
