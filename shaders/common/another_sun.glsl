// SPDX-License-Identifier: MIT
// Whether nothing of the last frame's sun is left: then what its rays said is no reason to spare a ray.
//
// Includer has common/sun_change.glsl and declares: blocks sun, sun_prev, where HAS_SUN_PREV; constant HAS_LIGHT.
bool is_another_sun() { return HAS_SUN_PREV && !HAS_LIGHT && !(sun_share(sun, sun_prev) > 0.0); }
