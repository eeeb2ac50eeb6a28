// SPDX-License-Identifier: MIT
// What the bits around a pixel say: their mean over 17x17 pixels, and how soft the shadow's edge is. Only receivers inside
// the image count. An invocation asks for the eight pixels of a column of an 8x8 block, so that each row is counted once.
//
// Softness. In a cell of 4x4 pixels a hard edge changes the bits in one direction, so there are as many changes as their
// signed sum says. The noise of a penumbra changes back and forth and adds to the former alone. The ratio over 5x5 cells
// is 1 at a hard edge of any direction, also of a pole or leaf that is wider than a cell; 1.2, 1.9, 3.0, 4.4, 5.7 in
// penumbrae of 2, 4, 8, 16, 32 pixels.

const int WINDOW_RADIUS = 8;
const int WINDOW = 2 * WINDOW_RADIUS + 1;
const int WINDOW_ROWS = 8 + 2 * WINDOW_RADIUS;  // rows that the windows of eight pixels cover

// The words of the 24x24 pixels around a block: [tile row][left, middle, right], from two above to two below.
struct Surroundings {
    uvec3 lit[6];
    uvec3 receivers[6];
};

// 24 pixels of row `row` of a tile and of its neighbours; bit 0 is 8 pixels left of the tile's first.
uint row_of(uvec3 words, int row) {
    const uvec3 bytes = words >> uint(8 * row) & 0xffu;
    return bytes.x | bytes.y << 8 | bytes.z << 16;
}

void local_means(Surroundings around, int column, out float means[8]) {
    int sums[WINDOW_ROWS + 1];  // over the rows above each: lit pixels, and receivers in the upper half
    sums[0] = 0;
    for (int i = 0; i < WINDOW_ROWS; ++i) {
        const uint receivers = row_of(around.receivers[i >> 2], i & 3) >> column & 0x1ffffu;
        const uint lit = row_of(around.lit[i >> 2], i & 3) >> column & receivers;
        sums[i + 1] = sums[i] + bitCount(lit) + (bitCount(receivers) << 16);
    }
    for (int j = 0; j < 8; ++j) {
        const int sum = sums[j + WINDOW] - sums[j];
        means[j] = float(sum & 0xffff) / max(float(sum >> 16), 1.0);
    }
}

// Each pixel's right and lower neighbour, moved onto the pixel.
uint right_neighbours(uint word, uint right) { return (word >> 1 & 0x7f7f7f7fu) | (right & 0x01010101u) << 7; }
uint lower_neighbours(uint word, uint below) { return word >> 8 | below << 24; }

// Changes, and the magnitude of their signed sum. `to`: the neighbours' bits.
ivec2 changes_in(uint from, uint to, uint counted) {
    const uint changed = (from ^ to) & counted;
    const int all = bitCount(changed);
    return ivec2(all, abs(2 * bitCount(changed & to) - all));
}

// Of the upper and the lower four pixels of a column: 1 or less at a hard edge, more in a penumbra.
vec2 softness_of(Surroundings around, int column) {
    const int first = column >> 2;  // of five columns of cells out of six
    ivec2 sums[6];
    for (int y = 0; y < 6; ++y) {
        sums[y] = ivec2(0);
        const uvec3 lit = around.lit[y], receivers = around.receivers[y];
        for (int x = 0; x < 3; ++x) {
            const uint lit_right = right_neighbours(lit[x], x < 2 ? lit[x + 1] : 0u);
            const uint lit_below = lower_neighbours(lit[x], y < 5 ? around.lit[y + 1][x] : 0u);
            const uint pairs_right = receivers[x] & right_neighbours(receivers[x], x < 2 ? receivers[x + 1] : 0u);
            const uint pairs_below = receivers[x] & lower_neighbours(receivers[x], y < 5 ? around.receivers[y + 1][x] : 0u);
            for (int half_word = 0; half_word < 2; ++half_word) {
                const int cell = 2 * x + half_word;
                const uint pixels = 0x0f0f0f0fu << 4 * half_word;
                if (cell >= first && cell < first + 5)
                    sums[y] += changes_in(lit[x], lit_right, pairs_right & pixels) +
                               changes_in(lit[x], lit_below, pairs_below & pixels);
            }
        }
    }
    const ivec2 shared_rows = sums[1] + sums[2] + sums[3] + sums[4];
    const vec2 upper = vec2(shared_rows + sums[0]), lower = vec2(shared_rows + sums[5]);
    return vec2(upper.x / (upper.y + 1.0), lower.x / (lower.y + 1.0));
}
