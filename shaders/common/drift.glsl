// SPDX-License-Identifier: MIT
// Has the shadow moved? Compares the samples of a neighbourhood with the history of the *same* pixels. In a shadow that
// stands still each residual, sample - history, has mean zero however steep the penumbra is, so the sum over a
// neighbourhood stays within a few of its deviations. A moved edge gives residuals of one sign along its whole length.
// (Holding the history against the neighbourhood's mean instead blurs every penumbra that is narrower than it.)
//
// Sums are over 17x8 pixels and over their four halves, because the two edges of a pole cancel in the whole.
// A shadow of a pixel's width is swamped by the noise of a wide penumbra beside it: sums over 5x4 pixels find it.
// Columns beyond the workgroup's 64 are left out. Every lane calls share_residuals(), then barrier(), then drift().

struct Residuals {
    float sum;       // of sample - history
    float variance;  // that the sum has if nothing moved
};

const int DRIFT_RADIUS = 8, LOCAL_RADIUS = 2;
const float HALF_THRESHOLD_RATIO = 1.75;  // four halves are as many chances for a false alarm
const float VARIANCE_FLOOR = 0.05;

shared vec2 residuals_of_column[2][64];  // upper and lower four rows

void share_residuals(int lane, Residuals upper, Residuals lower) {
    residuals_of_column[0][lane] = vec2(upper.sum, upper.variance);
    residuals_of_column[1][lane] = vec2(lower.sum, lower.variance);
}

float squared_deviations(vec2 residuals) {
    return residuals.x * residuals.x / (residuals.y + VARIANCE_FLOOR);
}

// By how much the threshold is exceeded, in squared deviations; 0 where nothing speaks for a change.
float drift(int lane, float threshold) {
    const int first = max(lane - DRIFT_RADIUS, 0), last = min(lane + DRIFT_RADIUS, 63);
    vec2 upper_left = vec2(0.0), upper_right = vec2(0.0), lower_left = vec2(0.0), lower_right = vec2(0.0);
    for (int i = first; i <= lane; ++i) {
        upper_left += residuals_of_column[0][i];
        lower_left += residuals_of_column[1][i];
    }
    for (int i = lane + 1; i <= last; ++i) {
        upper_right += residuals_of_column[0][i];
        lower_right += residuals_of_column[1][i];
    }
    const vec2 left = upper_left + lower_left, right = upper_right + lower_right;
    const float whole = squared_deviations(left + right);
    const float half_of = max(max(squared_deviations(left), squared_deviations(right)),
                              max(squared_deviations(upper_left + upper_right), squared_deviations(lower_left + lower_right)));
    return max(0.0, max(whole - threshold, half_of - HALF_THRESHOLD_RATIO * threshold));
}

// The same of the nearest columns, for the upper and the lower four rows.
vec2 local_drift(int lane, float threshold) {
    const int first = max(lane - LOCAL_RADIUS, 0), last = min(lane + LOCAL_RADIUS, 63);
    vec2 upper = vec2(0.0), lower = vec2(0.0);
    for (int i = first; i <= last; ++i) {
        upper += residuals_of_column[0][i];
        lower += residuals_of_column[1][i];
    }
    return max(vec2(squared_deviations(upper), squared_deviations(lower)) - threshold, 0.0);
}
