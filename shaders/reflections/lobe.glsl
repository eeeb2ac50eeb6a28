// SPDX-License-Identifier: MIT
// The two ways a surface mirrors light: the GGX lobe of its roughness, without its colour, and the diffuse one. What is kept
// of either is demodulated, the mean of incident radiance under the lobe: sum w L / sum w, 1 wherever L is.
//   density  q(l): of directions as sample_lobe() draws them (GGX: those of visible normals, Heitz 2018);
//   response F(l): reflectance times cosine, but for colour and Fresnel: D G2 / (4 n.v), (n.l)+ / pi.
//
// Includer has common/sun_sample.glsl and declares: constant LOBE.

const float LEAST_ALPHA = 1e-4;  // a mirror below it: nothing near tells it apart from one

bool is_mirror(float roughness) { return LOBE == LOBE_SPECULAR && roughness * roughness < LEAST_ALPHA; }

struct Lobe {
    vec3 n, v;
    float alpha2, n_v, lambda_v;
};

// Smith's Lambda for GGX, of a direction with this cosine.
float smith_lambda(float cosine, float alpha2) {
    const float c2 = max(cosine * cosine, 1e-12);
    return 0.5 * sqrt(1.0 + alpha2 * max(1.0 - c2, 0.0) / c2) - 0.5;
}

// `n`, `v`: unit vectors, v towards the viewer.
Lobe make_lobe(vec3 n, vec3 v, float roughness) {
    const float alpha = max(roughness * roughness, LEAST_ALPHA), n_v = max(dot(n, v), 1e-4);
    return Lobe(n, v, alpha * alpha, n_v, LOBE == LOBE_SPECULAR ? smith_lambda(n_v, alpha * alpha) : 0.0);
}

// GGX of the half vector. The sine from a cross product: 1 - cosine^2 has no digits left where alpha is small.
float ggx(Lobe lobe, vec3 h) {
    const vec3 across = cross(lobe.n, h);
    const float sine2 = min(dot(across, across), 1.0), width = lobe.alpha2 * (1.0 - sine2) + sine2;
    return lobe.alpha2 / (3.141592653589793 * width * width);
}

// Density and response at a unit direction; a half vector below the surface has neither.
vec2 density_and_response(Lobe lobe, vec3 l) {
    const float n_l = dot(lobe.n, l);
    if (LOBE == LOBE_DIFFUSE) return vec2(max(n_l, 0.0) * 0.3183098861837907);
    const vec3 sum = lobe.v + l;
    const float length2 = dot(sum, sum);
    if (!(length2 > 1e-12) || !(dot(sum, lobe.n) > 0.0)) return vec2(0.0);
    const float d = ggx(lobe, sum * inversesqrt(length2)) / (4.0 * lobe.n_v), visible = 1.0 + lobe.lambda_v;
    return vec2(d / visible, n_l > 0.0 ? d / (visible + smith_lambda(n_l, lobe.alpha2)) : 0.0);
}

// Response over density of a drawn direction.
float sample_weight(Lobe lobe, vec3 l) {
    const float n_l = dot(lobe.n, l);
    if (!(n_l > 0.0)) return 0.0;
    if (LOBE == LOBE_DIFFUSE) return 1.0;
    return (1.0 + lobe.lambda_v) / (1.0 + lobe.lambda_v + smith_lambda(n_l, lobe.alpha2));
}

// Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
vec3 draw_direction(Lobe lobe, vec2 u) {
    const mat3 basis = sun_frame(lobe.n);
    if (LOBE == LOBE_DIFFUSE) {
        const vec2 disc = polar_disc(u);
        return basis * vec3(disc, sqrt(max(1.0 - dot(disc, disc), 0.0)));
    }
    const float alpha = sqrt(lobe.alpha2);
    const vec3 v = lobe.v * basis, stretched = normalize(vec3(alpha * v.xy, max(v.z, 1e-4)));
    const float z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z, angle = 6.283185307179586 * u.x;
    const vec3 cap = vec3(sqrt(clamp(1.0 - z * z, 0.0, 1.0)) * vec2(cos(angle), sin(angle)), z) + stretched;
    const vec3 h = normalize(vec3(alpha * cap.xy, max(cap.z, 0.0)));
    return basis * reflect(-v, h);
}

// A direction above the surface. Visible normals also send rays into it; those are drawn anew, and after four tries (rough and
// at grazing view, under 1 in 100) turned up. `u` in 0..1; `turned`: that has happened.
vec3 sample_lobe(Lobe lobe, float roughness, vec2 u, out bool turned) {
    turned = false;
    if (is_mirror(roughness)) return reflect(-lobe.v, lobe.n);
    vec3 l = vec3(0.0);
    for (int attempt = 0; attempt < 4; ++attempt) {
        l = draw_direction(lobe, u);
        if (dot(lobe.n, l) > 1e-5) return normalize(l);
        u = fract(u + vec2(0.6180339887, 0.7548776662));
    }
    turned = true;
    return normalize(l + lobe.n * (1e-5 - 2.0 * min(dot(lobe.n, l), 0.0)));
}
