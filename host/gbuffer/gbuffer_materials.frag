#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
#define MATERIALS
#include "gbuffer_surface.glsl"
