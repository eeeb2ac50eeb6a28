// SPDX-License-Identifier: MIT
// To the nearest whole number, halves to the even one, for 0 <= x < 2^23 and no NaN: adding 2^23 leaves no room for a
// fraction. Software devices convert a float lane by lane, which takes them as long as thirty additions.
uint rounded(float x) {
    precise float shifted = x + 8388608.0;  // a driver that reassociated this would round a part of x first
    return floatBitsToUint(shifted) & 0x7fffffu;
}
