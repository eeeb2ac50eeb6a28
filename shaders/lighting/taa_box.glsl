// SPDX-License-Identifier: MIT
// The colours around a pixel as a box, and the history limited to it.
//
// Includer defines current(), what a pixel shows now.

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

// History limited to mean +- scale deviations of the 3x3 neighbourhood, weights exp(-3 r^2 / 4). In the robust form the
// pixel's own colour is inside too, however far off its neighbours are (a lone bright pixel would fade otherwise), and
// what is inside stays as it is to the bit.
vec3 clamp_to_neighbours(ivec2 p, vec3 past, float scale) {
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const float weight = exp(-0.75 * float(x * x + y * y));
            const vec3 c = to_box_axes(current(p + ivec2(x, y)));
            sum += weight * c;
            squares += weight * c * c;
            weights += weight;
        }
    const vec3 mean = sum / weights;
    const vec3 half_box = scale * sqrt(max(squares / weights - mean * mean, 0.0));
    vec3 low = mean - half_box, high = mean + half_box;
    if (FORM == FORM_ROBUST) {
        const vec3 c = to_box_axes(current(p));
        low = min(low, c);
        high = max(high, c);
    }
    const vec3 before = to_box_axes(past), inside = clamp(before, low, high);
    return BOX != BOX_RGB && inside == before ? past : from_box_axes(inside);
}
