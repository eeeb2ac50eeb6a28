#version 460
#extension GL_GOOGLE_include_directive : require
// SPDX-License-Identifier: MIT
// Answers a list of rays with shaders/common/bvh.glsl: tests/bvh_gpu_test.cpp compares them, tests/bvh_bench.cpp times them. With
// LOADED from storage texel buffers. With TOGETHER the lanes of a subgroup, eight of them, walk together.
#ifdef TOGETHER
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_EXT_control_flow_attributes : require
const uint LANES_IN_STEP = 8u;
const bool HAS_SCENE_LOADED_NODES = true;
#define CLASS_CPU 1
#define SEVERAL_RAYS 1
#define BACKEND 0
#define BACKEND_RAY_QUERY 1
#endif
layout(local_size_x = 64) in;
#ifdef LOADED
layout(rgba32ui, set = 0, binding = 0) uniform readonly uimageBuffer scene_nodes;
layout(rgba32ui, set = 0, binding = 1) uniform readonly uimageBuffer scene_leaves;
#else
layout(set = 0, binding = 0) uniform usamplerBuffer scene_nodes;
layout(set = 0, binding = 1) uniform usamplerBuffer scene_leaves;
#endif
struct Ray {
    vec4 origin_t_min, direction_t_max;
};
layout(std430, set = 0, binding = 2) readonly buffer Rays { Ray rays[]; };
layout(std430, set = 0, binding = 3) writeonly buffer Answers { uint answers[]; };
layout(push_constant) uniform Push { uint count; };

#define NO_SCENE_ALPHA
#ifdef LOADED  // in place of scene_words.glsl
#define SCENE_WORDS_GLSL
uvec4 scene_node_texel(int texel) { return imageLoad(scene_nodes, texel); }
uvec4 scene_leaf_texel(int texel) { return imageLoad(scene_leaves, texel); }
#endif
#define NO_SCENE_WORDS
#ifdef TOGETHER
#include "../shaders/visibility/rays_together.glsl"
#else
#include "../shaders/common/bvh.glsl"
#endif

void main() {
    const uint i = gl_GlobalInvocationID.x;
    const bool own = i < count;
    const Ray ray = rays[own ? i : 0u];
#ifdef TOGETHER
    float unread = 0.0;
    const bool met = occluded_beside(ray.origin_t_min.xyz, 0.0, ray.direction_t_max.xyz, ray.origin_t_min.w, ray.direction_t_max.w, own, unread);
#else
    const bool met = own && occluded(ray.origin_t_min.xyz, ray.direction_t_max.xyz, ray.origin_t_min.w, ray.direction_t_max.w);
#endif
    if (own) answers[i] = uint(met);
}
