// SPDX-License-Identifier: MIT
// Counts texels by the worst that any of their channels is: not a number, else infinite, else out of range. Groups take
// turns at the rows of everything that the port holds, so one dispatch suits every size, layer and level.
#include "node.glsl"

const uint EXPONENT = 0x7f800000u;  // of an infinity; a NaN's bits are greater
const int ROW = 4096;               // elements of a buffer that are looked at as a row

bool is_buffer() { return OF != OF_IMAGE && OF != OF_LAYERS; }

int level_count() { return OF == OF_IMAGE ? textureQueryLevels(image) : OF == OF_LAYERS ? textureQueryLevels(layers) : 1; }

int element_count() { return OF == OF_TEXELS ? textureSize(texels) : OF == OF_FLOATS ? floats.length() : vectors.length(); }

ivec3 extent(int level) {
    if (OF == OF_IMAGE) return ivec3(textureSize(image, level), 1);
    if (OF == OF_LAYERS) return textureSize(layers, level);
    return ivec3(ROW, (element_count() + ROW - 1) / ROW, 1);
}

vec4 value_at(ivec3 p, int level) {
    if (OF == OF_IMAGE) return texelFetch(image, p.xy, level);
    if (OF == OF_LAYERS) return texelFetch(layers, p, level);
    const int i = p.y * ROW + p.x;
    if (OF == OF_TEXELS) return texelFetch(texels, i);
    if (OF == OF_FLOATS) return vec4(floats[i], 0.0, 0.0, 1.0);
    return vectors[i];
}

// The last row of a buffer is cut off.
int row_length(ivec3 size, int y) { return is_buffer() ? min(ROW, element_count() - y * ROW) : size.x; }

struct Counts {
    uint checked, nan, inf, out_of_range;
};

// On the bits: compilers may take it that no number is NaN.
void look(vec4 value, inout Counts counts) {
    const uvec4 magnitude = floatBitsToUint(value) & 0x7fffffffu;
    const bool nan = any(greaterThan(magnitude, uvec4(EXPONENT)));
    const bool inf = !nan && any(equal(magnitude, uvec4(EXPONENT)));
    const bool outside = any(lessThan(value, params.least)) || any(greaterThan(value, params.greatest));
    counts.checked += 1u;
    counts.nan += nan ? 1u : 0u;
    counts.inf += inf ? 1u : 0u;
    counts.out_of_range += !nan && !inf && outside ? 1u : 0u;
}

void main() {
    Counts counts = Counts(0u, 0u, 0u, 0u);
    const int lane = int(gl_LocalInvocationID.x);
    for (int level = 0; level < level_count(); ++level) {
        const ivec3 size = extent(level);
        for (int row = int(gl_WorkGroupID.x); row < size.y * size.z; row += int(gl_NumWorkGroups.x)) {
            const int layer = row / size.y, y = row - layer * size.y, length = row_length(size, y);
            // All lanes take every turn: no value is carried out of a loop that some of them left.
            for (int first = 0; first < length; first += int(GROUP_X))
                if (first + lane < length) look(value_at(ivec3(first + lane, y, layer), level), counts);
        }
    }
    count_checked(counts.checked);
    count_nan(counts.nan);
    count_inf(counts.inf);
    count_out_of_range(counts.out_of_range);
}
