// SPDX-License-Identifier: MIT
// Published form: which pixels get a reflection ray, and which tiles the denoiser looks at. FidelityFX classifier, from its
// documentation, without its split between screen-space and hardware rays: there is one tracer here. Quads are found through
// shared memory, where the published form assumes the lanes of a subgroup of 32 to be them.
//
// A word of the list: x (15 bits) | y (14) << 15 | copies << 29. A ray's copies go to the other pixels of its quad: bit 0 beside
// it, 1 below or above, 2 across. Neither order of a list may show in the image.
#include "node.glsl"
#include "common/camera.glsl"
#include "common/guide_normal.glsl"
#include "common/finite.glsl"
#include "reflections/environment.glsl"
#include "reflections/glossy.glsl"

const uint COPY_BESIDE = 1u, COPY_BELOW = 2u, COPY_ACROSS = 4u;

shared uint traces[64];  // 1: a ray of its own, 2: glossy, 4: wants more than the base rays
shared uint ray_count, first_ray;

bool is_base(ivec2 p) {
    if (SAMPLES_PER_QUAD == 4u) return true;
    return SAMPLES_PER_QUAD == 2u ? (p.x & 1) == (p.y & 1) : ((p.x | p.y) & 1) == 0;
}

// Which lane of the group traces for a pixel that does not.
uint base_lane(uint lane, ivec2 p) {
    if (SAMPLES_PER_QUAD == 2u) return lane ^ 1u;
    return lane ^ uint(p.x & 1) ^ uint(p.y & 1) << 3;
}

// Published defect: velocity is subtracted here and added in the denoiser. Where nothing moves they agree.
bool converged(ivec2 p) {
    if (!HAS_VARIANCE_PREV || (frame.flags & FRAME_RESET) != 0u) return false;
    const vec2 motion_here = HAS_MOTION ? texelFetch(motion, p, 0).xy : vec2(0.0);
    const Reprojection past = reproject(p, -motion_here);
    return past.on_screen && texelFetch(variance_prev, previous_texel(past.uv), 0).x < params.variance_threshold;
}

vec3 fill(ivec2 p, bool surface) {
    if (!surface) return vec3(0.0);
    const vec3 n = unit_or_zero(decode_normal(imageLoad(guide_normal, p)));
    return storable(environment_radiance(reflect(-to_viewer(p), n)));
}

void main() {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 p = ivec2(gl_WorkGroupID.xy) * 8 + ivec2(lane & 7u, lane >> 3);
    const bool inside = all(lessThan(p, ivec2(frame.size)));
    const bool surface = inside && imageLoad(view_depth, p).x > 0.0;
    const float roughness = surface ? published_roughness(texelFetch(material, p, 0).y) : 1.0;
    const bool glossy = surface && is_glossy(roughness);
    // published: rays only where |view-space n.z| is no more than 1, which is everywhere
    const bool wants = glossy && (is_base(p) || !converged(p));
    if (lane == 0u) ray_count = 0u;
    traces[lane] = (wants ? 1u : 0u) | (glossy ? 2u : 0u);
    barrier();
    // A quad whose base pixel is not glossy has no ray to copy: its pixels trace their own (the published form copies what is there).
    const bool copies = glossy && !wants && (traces[base_lane(lane, p)] & 1u) != 0u;
    const bool rays = glossy && !copies;
    barrier();
    traces[lane] = (rays ? 1u : 0u) | (copies ? 2u : 0u);
    barrier();
    uint flags = 0u;
    if (rays && is_base(p)) {
        const bool asks_beside = traces[lane ^ 1u] == 2u, asks_below = traces[lane ^ 8u] == 2u, asks_across = traces[lane ^ 9u] == 2u;
        flags = (asks_beside ? COPY_BESIDE : 0u);
        if (SAMPLES_PER_QUAD != 2u) flags |= (asks_below ? COPY_BELOW : 0u) | (asks_across ? COPY_ACROSS : 0u);
    }
    uint place = 0u;
    if (rays) place = atomicAdd(ray_count, 1u);
    barrier();
    if (lane == 0u && ray_count != 0u) {
        first_ray = atomicAdd(counts[0], ray_count);
        denoiser_tiles[atomicAdd(counts[1], 1u)] = uint(p.x) | uint(p.y) << 16;
    }
    barrier();
    if (rays) ray_list[first_ray + place] = uint(p.x) | uint(p.y) << 15 | flags << 29;
    if (!inside) return;
    const vec4 untraced = vec4(glossy ? vec3(0.0) : fill(p, surface), 0.0);
    store_radiance_fill(p, untraced);
    store_specular_fill(p, untraced);
    store_extracted_roughness(p, vec4(roughness));
    count_rays(lane == 0u ? ray_count : 0u);
}
