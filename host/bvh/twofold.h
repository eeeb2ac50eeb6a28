// SPDX-License-Identifier: MIT
// Three numbers at once as unevaluated sums hi + lo of two floats: shaders/common/twofold.glsl, operation by
// operation, so that the processor's traversal gives the shader's bits.
#pragma once

#include <glm/glm.hpp>

namespace penumbra {

struct Twofold {
    glm::vec3 hi, lo;
};

inline Twofold twofold_difference(const glm::vec3& a, const glm::vec3& b) {
    const glm::vec3 hi = a - b, b_seen = a - hi;
    return {hi, (a - (hi + b_seen)) + (b_seen - b)};
}

inline Twofold twofold_product(const glm::vec3& a, const glm::vec3& b) {
    constexpr float split = 4097;
    const glm::vec3 hi = a * b, a_far = split * a, b_far = split * b;
    const glm::vec3 a_hi = a_far - (a_far - a), b_hi = b_far - (b_far - b), a_lo = a - a_hi, b_lo = b - b_hi;
    return {hi, a_lo * b_lo - (((hi - a_hi * b_hi) - a_lo * b_hi) - a_hi * b_lo)};
}

inline Twofold twofold_carry(const glm::vec3& hi, const glm::vec3& lo) {
    const glm::vec3 sum = hi + lo;
    return {sum, lo - (sum - hi)};
}

inline Twofold difference(const Twofold& a, const Twofold& b) {
    const Twofold d = twofold_difference(a.hi, b.hi);
    return twofold_carry(d.hi, d.lo + (a.lo - b.lo));
}

inline Twofold product(const Twofold& a, const Twofold& b) {
    const Twofold p = twofold_product(a.hi, b.hi);
    return twofold_carry(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

inline Twofold cross_product(const Twofold& a, const Twofold& b) {
    const auto yzx = [](const Twofold& t) {
        return Twofold{{t.hi.y, t.hi.z, t.hi.x}, {t.lo.y, t.lo.z, t.lo.x}};
    };
    const auto zxy = [](const Twofold& t) {
        return Twofold{{t.hi.z, t.hi.x, t.hi.y}, {t.lo.z, t.lo.x, t.lo.y}};
    };
    return difference(product(yzx(a), zxy(b)), product(zxy(a), yzx(b)));
}

inline float dot_product(const Twofold& a, const Twofold& b) {
    const Twofold p = product(a, b);
    const float xy = p.hi.x + p.hi.y, y_seen = xy - p.hi.x,
                xy_lo = (p.hi.x - (xy - y_seen)) + (p.hi.y - y_seen);
    const float xyz = xy + p.hi.z, z_seen = xyz - xy, xyz_lo = (xy - (xyz - z_seen)) + (p.hi.z - z_seen);
    return xyz + ((xy_lo + xyz_lo) + ((p.lo.x + p.lo.y) + p.lo.z));
}

}  // namespace penumbra
