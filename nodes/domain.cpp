// SPDX-License-Identifier: MIT
#include "penumbra/shadow_nodes.h"
#include "shaders/common/blocks.h"

namespace penumbra {
namespace {

// What rays are traced against: penumbra's own tree, traversed in compute, or the driver's acceleration
// structure. Ray queries of a CPU device are two orders of magnitude slower than the tree.
Bundle scene() {
    using enum Bundle::Texels;
    Bundle scene{.kind = "scene", .doc = "what rays are traced against", .param = "backend"};
    scene.backends = {{.name = "ray_query",
                       .feature = "ray_query",
                       .gpu_only = true,
                       .glsl = "#extension GL_EXT_ray_query : require\n"},
                      {.name = "bvh", .fact = "tree"}};
    scene.parts = {
        {.name = "nodes",
         .kind = PortKind::texels,
         .format = Format::rgba32ui,
         .backend = "bvh",
         .on = fetched},
        {.name = "leaves",
         .kind = PortKind::texels,
         .format = Format::rgba32ui,
         .backend = "bvh",
         .on = fetched},
        {.name = "tlas", .kind = PortKind::structure, .backend = "ray_query"},
        {.name = "alpha_uv",
         .kind = PortKind::texels,
         .format = Format::rgba32ui,
         .fact = "alpha",
         .on = fetched},
        {.name = "alpha_map",
         .kind = PortKind::texels,
         .format = Format::r32ui,
         .fact = "alpha",
         .on = fetched},
        {.name = "", .kind = PortKind::block, .element = "Scene"},
        {.name = "loaded_nodes",
         .slot = "nodes",
         .kind = PortKind::texels,
         .format = Format::rgba32ui,
         .backend = "bvh",
         .on = loaded},
        {.name = "loaded_leaves",
         .slot = "leaves",
         .kind = PortKind::texels,
         .format = Format::rgba32ui,
         .backend = "bvh",
         .on = loaded},
        {.name = "loaded_alpha_uv",
         .slot = "alpha_uv",
         .kind = PortKind::texels,
         .format = Format::rgba32ui,
         .fact = "alpha",
         .on = loaded},
        {.name = "loaded_alpha_map",
         .slot = "alpha_map",
         .kind = PortKind::texels,
         .format = Format::r32ui,
         .fact = "alpha",
         .on = loaded},
        // The same words where a scene of a few ten thousand triangles would not fit a texel buffer.
        {.name = "nodes_words", .kind = PortKind::buffer, .element = "uvec4", .backend = "bvh", .on = few},
        {.name = "leaves_words", .kind = PortKind::buffer, .element = "uvec4", .backend = "bvh", .on = few},
        {.name = "alpha_uv_words", .kind = PortKind::buffer, .element = "uvec4", .fact = "alpha", .on = few},
        {.name = "alpha_map_words", .kind = PortKind::buffer, .element = "u32", .fact = "alpha", .on = few},
    };
    return scene;
}

}  // namespace

std::shared_ptr<const Domain> shadow_domain() {
    static const auto domain = std::make_shared<const Domain>(Domain{
        .facts = {{"sun_up", "some part of the sun is above the horizon at some time; a near light has none"},
                  {"sun_disc", "the sun, or the light that is near, is no point"},
                  {"casters", "something can cast a shadow"},
                  {"alpha", "some triangle's texture has holes"},
                  {"translucent", "some triangle lets a part of the light through"},
                  {"moves", "the camera or an object moves"},
                  {"casters_move", "something that casts a shadow moves or changes its shape"},
                  {"sun_moves", "the sun moves, or the light that is near"},
                  {"rough", "some surface's lobe is wider than a mirror's: roughness .01 or more"},
                  {"glossy", "some surface shows an image of what it mirrors: roughness below .5"},
                  {"tree", "the host brings penumbra's own tree of the triangles; else ray queries alone"}},
        .features = {"ray_query", "storage8"},
        .structs = {{"Sun", sizeof(blocks::Sun)},
                    {"Light", sizeof(blocks::Light)},
                    {"Scene", sizeof(blocks::Scene)},
                    {"Cascades", sizeof(blocks::Cascades)},
                    {"MovedBoxes", sizeof(blocks::MovedBoxes)}},
        .structs_file = "common/blocks.h",
        .bundles = {scene()},
        .capabilities = {{4472,  // RayQueryKHR
                          {.extensions = {"VK_KHR_ray_query", "VK_KHR_acceleration_structure",
                                          "VK_KHR_deferred_host_operations"},
                           .features = {"rayQuery", "accelerationStructure", "bufferDeviceAddress"}}}}});
    return domain;
}

}  // namespace penumbra
