// SPDX-License-Identifier: MIT
// The reconnection gather (reflections/reconnect.glsl) with one ray per pixel that asks whether it sees what a neighbour's ray found.
#include "node.glsl"
#define ASKS 1
#include "reflections/reconnect.glsl"

void main() { for_each_pixel(); }
