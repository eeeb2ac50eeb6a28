// SPDX-License-Identifier: MIT
// The reconnection gather (reflections/reconnect.glsl), which takes what neighbours' rays found for seen from here.
#include "node.glsl"
#define ASKS 0
#include "reflections/reconnect.glsl"

void main() { for_each_pixel(); }
