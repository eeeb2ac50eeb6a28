// SPDX-License-Identifier: MIT
// The colours around a pixel as a box, and the history limited to it.
//
// Includer has compress(), finite.glsl, lanes_in_a_row.glsl and the image lit.

// Luma and chroma vary independently of each other more often than red, green and blue do: a box along these axes is the
// tighter one. Malvar and Sullivan 2003, YCoCg.
vec3 to_box_axes(vec3 c) {
    if (BOX == BOX_RGB) return c;
    return vec3(0.25 * c.x + 0.5 * c.y + 0.25 * c.z, 0.5 * (c.x - c.z), 0.5 * c.y - 0.25 * (c.x + c.z));
}
vec3 from_box_axes(vec3 c) {
    if (BOX == BOX_RGB) return c;
    return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}

// Weights exp(-3 r^2 / 4) of 3x3 pixels are products of an axis' own: 1, and exp(-3/4) to either side.
const float SIDE = 0.4723665527;
const float WEIGHTS = (1.0 + 2.0 * SIDE) * (1.0 + 2.0 * SIDE);

vec3 current(ivec2 p) { return compress(storable(imageLoad(lit, clamp(p, ivec2(0), ivec2(frame.size) - 1)).xyz)); }

// Three pixels side by side.
struct ColorRow {
    vec3 shown;          // of the middle one
    vec3 sum, squares;  // weighted, along the box's axes
};

// `row` is counted from the first one that is asked for, and `sides` goes from row to row.
ColorRow color_row(int x, int y, int row, inout vec3 sides) {
    const vec3 shown = current(ivec2(x, y)), c = to_box_axes(shown);
    vec3 l, r;
    if (IN_A_ROW) {
        if (sides_are_due(row)) sides = to_box_axes(current(beside_row(x, y)));
        l = left_of(c, sides, row);
        r = right_of(c, sides, row);
    } else {
        l = to_box_axes(current(ivec2(x - 1, y)));
        r = to_box_axes(current(ivec2(x + 1, y)));
    }
    return ColorRow(shown, c + SIDE * (l + r), c * c + SIDE * (l * l + r * r));
}

struct Box {
    vec3 shown;  // by the pixel itself
    vec3 mean, deviation;
};

Box box_of(ColorRow above, ColorRow here, ColorRow below) {
    const vec3 mean = (here.sum + SIDE * (above.sum + below.sum)) / WEIGHTS;
    const vec3 squares = (here.squares + SIDE * (above.squares + below.squares)) / WEIGHTS;
    return Box(here.shown, mean, sqrt(max(squares - mean * mean, 0.0)));
}

// History limited to mean +- scale deviations. In the robust form the pixel's own colour is inside too, however far off
// its neighbours are (a lone bright pixel would fade otherwise), and what is inside stays as it is to the bit.
vec3 clamp_to_box(Box box, vec3 past, float scale) {
    const vec3 half_box = scale * box.deviation;
    vec3 low = box.mean - half_box, high = box.mean + half_box;
    if (FORM == FORM_ROBUST) {
        const vec3 c = to_box_axes(box.shown);
        low = min(low, c);
        high = max(high, c);
    }
    const vec3 before = to_box_axes(past), inside = clamp(before, low, high);
    return BOX != BOX_RGB && inside == before ? past : from_box_axes(inside);
}
