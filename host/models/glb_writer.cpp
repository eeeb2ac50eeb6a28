// SPDX-License-Identifier: MIT
// glTF 2.0, section 4 "GLB file format": a JSON chunk and one binary chunk.
#include "host/models/glb_writer.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "host/images/image_file.h"

namespace penumbra {

namespace {

using Json = nlohmann::ordered_json;

constexpr int float_type = 5126, uint_type = 5125;          // accessor component types
constexpr int vertex_target = 34962, index_target = 34963;  // buffer view targets
constexpr uint32_t json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;

class Writer {
  public:
    std::vector<std::byte> write(const Model& model) {
        json_["asset"] = {{"version", "2.0"}, {"generator", "penumbra"}};
        json_["scene"] = 0;
        add_nodes(model);
        for (const Material& material : model.materials) add_material(material);
        for (const Texture& texture : model.textures) add_texture(texture);
        for (const Mesh& mesh : model.meshes) add_mesh(mesh);
        json_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
        return assemble();
    }

  private:
    void add_nodes(const Model& model) {
        Json roots = Json::array();
        json_["nodes"] = Json::array();
        for (size_t i = 0; i < model.nodes.size(); ++i) {
            const Node& node = model.nodes[i];
            Json out = Json::object();
            if (!node.name.empty()) out["name"] = node.name;
            if (node.mesh >= 0) out["mesh"] = node.mesh;
            if (node.matrix) {
                for (int c = 0; c < 4; ++c)
                    for (int r = 0; r < 4; ++r) out["matrix"].push_back((*node.matrix)[c][r]);
            } else {
                const glm::dvec3 &t = node.translation, &s = node.scale;
                const glm::dquat& q = node.rotation;
                if (t != glm::dvec3(0)) out["translation"] = {t.x, t.y, t.z};
                if (q != glm::dquat(1, 0, 0, 0)) out["rotation"] = {q.x, q.y, q.z, q.w};
                if (s != glm::dvec3(1)) out["scale"] = {s.x, s.y, s.z};
            }
            json_["nodes"].push_back(out);
            if (node.parent < 0) {
                roots.push_back(i);
            } else {
                json_["nodes"][static_cast<size_t>(node.parent)]["children"].push_back(i);
            }
        }
        json_["scenes"] = Json::array({{{"nodes", roots}}});
    }

    void add_material(const Material& material) {
        Json pbr = {{"baseColorFactor", material.base_color}};
        if (material.metallic == 0)
            pbr["metallicFactor"] = 0;
        else if (material.metallic != 1)
            pbr["metallicFactor"] = material.metallic;
        if (material.roughness != 1) pbr["roughnessFactor"] = material.roughness;
        if (material.texture >= 0) pbr["baseColorTexture"] = {{"index", material.texture}};
        if (material.metallic_roughness_texture >= 0)
            pbr["metallicRoughnessTexture"] = {{"index", material.metallic_roughness_texture}};
        Json out = {{"pbrMetallicRoughness", std::move(pbr)}, {"doubleSided", true}};
        if (material.alpha_cutoff) {
            out["alphaMode"] = "MASK";
            out["alphaCutoff"] = *material.alpha_cutoff;
        }
        if (material.alpha_blend) out["alphaMode"] = "BLEND";
        add_transmission(material, out);
        add_emission(material, out);
        json_["materials"].push_back(std::move(out));
    }

    // emissiveFactor ends at 1; what is brighter takes an extension.
    void add_emission(const Material& material, Json& out) {
        std::array<float, 3> factor = material.emissive;
        const float strength = std::max(1.0f, *std::ranges::max_element(factor));
        for (float& value : factor) value /= strength;
        if (factor != std::array<float, 3>{}) out["emissiveFactor"] = factor;
        if (material.emissive_texture >= 0) out["emissiveTexture"] = {{"index", material.emissive_texture}};
        if (strength == 1) return;
        out["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
        use_extension("KHR_materials_emissive_strength");
    }

    void add_transmission(const Material& material, Json& out) {
        if (material.transmission == 0) return;
        Json& extension = out["extensions"]["KHR_materials_transmission"];
        extension["transmissionFactor"] = material.transmission;
        if (material.transmission_texture >= 0)
            extension["transmissionTexture"] = {{"index", material.transmission_texture}};
        use_extension("KHR_materials_transmission");
    }

    void use_extension(const char* name) {
        if (!json_.contains("extensionsUsed")) json_["extensionsUsed"] = Json::array();
        Json& used = json_["extensionsUsed"];
        if (std::ranges::find(used, name) == used.end()) used.push_back(name);
    }

    void add_texture(const Texture& texture) {
        std::vector<std::byte> png = png_of_rgba(texture.width, texture.height, texture.rgba);
        const size_t bytes = png.size();
        png.resize((bytes + 3) / 4 * 4);  // what follows stays aligned
        json_["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}});
        binary_.insert(binary_.end(), png.begin(), png.end());
        for (const char* list : {"textures", "images"})  // a new key moves the others
            if (!json_.contains(list)) json_[list] = Json::array();
        json_["textures"].push_back({{"source", json_["images"].size()}});
        json_["images"].push_back(
            {{"bufferView", json_["bufferViews"].size() - 1}, {"mimeType", "image/png"}});
    }

    void add_mesh(const Mesh& mesh) {
        Json primitives = Json::array();
        for (const Part& part : mesh.parts) {
            if (part.positions.empty()) continue;  // an accessor may not be empty
            std::vector<glm::vec3> positions = part.positions;
            for (glm::vec3& p : positions) p = glm::vec3(glm::dvec3(p) + part.origin);
            glm::vec3 low = positions.front(), high = low;
            for (const glm::vec3& p : positions) {
                low = glm::min(low, p);
                high = glm::max(high, p);
            }
            const size_t position = add_accessor(std::as_bytes(std::span(positions)), vertex_target,
                                                 {{"componentType", float_type},
                                                  {"count", positions.size()},
                                                  {"type", "VEC3"},
                                                  {"min", {low.x, low.y, low.z}},
                                                  {"max", {high.x, high.y, high.z}}});
            const size_t index = add_accessor(
                std::as_bytes(std::span(part.indices)), index_target,
                {{"componentType", uint_type}, {"count", part.indices.size()}, {"type", "SCALAR"}});
            Json primitive = {{"attributes", {{"POSITION", position}}}, {"indices", index}};
            if (!part.uv.empty())
                primitive["attributes"]["TEXCOORD_0"] = add_accessor(
                    std::as_bytes(std::span(part.uv)), vertex_target,
                    {{"componentType", float_type}, {"count", part.uv.size()}, {"type", "VEC2"}});
            if (part.material >= 0) primitive["material"] = part.material;
            primitives.push_back(primitive);
        }
        json_["meshes"].push_back({{"primitives", primitives}});
    }

    size_t add_accessor(std::span<const std::byte> bytes, int target, Json accessor) {
        json_["bufferViews"].push_back({{"buffer", 0},
                                        {"byteOffset", binary_.size()},
                                        {"byteLength", bytes.size()},
                                        {"target", target}});
        binary_.insert(binary_.end(), bytes.begin(), bytes.end());  // both types keep 4-byte alignment
        accessor["bufferView"] = json_["bufferViews"].size() - 1;
        json_["accessors"].push_back(std::move(accessor));
        return json_["accessors"].size() - 1;
    }

    std::vector<std::byte> assemble() const {
        std::string text = json_.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<std::byte> out;
        const auto word = [&](size_t value) {
            const uint32_t w = static_cast<uint32_t>(value);
            const auto* bytes = reinterpret_cast<const std::byte*>(&w);
            out.insert(out.end(), bytes, bytes + 4);
        };
        word(0x46546C67);  // "glTF"
        word(2);
        word(12 + 8 + text.size() + 8 + binary_.size());
        word(text.size());
        word(json_chunk);
        const auto characters = std::as_bytes(std::span(text));
        out.insert(out.end(), characters.begin(), characters.end());
        word(binary_.size());
        word(binary_chunk);
        out.insert(out.end(), binary_.begin(), binary_.end());
        return out;
    }

    Json json_ = Json::object();
    std::vector<std::byte> binary_;
};

}  // namespace

std::vector<std::byte> to_glb(const Model& model) {
    return Writer().write(model);
}

}  // namespace penumbra
