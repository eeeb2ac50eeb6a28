// SPDX-License-Identifier: MIT
// Counts texels by the worst that any of their channels is: not a number, else infinite, else out of range. Groups take
// turns at the rows of everything that the port holds, so one dispatch suits every size, layer and level.
#include "node.glsl"

const uint EXPONENT = 0x7f800000u;  // of an infinity; a NaN's bits are greater
const int ROW = 4096;               // elements of a buffer that are looked at as a row

#if HAS_IMAGE
int level_count() { return textureQueryLevels(image); }
ivec3 extent(int level) { return ivec3(textureSize(image, level), 1); }
vec4 value_at(ivec3 p, int level) { return texelFetch(image, p.xy, level); }
#elif HAS_LAYERS
int level_count() { return textureQueryLevels(layers); }
ivec3 extent(int level) { return textureSize(layers, level); }
vec4 value_at(ivec3 p, int level) { return texelFetch(layers, p, level); }
#else
// The last row of a buffer is cut off by row_length().
int level_count() { return 1; }
#if HAS_TEXELS
int element_count() { return textureSize(texels); }
vec4 value_at(ivec3 p, int level) { return texelFetch(texels, p.y * ROW + p.x); }
#elif HAS_FLOATS
int element_count() { return floats.length(); }
vec4 value_at(ivec3 p, int level) { return vec4(floats[p.y * ROW + p.x], 0.0, 0.0, 1.0); }
#else
int element_count() { return vectors.length(); }
vec4 value_at(ivec3 p, int level) { return vectors[p.y * ROW + p.x]; }
#endif
ivec3 extent(int level) { return ivec3(ROW, (element_count() + ROW - 1) / ROW, 1); }
#endif

int row_length(ivec3 size, int y) {
#if HAS_IMAGE || HAS_LAYERS
    return size.x;
#else
    return min(ROW, element_count() - y * ROW);
#endif
}

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
