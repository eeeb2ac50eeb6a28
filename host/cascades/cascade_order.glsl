// SPDX-License-Identifier: MIT
// Floats as unsigned integers in the same order, for atomic minima; all bits set: none.
const uint NONE = 0xffffffffu;

uint ordered(float v) {
    const uint bits = floatBitsToUint(v);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float from_ordered(uint key) {
    return uintBitsToFloat((key & 0x80000000u) != 0u ? key & 0x7fffffffu : ~key);
}
