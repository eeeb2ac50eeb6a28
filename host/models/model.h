// SPDX-License-Identifier: MIT
// A scene as the host holds it: a tree of nodes with transforms in double precision, triangle meshes, base
// colours. Positions are fp32 about an origin per mesh part, chosen so that moving there loses nothing (see
// Part::origin).
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct Texture {
    uint32_t width = 0, height = 0;  // 0: the image could not be read
    std::vector<uint8_t> rgba;       // sRGB-encoded colour, rows from the top
};

struct Material {
    std::array<float, 4> base_color{1, 1, 1, 1};  // linear
    int texture = -1;                             // index into Model::textures
    // Set: alpha-tested (glTF's alphaMode MASK). Texels whose alpha times base_color[3] is below it are not
    // there.
    std::optional<double> alpha_cutoff = std::nullopt;
    // Of the metallic-roughness model (glTF 2.0, section 3.9.2): factors of the texture's blue and green,
    // which are linear. The roughness is the perceptual one, its square is the width of the GGX lobe.
    float metallic = 0, roughness = 1;
    int metallic_roughness_texture = -1;
    std::array<float, 3> emissive{0, 0, 0};  // linear radiance; a factor of the texture
    int emissive_texture = -1;
    // What lets light through (host/models/translucency.h): glTF's alphaMode BLEND, and
    // KHR_materials_transmission, a factor of the texture's red.
    bool alpha_blend = false;
    float transmission = 0;
    int transmission_texture = -1;
};

// Triangles that share a material.
struct Part {
    // Added in double precision. Per axis 0, or, where every coordinate lies within a quarter of the box's
    // centre, a float near that centre: such a difference of floats is exact (Sterbenz), so far-away meshes
    // keep all they have.
    glm::dvec3 origin{0};
    std::vector<glm::vec3> positions;
    std::vector<glm::vec2> uv;  // as many as positions, or none
    std::vector<uint32_t> indices;
    int material = -1;  // -1: white
    // The viewer sees the side alone from which its corners run counter-clockwise. Shadows and reflections
    // know both sides.
    bool single_sided = false;
    std::vector<std::array<uint8_t, 4>> colors =
        {};  // linear, times the material's; as many as positions, or none
    // What moves its vertices (host/scene/pose.h): per vertex four joints of the node's skin, as indices
    // into Skin::joints, with weights whose sum is 1; and offsets of each morph target. As many as positions,
    // or none.
    std::vector<std::array<uint16_t, 4>> joints = {};
    std::vector<glm::vec4> weights = {};
    std::vector<std::vector<glm::vec3>> targets = {};

    bool deforms() const { return !joints.empty() || !targets.empty(); }
};

struct Mesh {
    std::vector<Part> parts;
};

// local = translate * rotate * scale, or the matrix where the file gives one.
struct Node {
    std::string name;
    int parent = -1;  // always a smaller index than the node's own
    int mesh = -1;
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
    std::optional<glm::dmat4> matrix;
    int skin = -1;  // its mesh then stands where the joints put it, whatever its own transform
    std::vector<double> weights{};  // of the mesh's morph targets; fewer than these: 0
    int weights_of = -1;            // the node that has them instead, of an instance
};

struct Skin {
    std::vector<int> joints;               // nodes
    std::vector<glm::dmat4> inverse_bind;  // as many
};

// glTF 2.0, appendix C.
struct AnimationChannel {
    enum class Path { translation, rotation, scale, weights };
    enum class Interpolation { step, linear, cubic };
    int node = -1;
    Path path = Path::translation;
    Interpolation interpolation = Interpolation::linear;
    std::vector<float> times;   // seconds, rising
    std::vector<float> values;  // per time as many numbers as the path has (rotation: x, y, z, w); cubic:
                                // three times as many
};

struct Animation {
    std::string name;
    double duration_s = 0;  // the last key of all
    std::vector<AnimationChannel> channels;
};

// A perspective camera that looks along -z of its node.
struct ModelCamera {
    int node = -1;
    double vertical_fov_deg = 60, near = 0.05;
};

// A point or a spot of KHR_lights_punctual, which shines along -z of its node.
struct ModelLight {
    int node = -1;
    std::string name;  // its own, or its node's; no two of a model's are the same
    bool spot = false;
    double radius = 0;                     // metres; of "extras": { "radius": .. }
    double intensity = 1;                  // candelas
    glm::dvec3 color{1};                   // linear
    double range = 0;                      // metres; 0: no end
    double inner_deg = 0, outer_deg = 45;  // of a spot's cone, from its axis
};

struct Model {
    std::vector<Node> nodes;  // those of the file's scene, parents first
    std::vector<Mesh> meshes;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Skin> skins = {};
    std::vector<Animation> animations = {};
    std::vector<ModelCamera> cameras = {};
    std::vector<int> suns = {};  // nodes of directional lights that are on, which shine along their -z
    std::vector<ModelLight> lights = {};
    std::vector<std::string> warnings = {};
    uint32_t dropped_degenerate = 0;  // triangles of zero area or with a repeated vertex
    uint32_t dropped_nonfinite = 0;   // triangles with NaN, infinite or huge (over 1e18) coordinates

    size_t triangle_count() const;  // each mesh once
};

// Texels of alphaMode BLEND whose alpha times base_color[3] is this or more are opaque: exporters choose
// BLEND for whole models of which a few texels are not quite.
inline constexpr double opaque_blend_alpha = 250 / 255.0;

// The smallest 8-bit alpha of a texture that passes the material's test, or that is opaque under BLEND: 0
// where all is opaque, 256 where nothing is. The one place where alpha meets the cutoff: at the cutoff is
// there (glTF 2.0, section 3.9.4).
uint32_t least_opaque_alpha(const Material& material);

// Whether the material's test removes anything at all of its texture; -1, no material, is opaque.
bool is_alpha_tested(const Model& model, int material);

// Appends a part after dropping bad triangles and choosing its origin. `part.indices` has three per triangle.
// Parts that deform keep triangles without area, which may get one, and the origin that their joints refer
// to.
void add_part(Model& model, Mesh& mesh, Part part);
void add_part(Model& model, Mesh& mesh, std::vector<glm::vec3> positions, std::vector<glm::vec2> uv,
              std::vector<uint32_t> indices, int material);

}  // namespace penumbra
