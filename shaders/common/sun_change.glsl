// SPDX-License-Identifier: MIT
// What an average over the last frame's sun is worth under this frame's. Valid is the share of the larger disc where both
// lie: of a sun that shrinks the others of its samples went beside it, and of one that grows none has been where there is
// light now. None is, once the sun has moved by more than its own width. The rest shifts the average by at most 1 - share of the
// visibility, in a direction that nobody knows; taken as uniform that is a variance of (1 - share)^2 / 3, and no number
// of samples makes it smaller.
//
// A slow sun costs next to nothing (at a hundredth of its width per frame 30 samples of 32 are left), a jump everything:
// nothing has to be found out from the new samples' noise.
const float SAMPLE_VARIANCE = 0.144;  // v (1 - v), averaged over a straight penumbra of a round sun

// Share of the larger of two discs that the other covers; their centres lie d apart. Radians.
float shared_share(float r, float r_prev, float d) {
    const float smaller = min(r, r_prev), larger = max(r, r_prev);
    if (d >= r + r_prev) return 0.0;
    if (d <= abs(r - r_prev)) return smaller * smaller / (larger * larger);
    const float x = (d * d + r * r - r_prev * r_prev) / (2.0 * d);  // of the common chord, from the first centre
    const float a = clamp(x / r, -1.0, 1.0), b = clamp((d - x) / r_prev, -1.0, 1.0);
    const float lens = r * r * (acos(a) - a * sqrt(1.0 - a * a)) + r_prev * r_prev * (acos(b) - b * sqrt(1.0 - b * b));
    return clamp(lens / (3.14159265 * larger * larger), 0.0, 1.0);
}

float sun_share(Sun now, Sun before) {
    // The chord is the angle's to 1e-4 below 2 degrees, and large suns that move far are worth nothing either way.
    const float d = distance(now.to_sun, before.to_sun);
    const float rounding = 4.0 * 1.1920929e-7;  // of the two unit vectors: a sun that stands still has not moved
    return d <= rounding && now.angular_radius == before.angular_radius
               ? 1.0
               : shared_share(now.angular_radius, before.angular_radius, d);
}

// Of `count` samples.
float samples_left(float count, float share) {
    const float changed = 1.0 - share;
    return count > 0.0 ? share / (1.0 / count + changed * changed / (3.0 * SAMPLE_VARIANCE)) : 0.0;
}
