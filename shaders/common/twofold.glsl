// SPDX-License-Identifier: MIT
// Three numbers at once as unevaluated sums hi + lo of two floats, for the rare question that one float cannot decide:
// 47 bits from additions and products that are rounded correctly, which `precise` keeps from being fused or reordered.
// Knuth 1969 (sum without error), Veltkamp and Dekker 1971 (product without error). host/bvh/twofold.h is its twin.
struct Twofold {
    vec3 hi, lo;
};

Twofold twofold_difference(vec3 a, vec3 b) {  // exact
    precise vec3 hi = a - b;
    precise vec3 b_seen = a - hi;
    precise vec3 lo = (a - (hi + b_seen)) + (b_seen - b);
    return Twofold(hi, lo);
}

Twofold twofold_product(vec3 a, vec3 b) {  // exact
    const float split = 4097.0;            // 2^12 + 1: halves of 12 bits, whose products are exact
    precise vec3 hi = a * b;
    precise vec3 a_far = split * a, b_far = split * b;
    precise vec3 a_hi = a_far - (a_far - a), b_hi = b_far - (b_far - b);
    precise vec3 a_lo = a - a_hi, b_lo = b - b_hi;
    precise vec3 lo = a_lo * b_lo - (((hi - a_hi * b_hi) - a_lo * b_hi) - a_hi * b_lo);
    return Twofold(hi, lo);
}

Twofold twofold_carry(vec3 hi, vec3 lo) {
    precise vec3 sum = hi + lo;
    precise vec3 rest = lo - (sum - hi);
    return Twofold(sum, rest);
}

Twofold difference(Twofold a, Twofold b) {
    const Twofold d = twofold_difference(a.hi, b.hi);
    precise vec3 lo = d.lo + (a.lo - b.lo);
    return twofold_carry(d.hi, lo);
}

Twofold product(Twofold a, Twofold b) {
    const Twofold p = twofold_product(a.hi, b.hi);
    precise vec3 lo = p.lo + (a.hi * b.lo + a.lo * b.hi);
    return twofold_carry(p.hi, lo);
}

Twofold cross_product(Twofold a, Twofold b) {
    return difference(product(Twofold(a.hi.yzx, a.lo.yzx), Twofold(b.hi.zxy, b.lo.zxy)),
                      product(Twofold(a.hi.zxy, a.lo.zxy), Twofold(b.hi.yzx, b.lo.yzx)));
}

// Rounded once, at the end.
float dot_product(Twofold a, Twofold b) {
    const Twofold p = product(a, b);
    precise float xy = p.hi.x + p.hi.y;
    precise float y_seen = xy - p.hi.x;
    precise float xy_lo = (p.hi.x - (xy - y_seen)) + (p.hi.y - y_seen);
    precise float xyz = xy + p.hi.z;
    precise float z_seen = xyz - xy;
    precise float xyz_lo = (xy - (xyz - z_seen)) + (p.hi.z - z_seen);
    precise float sum = xyz + ((xy_lo + xyz_lo) + ((p.lo.x + p.lo.y) + p.lo.z));
    return sum;
}
