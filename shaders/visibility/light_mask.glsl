// SPDX-License-Identifier: MIT
// Which of a light's samples lie on one side of a line across it: an entry of a table (nodes/tables/light_samples.h), by the line's
// direction and by how many samples it cuts off. The other side is the exact complement, so that two triangles at an edge leave no
// crack between them, whatever rounding did to the edge.
//
// Includer has common/light.glsl and declares: block light; uniform image2D light_samples; uimage2D half_planes_64, half_planes_128, half_planes_256; const uint SAMPLES.
#include "common/rounded.glsl"

const uint LIGHT_SAMPLES = SAMPLES <= 64u ? 64u : SAMPLES <= 128u ? 128u : 256u;
const uint MASK_WORDS = LIGHT_SAMPLES / 32u;
const int SAMPLES_ROW = LIGHT_SAMPLES == 64u ? 0 : LIGHT_SAMPLES == 128u ? 1 : 2;  // of the table light_samples
const int SQUARE_SAMPLES = 3;                                                      // rows from the disc's to the square's

// Bit i of word w is sample 32 w + i. Words that there are no samples for are 0.
struct LightMask {
    uvec4 lo, hi;
};

const LightMask NO_SAMPLES = LightMask(uvec4(0u), uvec4(0u));
LightMask all_samples() {
    const uint second = LIGHT_SAMPLES > 64u ? ~0u : 0u, rest = LIGHT_SAMPLES > 128u ? ~0u : 0u;
    return LightMask(uvec4(~0u, ~0u, second, second), uvec4(rest));
}

LightMask mask_and(LightMask a, LightMask b) { return LightMask(a.lo & b.lo, a.hi & b.hi); }
LightMask mask_or(LightMask a, LightMask b) { return LightMask(a.lo | b.lo, a.hi | b.hi); }
LightMask mask_without(LightMask a, LightMask b) { return LightMask(a.lo & ~b.lo, a.hi & ~b.hi); }

LightMask mask_if(bool wanted, LightMask a) {
    const uint all = wanted ? ~0u : 0u;
    return LightMask(a.lo & all, a.hi & all);
}

// `a`, or where anything will do all there is.
LightMask mask_or_any(LightMask a, bool anything) {
    const uint all = anything ? ~0u : 0u;
    return LightMask(a.lo | all, a.hi | all);
}

LightMask mask_flipped(LightMask a, bool flip) {
    const LightMask change = mask_if(flip, all_samples());
    return LightMask(a.lo ^ change.lo, a.hi ^ change.hi);
}

uint count_bits(uvec4 words) {
    const uvec4 n = uvec4(bitCount(words));
    return n.x + n.y + n.z + n.w;
}
uint mask_count(LightMask a) { return count_bits(a.lo) + (MASK_WORDS > 4u ? count_bits(a.hi) : 0u); }

bool mask_is_empty(LightMask a) {
    const uvec4 any_bit = a.lo | a.hi;
    return (any_bit.x | any_bit.y | any_bit.z | any_bit.w) == 0u;
}
bool mask_is_full(LightMask a) { return mask_is_empty(mask_flipped(a, true)); }

// One sample of those in a mask that is not empty, and the number of the only sample in a mask.
LightMask mask_lowest(LightMask a) {
    const uvec4 lo = a.lo & (~a.lo + 1u), hi = a.hi & (~a.hi + 1u);  // of each word the lowest bit
    // What lies before each word, as bits: SwiftShader's compiler takes gigabytes and minutes for as many branches before a walk.
    const uint xy = lo.x | lo.y, xyz = xy | lo.z, all = xyz | lo.w, x2 = all | hi.x, y2 = x2 | hi.y, z2 = y2 | hi.z;
    return LightMask(mix(lo, uvec4(0u), notEqual(uvec4(0u, lo.x, xy, xyz), uvec4(0u))),
                     mix(hi, uvec4(0u), notEqual(uvec4(all, x2, y2, z2), uvec4(0u))));
}
int mask_index(LightMask a) {
    const uvec4 lo = mix(uvec4(0u), uvec4(0u, 32u, 64u, 96u), notEqual(a.lo, uvec4(0u))),
                hi = mix(uvec4(0u), uvec4(128u, 160u, 192u, 224u), notEqual(a.hi, uvec4(0u)));
    const uint bits = a.lo.x | a.lo.y | a.lo.z | a.lo.w | a.hi.x | a.hi.y | a.hi.z | a.hi.w;
    return int(lo.y | lo.z | lo.w | hi.x | hi.y | hi.z | hi.w) + findLSB(bits);
}

// A light as a receiver sees it: on the plane at distance 1 along z a disc of this radius, or the square [-1, 1]^2.
struct LightShape {
    float radius, per_radius;
    float bulge;
    float area[5];  // of the disc's part x >= -c, in units of the whole: 1/2 + sum of area[k] c^(2k+1)
    // Of what is near (seen_light.glsl) alone:
    bool square;
    vec2 cap;  // of a cap that can be large: 1 - cos a, sin^2 a. 0 is a disc
};

// The area within 2.2e-4, and 0 or 1 at the rim within 5e-6. The sun's samples are uniform over its
// cap, by Lambert's map, where a line of the tangent plane is a curve: through sin(phi / 2) / sin(a / 2) in the middle, for
// c = tan(phi) / tan(a), and through c at the rim. To third order in a, the line that cuts off as much lies at c + a^2 / 4 c (1 - c^2).
LightShape sun_shape(float angular_radius) {
    const float bulge = 0.25 * angular_radius * angular_radius, radius = tan(angular_radius);
    return LightShape(radius, 1.0 / max(radius, 1e-30), bulge,
                      float[5](0.6345046 + 0.6659715 * bulge, -0.0742046 - 1.1252572 * bulge, -0.1463876 + 0.4592857 * bulge,
                               0.1943180, -0.1082343),
                      false, vec2(0.0));
}

// What a cap has besides the disc's area: exactly, (asin(k w / q) / k - w) / pi for w = c sqrt(1 - c^2), k = 1 - cos a and
// q^2 = 1 - (1 - c^2) sin^2 a, here with three terms of the arc sine: within 1e-3 to a = 75 degrees.
float cap_area(vec2 cap, float c2, float c) {
    const float w = c * sqrt(max(1.0 - c2, 0.0)), x = w * inversesqrt(max(1.0 - (1.0 - c2) * cap.y, 1e-6));
    const float x2 = x * x * cap.x * cap.x;
    return 0.31830989 * (x * (1.0 + x2 * (0.16666667 + 0.075 * x2)) - w);
}

// The direction to a sample of the light, in the units of the table.
vec3 to_sample(LightShape shape, vec2 point) {
    const float r2 = dot(point, point);
    if (HAS_LIGHT) {
        const float v = shape.cap.x * r2;  // 1 - cos of the angle to it
        return vec3(point * (shape.cap.x > 0.0 ? sqrt(shape.cap.x * (2.0 - v)) / (1.0 - v) : shape.radius), 1.0);
    }
    return vec3(point * (shape.radius * (1.0 - shape.bulge * (1.0 - r2))), 1.0);
}

vec2 sample_point(LightShape shape, int index) {
    return imageLoad(light_samples, ivec2(index, HAS_LIGHT && shape.square ? SAMPLES_ROW + SQUARE_SAMPLES : SAMPLES_ROW)).xy;
}

// A line across the light: where e . (x, y, 1) >= 0.
struct LightLine {
    ivec2 entry;  // in the table
    bool flip;    // the entry is that of -e
};

// From a number in [0, 1). Away from the ends by more than 256 times what the area is off at the rim, and than rounding: next to them a line beside
// the light would cut off a sample, or one more than there are.
float line_dither(float u) { return 0.002 + 0.996 * u; }

// Of -e the same entry. `e` may be of any length that a float holds, and zero. `dither` rounds a share of the samples up or down; it is the same for
// all lines of a pixel.
LightLine light_line(LightShape shape, float dither, vec3 e) {
    LightLine line;
    line.flip = (e.y != 0.0 ? e.y : e.x) < 0.0;
    if (line.flip) e = -e;
    const float inverse = 1.0 / max(abs(e.x) + e.y, 1e-37);
    const float p = e.x * inverse, size = abs(p);  // the normal is (p, 1 - |p|), up to its length
    float area, first_bin = 0.0;
    if (HAS_LIGHT && shape.square) {
        area = square_area(max(size, 1.0 - size), clamp(e.z * inverse, -1.0, 1.0));
        first_bin = float(HALF_PLANE_DIRECTIONS);
    } else {
        const float m = size - size * size;  // 1 / sqrt(1 - 2 m), within 9e-5
        const float per_length = 1.0000891 + m * (0.9840561 + m * (1.9511038 + m * (m * 18.8985459 - 1.7756891)));
        const float c = clamp(e.z * inverse * shape.per_radius * per_length, -1.0, 1.0), c2 = c * c;
        area = c * (shape.area[0] + c2 * (shape.area[1] + c2 * (shape.area[2] + c2 * (shape.area[3] + c2 * shape.area[4]))));
        if (HAS_LIGHT && shape.cap.x > 0.0) area += cap_area(shape.cap, c2, c);
    }
    const float samples = float(LIGHT_SAMPLES), bins = float(HALF_PLANE_DIRECTIONS);
    // Rounded down, by way of a number above 1/2, which rounded() wants.
    line.entry =
        ivec2(rounded(samples * area + (0.5 * samples + 0.5 + dither)), rounded(0.5 * (0.9999 * bins * p + bins + 1.0) + first_bin)) - 1;
    return line;
}

// Whether no sample lies where e is positive; negative.
bool none_positive(LightLine line) { return line.entry.x == (line.flip ? int(LIGHT_SAMPLES) : 0); }
bool none_negative(LightLine line) { return line.entry.x == (line.flip ? 0 : int(LIGHT_SAMPLES)); }

LightMask positive_side(LightLine line) {
    LightMask mask = NO_SAMPLES;
    if (LIGHT_SAMPLES == 64u) mask.lo.xy = imageLoad(half_planes_64, line.entry).xy;
    if (LIGHT_SAMPLES == 128u) mask.lo = imageLoad(half_planes_128, line.entry);
    if (LIGHT_SAMPLES == 256u) {
        mask.lo = imageLoad(half_planes_256, line.entry * ivec2(2, 1));
        mask.hi = imageLoad(half_planes_256, line.entry * ivec2(2, 1) + ivec2(1, 0));
    }
    return mask_flipped(mask, line.flip);
}
