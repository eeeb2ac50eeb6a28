// SPDX-License-Identifier: MIT
// The colour history between its texels: Catmull-Rom over 4x4 of them, as published; the robust form leaves out the four
// corners, which weigh 1/64 at most together (Jimenez 2016, Filmic SMAA). Texels, not filtered samples, are what a software
// device is fast at, and no device's 8 bits of filter weight get into the average.
//
// Includer has camera.glsl and rounded.glsl and declares the image history.
#include "common/cubic.glsl"

ivec2 history_last() { return ivec2(frame.prev_size) - 1; }

// The texel up and left of a place, between the centres of four; -1 and less is all one.
ivec2 history_base(vec2 texel) {
    const vec2 up = min(max(floor(texel + 0.5), 0.0), 1e6);
    return ivec2(rounded(up.x), rounded(up.y)) - 1;
}

vec3 texel_at(int x, int y) { return imageLoad(history, ivec2(x, y)).xyz; }

vec3 history_at(vec2 texel) {
    const ivec2 base = history_base(texel), last = history_last();
    const vec2 f = texel - 0.5 - vec2(base);
    const ivec4 x = clamp(base.x + ivec4(-1, 0, 1, 2), 0, last.x), y = clamp(base.y + ivec4(-1, 0, 1, 2), 0, last.y);
    const vec4 wx = cubic_weights(f.x), wy = cubic_weights(f.y);
    vec3 first = wx.y * texel_at(x.y, y.x) + wx.z * texel_at(x.z, y.x);
    const vec3 second = wx.x * texel_at(x.x, y.y) + wx.y * texel_at(x.y, y.y) + wx.z * texel_at(x.z, y.y) + wx.w * texel_at(x.w, y.y);
    const vec3 third = wx.x * texel_at(x.x, y.z) + wx.y * texel_at(x.y, y.z) + wx.z * texel_at(x.z, y.z) + wx.w * texel_at(x.w, y.z);
    vec3 fourth = wx.y * texel_at(x.y, y.w) + wx.z * texel_at(x.z, y.w);
    float weights = 1.0 - (wx.x + wx.w) * (wy.x + wy.w);
    if (FORM == FORM_PUBLISHED) {
        first += wx.x * texel_at(x.x, y.x) + wx.w * texel_at(x.w, y.x);
        fourth += wx.x * texel_at(x.x, y.w) + wx.w * texel_at(x.w, y.w);
        weights = 1.0;
    }
    return (wy.x * first + wy.y * second + wy.z * third + wy.w * fourth) / weights;
}
