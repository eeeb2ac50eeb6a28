// SPDX-License-Identifier: MIT
// May frames have several rays per pixel, or none? How the state is packed (common/shadow_state.glsl) follows from that in every pass of
// the denoiser, and all of them have both ports, which wire themselves by their names.
const bool MANY_RAYS = HAS_RAY_WORDS || HAS_RAY_BITS;
