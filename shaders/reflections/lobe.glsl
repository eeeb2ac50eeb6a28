// SPDX-License-Identifier: MIT
// The two ways a surface mirrors light: the GGX lobe of its roughness, without its colour, and the diffuse one. What is kept
// of either is demodulated, the mean of incident radiance under the lobe: sum w L / sum w, 1 wherever L is.
//   density  q(l): of directions as draw_direction() draws them (GGX: visible normals, of which most that would mirror into the surface are
//   left out: Tokuyoshi and Eto 2024, "Bounded VNDF Sampling for the Smith-GGX BRDF");
//   response F(l): reflectance times cosine, but for colour and Fresnel: D G2 / (4 n.v), (n.l)+ / pi.
//
// Includer has common/sun_sample.glsl and declares: constant LOBE.

const float LEAST_ALPHA = 1e-4;  // a mirror below it: nothing near tells it apart from one

bool is_mirror(float roughness) { return LOBE == LOBE_SPECULAR && roughness * roughness < LEAST_ALPHA; }

struct Lobe {
    vec3 n, v;
    float alpha2, n_v;
    float root_v;  // smith_root() of n_v
    float bound;   // how far down normals are drawn: 1 for all that are visible
};

// 1 + 2 Lambda, Smith's for GGX, of a direction with this cosine, times the cosine.
float smith_root(float cosine, float alpha2) {
    const float c2 = cosine * cosine;
    return sqrt(c2 + alpha2 * max(1.0 - c2, 0.0));
}

// `n`, `v`: unit vectors, v towards the viewer.
Lobe make_lobe(vec3 n, vec3 v, float roughness) {
    const float alpha = max(roughness * roughness, LEAST_ALPHA), n_v = max(dot(n, v), 1e-4);
    if (LOBE == LOBE_DIFFUSE) return Lobe(n, v, alpha * alpha, n_v, 0.0, 1.0);
    const float alpha2 = min(alpha * alpha, 1.0), cosine2 = n_v * n_v, s = 1.0 + sqrt(max(1.0 - cosine2, 0.0)), s2 = s * s;
    return Lobe(n, v, alpha2, n_v, smith_root(n_v, alpha2), (1.0 - alpha2) * s2 / (s2 + alpha2 * cosine2));
}

// D / (2 q): for a bound of 1 twice n.v (1 + Lambda).
float drawn(Lobe lobe) { return lobe.n_v * lobe.bound + lobe.root_v; }

// Response over density of a direction at this cosine above the surface.
float weight_at(Lobe lobe, float n_l) {
    return drawn(lobe) * n_l / (lobe.root_v * n_l + smith_root(n_l, lobe.alpha2) * lobe.n_v);
}

// Density and response at a unit direction; below the surface there is neither, as a ray that is drawn there finds nothing.
vec2 density_and_response(Lobe lobe, vec3 l) {
    const float n_l = dot(lobe.n, l);
    if (LOBE == LOBE_DIFFUSE) return vec2(max(n_l, 0.0) * 0.3183098861837907);
    // GGX of the half vector, which is the sum but for its length. The sine from a cross product: 1 - cosine^2 has no digits left where
    // alpha is small.
    const vec3 sum = lobe.v + l, across = cross(lobe.n, sum);
    const float length2 = dot(sum, sum), across2 = dot(across, across);
    if (!(length2 > 1e-12) || !(n_l > 0.0)) return vec2(0.0);
    const float ratio = length2 / (lobe.alpha2 * max(length2 - across2, 0.0) + across2);
    const float density = lobe.alpha2 / (6.283185307179586 * drawn(lobe)) * ratio * ratio;
    return vec2(density, density * weight_at(lobe, n_l));
}

// Response over density of a drawn direction.
float sample_weight(Lobe lobe, vec3 l) {
    const float n_l = dot(lobe.n, l);
    if (!(n_l > 0.0)) return 0.0;
    return LOBE == LOBE_DIFFUSE ? 1.0 : weight_at(lobe, n_l);
}

// Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps": of a cap that ends at the bound.
vec3 draw_direction(Lobe lobe, vec2 u) {
    const mat3 basis = sun_frame(lobe.n);
    if (LOBE == LOBE_DIFFUSE) {
        const vec2 disc = polar_disc(u);
        return basis * vec3(disc, sqrt(max(1.0 - dot(disc, disc), 0.0)));
    }
    const float alpha = sqrt(lobe.alpha2);
    const vec3 v = lobe.v * basis, stretched = normalize(vec3(alpha * v.xy, max(v.z, 1e-4)));
    const float least = -lobe.bound * stretched.z, z = mix(1.0, least, u.y), angle = 6.283185307179586 * u.x;
    const vec3 cap = vec3(sqrt(clamp(1.0 - z * z, 0.0, 1.0)) * vec2(cos(angle), sin(angle)), z) + stretched;
    const vec3 h = normalize(vec3(alpha * cap.xy, max(cap.z, 0.0)));
    return basis * reflect(-v, h);
}

// Times R2's steps another sequence that fills the square evenly, also where only some of its numbers are asked for.
const float ANEW = 46.0;

// A direction above the surface. A few of those drawn go into it (rough and at grazing view). Those are drawn
// anew, by numbers that are anywhere for those that failed, and after four tries turned up. `u` in 0..1; `turned`: that has happened.
vec3 sample_lobe(Lobe lobe, float roughness, vec2 u, out bool turned) {
    turned = false;
    if (is_mirror(roughness)) return reflect(-lobe.v, lobe.n);
    vec3 l = vec3(0.0);
    for (int attempt = 0; attempt < 4; ++attempt) {
        l = draw_direction(lobe, u);
        if (dot(lobe.n, l) > 1e-5) return normalize(l);
        u = fract(ANEW * u);
    }
    turned = true;
    return normalize(l + lobe.n * (1e-5 - 2.0 * min(dot(lobe.n, l), 0.0)));
}
