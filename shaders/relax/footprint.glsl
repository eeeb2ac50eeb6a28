// SPDX-License-Identifier: MIT
// Which texels around a place of the previous frame saw the surface that is asked for, and what the pasts hold there.
//
// Includer has common/camera.glsl, common/corners.glsl, common/cubic.glsl, common/receiver_normal.glsl, common/same_surface.glsl and
// relax/frames.glsl and declares: images surface_prev, slow_prev, fast_prev, frames_prev.

// What a past must have shown: either of two depths within a tolerance, and `here`'s normal within an angle of this sine.
struct Expected {
    vec2 depths;
    float tolerance, most_sine;
};

struct Footprint {
    ivec2 first;   // of the four texels around
    vec2 within;
    vec4 shares;   // bilinear weights; 0 where another surface was
    float seen;    // their sum
    bool whole;    // Catmull-Rom's twelve texels are all of the surface
};

// A comparison that a NaN fails.
bool in_image(vec2 uv) { return all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0))); }

bool was_seen(Shown here, Expected e, ivec2 q) {
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, ivec2(frame.prev_size)))) return false;
    const uvec2 then = imageLoad(surface_prev, q).xy;
    const float z = surface_depth(then);
    if (!(z > 0.0) || !any(lessThanEqual(abs(z - e.depths), vec2(e.tolerance)))) return false;
    const vec3 n = surface_normal(then);
    if (!(dot(here.n, n) > 0.0 && length(cross(here.n, n)) <= e.most_sine)) return false;
    if (LOBE == LOBE_SPECULAR && !alike(here.roughness, surface_roughness(then))) return false;
    return decode_frames(imageLoad(frames_prev, q).x) > 0.0;
}

// Whether Catmull-Rom reads the texel x, y of 0 to 3; the corners weigh least and are left out.
bool of_twelve(int x, int y) { return x % 3 != 0 || y % 3 != 0; }

// A place on a texel's centre, as all are where nothing moves, asks that texel alone.
Footprint footprint_at(Shown here, Expected e, vec2 uv) {
    Footprint f = Footprint(ivec2(0), vec2(0.0), vec4(0.0), 0.0, false);
    if ((frame.flags & FRAME_RESET) != 0u || !in_image(uv)) return f;
    const vec2 at = uv * vec2(frame.prev_size) - 0.5, rounded_at = round(at);
    const bool centred = all(lessThan(abs(at - rounded_at), vec2(1.0 / 256.0)));
    f.first = ivec2(centred ? rounded_at : floor(at));
    f.within = centred ? vec2(0.0) : at - floor(at);
    for (int i = 0; i < (centred ? 1 : 4); ++i)
        if (was_seen(here, e, f.first + corner(i))) f.shares[i] = bilinear_share(i, f.within);
    f.seen = f.shares.x + f.shares.y + f.shares.z + f.shares.w;
    f.whole = !centred && f.seen > 0.999;
    for (int i = 0; i < 16 && f.whole; ++i)
        if (of_twelve(i % 4, i / 4)) f.whole = was_seen(here, e, f.first + ivec2(i % 4, i / 4) - 1);
    return f;
}

struct Past {
    vec4 slow, fast;
    float frames;  // 0: none, and all else 0
};

Past past_at(Footprint f) {
    Past past = Past(vec4(0.0), vec4(0.0), 0.0);
    if (!(f.seen > 0.01)) return past;
    for (int i = 0; i < 4; ++i) {
        if (!(f.shares[i] > 0.0)) continue;
        const ivec2 q = f.first + corner(i);
        past.slow += f.shares[i] * imageLoad(slow_prev, q);
        past.fast += f.shares[i] * imageLoad(fast_prev, q);
        past.frames += f.shares[i] * decode_frames(imageLoad(frames_prev, q).x);
    }
    past.slow /= f.seen;
    past.fast /= f.seen;
    past.frames /= f.seen;
    if (!f.whole) return past;
    const vec4 wx = cubic_weights(f.within.x), wy = cubic_weights(f.within.y);
    vec4 slow = vec4(0.0), fast = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 16; ++i) {
        if (!of_twelve(i % 4, i / 4)) continue;
        const ivec2 q = f.first + ivec2(i % 4, i / 4) - 1;
        const float weight = wx[i % 4] * wy[i / 4];
        slow += weight * imageLoad(slow_prev, q);
        fast += weight * imageLoad(fast_prev, q);
        weights += weight;
    }
    // Its negative lobes would make light negative beside what is bright.
    past.slow = max(slow / weights, vec4(0.0));
    past.fast = vec4(max(fast.rgb / weights, vec3(0.0)), past.fast.w);
    return past;
}
