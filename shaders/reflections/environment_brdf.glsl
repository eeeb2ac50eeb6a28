// SPDX-License-Identifier: MIT
// What a metallic-roughness surface (glTF 2.0, appendix B) reflects of white surroundings: the other half of the split sum
// (Karis 2013) beside demodulated radiance. Light that leaves a rough mirror's facets only after further bounces comes back as
// more of the same lobe, 1 + f0 (1 / white - 1) of it (Turquin 2019, "Practical multiple scattering compensation for microfacet
// models"), and the diffuse part has what the specular one leaves: a white surface reflects all of it, whatever its roughness and
// whether it is a metal.
//
// Includer has common/bilinear.glsl and declares: uniform sampler2D environment_brdf (nodes/tables/environment_brdf.h).

const float DIELECTRIC_F0 = 0.04;  // glTF's: an index of refraction of 1.5

vec2 environment_brdf_texel(ivec2 at) { return texelFetch(environment_brdf, at, 0).xy; }
BILINEAR(vec2, environment_brdf_at, environment_brdf_texel)

// x: the share of white light that a mirror with a Fresnel term of 1 sends to the viewer at once; y: the part of it that is
// weighted by (1 - v.h)^5.
vec2 white_and_grazing(float n_v, float roughness) {
    const ivec2 size = textureSize(environment_brdf, 0);
    return environment_brdf_at(clamp(vec2(n_v, roughness), 0.0, 1.0) * vec2(size - 1) + 0.5, size);
}

vec3 further_bounces(vec3 f0, float white) { return 1.0 + f0 * (1.0 / white - 1.0); }

vec3 mirrored_share(vec3 f0, vec2 brdf) { return (f0 * (brdf.x - brdf.y) + brdf.y) * further_bounces(f0, brdf.x); }

vec3 schlick(vec3 f0, float cosine) {
    const float grazing = 1.0 - cosine, g2 = grazing * grazing;
    return f0 + (1.0 - f0) * (g2 * g2 * grazing);
}

struct Reflectance {
    vec3 specular, diffuse;  // of white surroundings, 0 to 1, together at most 1
};

Reflectance reflectance(vec3 base_color, float metallic, vec2 brdf) {
    const vec3 dielectric = mirrored_share(vec3(DIELECTRIC_F0), brdf);
    return Reflectance(mix(dielectric, mirrored_share(base_color, brdf), metallic), (1.0 - metallic) * base_color * (1.0 - dielectric));
}

// Of the specular lobe's response, in a direction whose half vector has this cosine with it.
vec3 fresnel(vec3 base_color, float metallic, float v_h, float white) {
    return mix(schlick(vec3(DIELECTRIC_F0), v_h) * further_bounces(vec3(DIELECTRIC_F0), white),
               schlick(base_color, v_h) * further_bounces(base_color, white), metallic);
}
