// SPDX-License-Identifier: MIT
// The transfer curve of sRGB (IEC 61966-2-1), between values of 0 .. 1.
#pragma once

#include <cmath>

namespace penumbra {

template <class Real>
Real srgb_of_linear(Real linear) {
    return linear <= Real(0.0031308) ? linear * Real(12.92)
                                     : Real(1.055) * std::pow(linear, 1 / Real(2.4)) - Real(0.055);
}

template <class Real>
Real linear_of_srgb(Real encoded) {
    return encoded <= Real(0.04045) ? encoded / Real(12.92)
                                    : std::pow((encoded + Real(0.055)) / Real(1.055), Real(2.4));
}

}  // namespace penumbra
