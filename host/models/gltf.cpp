// SPDX-License-Identifier: MIT
// tinygltf parses; this file checks what it parsed and turns it into a Model. Reference: glTF 2.0
// specification.
#include "host/models/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <numeric>
#include <set>

#include "host/images/image_decode.h"
#include "host/images/input_limit.h"
#include "host/models/gltf_accessor.h"
#include "host/models/gltf_files.h"

namespace penumbra {

namespace {

// Extensions that a file may require without changing where its triangles are.
bool is_harmless(std::string_view extension) {
    return extension.starts_with("KHR_materials_") || extension == "KHR_lights_punctual" ||
           extension == "KHR_mesh_quantization";  // read_floats() takes every component type
}

class Loader {
  public:
    Loader(const GltfFiles& files, Model& model)
        : files_(files),
          file_(files.model),
          budget_(files.bytes),
          accessors_(file_, budget_),
          model_(model) {}

    void load() {
        for (const std::string& extension : file_.extensionsRequired) {
            if (!is_harmless(extension)) {
                throw GltfError(
                    fmt::format("the file requires the extension {}, which is not supported", extension));
            }
        }
        for (size_t image = 0; image < file_.images.size(); ++image) add_texture(image);
        for (const tinygltf::Material& material : file_.materials) add_material(material);
        for (const tinygltf::Mesh& mesh : file_.meshes) add_mesh(mesh);
        add_scene();
        if (model_.triangle_count() == 0) warn("there are no triangles");
        if (!file_.animations.empty()) warn("animations are ignored");
        if (model_.dropped_nonfinite)
            warn(fmt::format("{} triangles with non-finite or huge coordinates dropped",
                             model_.dropped_nonfinite));
        if (model_.dropped_degenerate)
            warn(fmt::format("{} degenerate triangles dropped", model_.dropped_degenerate));
    }

  private:
    void warn(const std::string& text) {
        if (warned_.insert(text).second) model_.warnings.push_back(text);
    }

    // An image that cannot be decoded stays empty, and the materials that use it say so.
    void add_texture(size_t image) {
        Texture& texture = model_.textures.emplace_back();
        std::span<const std::byte> bytes;
        try {
            bytes = encoded_image(files_, image);
        } catch (const GltfError& error) {
            throw GltfError(fmt::format("image {}: {}", image, error.what()));
        }
        std::optional<RgbaImage> decoded = decode_image(bytes, image_bytes_left_);
        if (!decoded) return;
        image_bytes_left_ -= decoded->rgba.size();
        texture = {decoded->width, decoded->height, std::move(decoded->rgba)};
    }

    void add_material(const tinygltf::Material& material) {
        Material& out = model_.materials.emplace_back();
        const auto& pbr = material.pbrMetallicRoughness;
        for (size_t i = 0; i < std::min<size_t>(4, pbr.baseColorFactor.size()); ++i) {
            const double value = pbr.baseColorFactor[i];
            if (!(value >= 0 && value <= 1))
                throw GltfError(
                    fmt::format("material \"{}\": base colour {} is not in 0..1", material.name, value));
            out.base_color[i] = static_cast<float>(value);
        }
        read_alpha_mode(material, out);
        read_surface(material, out);
        if (pbr.baseColorTexture.index < 0) return;
        const tinygltf::Texture& texture = element(file_.textures, pbr.baseColorTexture.index, "texture");
        if (pbr.baseColorTexture.texCoord != 0 ||
            pbr.baseColorTexture.extensions.count("KHR_texture_transform")) {
            warn(
                "base colour textures with transforms or other than TEXCOORD_0 are ignored: the factor is "
                "used");
            return;
        }
        if (texture.source < 0) {
            warn("textures without a core image are ignored: the factor is used");
            return;
        }
        element(file_.images, texture.source, "image");
        if (model_.textures[static_cast<size_t>(texture.source)].width == 0) {
            warn(fmt::format("image {} cannot be read: the colour factor is used", texture.source));
            return;
        }
        out.texture = texture.source;
        if (!out.alpha_cutoff || texture.sampler < 0) return;
        const tinygltf::Sampler& sampler = element(file_.samplers, texture.sampler, "sampler");
        if (sampler.wrapS != TINYGLTF_TEXTURE_WRAP_REPEAT || sampler.wrapT != TINYGLTF_TEXTURE_WRAP_REPEAT)
            warn("textures of alpha-tested materials are repeated, whatever their samplers say");
    }

    // Sections 3.9.2 and 3.9.3, and KHR_materials_emissive_strength: what reflections see of a surface.
    void read_surface(const tinygltf::Material& material, Material& out) {
        const auto& pbr = material.pbrMetallicRoughness;
        const auto factor = [&](const char* what, double value, double high) {
            if (!(value >= 0 && value <= high))
                throw GltfError(
                    fmt::format("material \"{}\": {} {} is not in 0..{}", material.name, what, value, high));
            return static_cast<float>(value);
        };
        out.metallic = factor("metallicFactor", pbr.metallicFactor, 1);
        out.roughness = factor("roughnessFactor", pbr.roughnessFactor, 1);
        double strength = 1;
        if (const auto found = material.extensions.find("KHR_materials_emissive_strength");
            found != material.extensions.end() && found->second.Has("emissiveStrength"))
            strength =
                factor("emissiveStrength", found->second.Get("emissiveStrength").GetNumberAsDouble(), 1e6);
        for (size_t i = 0; i < std::min<size_t>(3, material.emissiveFactor.size()); ++i)
            out.emissive[i] =
                factor("emissiveFactor", material.emissiveFactor[i], 1) * static_cast<float>(strength);
        out.metallic_roughness_texture =
            surface_image("metallic-roughness", pbr.metallicRoughnessTexture.index,
                          pbr.metallicRoughnessTexture.texCoord, pbr.metallicRoughnessTexture.extensions);
        out.emissive_texture =
            surface_image("emissive", material.emissiveTexture.index, material.emissiveTexture.texCoord,
                          material.emissiveTexture.extensions);
    }

    // The image of a texture of the given kind, or -1 with a warning where it cannot be used.
    int surface_image(const char* kind, int index, int set, const tinygltf::ExtensionMap& extensions) {
        if (index < 0) return -1;
        const tinygltf::Texture& texture = element(file_.textures, index, "texture");
        if (set != 0 || extensions.count("KHR_texture_transform") || texture.source < 0) {
            warn(
                fmt::format("{} textures with transforms, without a core image or other than TEXCOORD_0 are "
                            "ignored: the factor is used",
                            kind));
            return -1;
        }
        element(file_.images, texture.source, "image");
        if (model_.textures[static_cast<size_t>(texture.source)].width > 0) return texture.source;
        warn(fmt::format("image {} cannot be read: the {} factor is used", texture.source, kind));
        return -1;
    }

    // Section 3.9.4. What is half transparent has no place in a shadow of ray hits.
    void read_alpha_mode(const tinygltf::Material& material, Material& out) {
        if (material.alphaMode == "MASK") {
            if (!(material.alphaCutoff >= 0 && std::isfinite(material.alphaCutoff)))
                throw GltfError(fmt::format("material \"{}\": alphaCutoff {} is not a number from 0 on",
                                            material.name, material.alphaCutoff));
            out.alpha_cutoff = material.alphaCutoff;
        } else if (material.alphaMode == "BLEND") {
            warn(
                fmt::format("material \"{}\" has alphaMode BLEND: it is drawn and casts shadows as if opaque",
                            material.name));
        } else if (material.alphaMode != "OPAQUE") {
            throw GltfError(fmt::format("material \"{}\": there is no alphaMode \"{}\"", material.name,
                                        material.alphaMode));
        }
    }

    void add_mesh(const tinygltf::Mesh& mesh) {
        Mesh& out = model_.meshes.emplace_back();
        for (size_t i = 0; i < mesh.primitives.size(); ++i) {
            try {
                add_primitive(out, mesh.primitives[i]);
            } catch (const GltfError& error) {
                throw GltfError(fmt::format("mesh \"{}\", primitive {}: {}", mesh.name, i, error.what()));
            }
        }
    }

    void add_primitive(Mesh& mesh, const tinygltf::Primitive& primitive) {
        if (primitive.extensions.count("KHR_draco_mesh_compression")) {
            throw GltfError("KHR_draco_mesh_compression is not supported");
        }
        const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
        if (mode < TINYGLTF_MODE_TRIANGLES) {
            warn("points and lines are ignored: they cast no shadow");
            return;
        }
        const auto position = primitive.attributes.find("POSITION");
        if (position == primitive.attributes.end()) {
            warn("a primitive without positions is ignored");
            return;
        }
        if (!primitive.targets.empty()) warn("morph targets are ignored");
        if (primitive.attributes.count("COLOR_0")) warn("vertex colours are ignored");
        if (primitive.material >= 0) element(file_.materials, primitive.material, "material");

        const std::vector<float>& numbers = accessors_.floats(position->second, 3);
        const size_t count = numbers.size() / 3;
        std::vector<uint32_t> corners, used;
        if (primitive.indices >= 0) {
            corners = accessors_.indices(primitive.indices);
            for (const uint32_t corner : corners)
                if (corner >= count)
                    throw GltfError(fmt::format("index {} is out of range ({} vertices)", corner, count));
            if (corners.size() < count) used = keep_used(corners);
        } else {
            budget_.spend(count * sizeof(uint32_t));
            corners.resize(count);
            std::iota(corners.begin(), corners.end(), 0u);
        }
        const auto vertex = [&](size_t i) { return used.empty() ? i : used[i]; };
        budget_.spend((used.empty() ? count : used.size()) * (sizeof(glm::vec3) + sizeof(glm::vec2)) +
                      corners.size() * 3 * sizeof(uint32_t));
        std::vector<glm::vec3> positions(used.empty() ? count : used.size());
        for (size_t i = 0; i < positions.size(); ++i) positions[i] = glm::make_vec3(&numbers[3 * vertex(i)]);

        std::vector<glm::vec2> uv;
        const auto coordinates = primitive.attributes.find("TEXCOORD_0");
        if (coordinates != primitive.attributes.end()) {
            const std::vector<float>& values = accessors_.floats(coordinates->second, 2);
            if (values.size() / 2 != count) throw GltfError("TEXCOORD_0 and POSITION differ in count");
            uv.resize(positions.size());
            for (size_t i = 0; i < uv.size(); ++i) {
                uv[i] = glm::make_vec2(&values[2 * vertex(i)]);
                if (std::isfinite(uv[i].x) && std::isfinite(uv[i].y)) continue;
                warn("texture coordinates that are not finite are taken as 0");
                uv[i] = glm::vec2(0);
            }
        }

        add_part(model_, mesh, std::move(positions), std::move(uv), to_triangles(corners, mode),
                 primitive.material);
    }

    // Of vertices that other primitives have, too, those of these corners, which from then on count among
    // them alone: many primitives of a file may share one accessor.
    static std::vector<uint32_t> keep_used(std::vector<uint32_t>& corners) {
        std::vector<uint32_t> used = corners;
        std::ranges::sort(used);
        used.erase(std::unique(used.begin(), used.end()), used.end());
        for (uint32_t& corner : corners)
            corner = static_cast<uint32_t>(std::ranges::lower_bound(used, corner) - used.begin());
        return used;
    }

    // Section 3.7.2.1: strips and fans to lists, with the winding kept.
    static std::vector<uint32_t> to_triangles(const std::vector<uint32_t>& corners, int mode) {
        std::vector<uint32_t> out;
        if (mode == TINYGLTF_MODE_TRIANGLES) {
            out = corners;
            out.resize(corners.size() - corners.size() % 3);
            return out;
        }
        for (size_t i = 2; i < corners.size(); ++i) {
            if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
                out.insert(out.end(), {corners[i - 1], corners[i], corners[0]});
            } else {
                const size_t odd = i & 1;
                out.insert(out.end(), {corners[i - 2], corners[i - 1 + odd], corners[i - odd]});
            }
        }
        return out;
    }

    void add_scene() {
        if (file_.nodes.empty()) return;
        if (file_.scenes.empty()) {
            // Legal, and then every root is shown.
            std::vector<bool> is_child(file_.nodes.size(), false);
            for (const tinygltf::Node& node : file_.nodes)
                for (const int child : node.children) {
                    element(file_.nodes, child, "node");
                    is_child[static_cast<size_t>(child)] = true;
                }
            for (size_t i = 0; i < is_child.size(); ++i)
                if (!is_child[i]) add_node(static_cast<int>(i), -1);
            return;
        }
        const int scene = file_.defaultScene < 0 ? 0 : file_.defaultScene;
        for (const int root : element(file_.scenes, scene, "scene").nodes) add_node(root, -1);
    }

    // Depth first with a stack of our own: a chain of 1e5 nodes must not exhaust the program's.
    void add_node(int root, int root_parent) {
        std::vector<std::pair<int, int>> pending{{root, root_parent}};  // node, parent in the model
        while (!pending.empty()) {
            const auto [index, parent] = pending.back();
            pending.pop_back();
            const tinygltf::Node& node = element(file_.nodes, index, "node");
            if (!visited_.insert(index).second) {
                throw GltfError(fmt::format("node {} is reached twice: nodes must form trees", index));
            }
            Node& out = model_.nodes.emplace_back();
            out.name = node.name;
            out.parent = parent;
            out.mesh = node.mesh;
            if (node.mesh >= 0) element(file_.meshes, node.mesh, "mesh");
            if (node.skin >= 0) warn("skins are ignored: meshes are shown in their rest pose");
            if (node.extensions.count("EXT_mesh_gpu_instancing")) warn("EXT_mesh_gpu_instancing is ignored");
            read_transform(node, out);
            const int self = static_cast<int>(model_.nodes.size()) - 1;
            const std::vector<int> last_first(node.children.rbegin(), node.children.rend());
            for (const int child : last_first) pending.emplace_back(child, self);
        }
    }

    static void read_transform(const tinygltf::Node& node, Node& out) {
        const auto checked = [&](const std::vector<double>& values, size_t count) {
            if (values.size() != count ||
                !std::ranges::all_of(values, [](double v) { return std::isfinite(v); })) {
                throw GltfError(fmt::format("node \"{}\" has a transform that is not {} finite numbers",
                                            node.name, count));
            }
            return values.data();
        };
        if (!node.matrix.empty()) out.matrix = glm::make_mat4(checked(node.matrix, 16));
        if (!node.translation.empty()) out.translation = glm::make_vec3(checked(node.translation, 3));
        if (!node.scale.empty()) out.scale = glm::make_vec3(checked(node.scale, 3));
        if (!node.rotation.empty()) {
            const double* q = checked(node.rotation, 4);  // x, y, z, w
            out.rotation = glm::dquat(q[3], q[0], q[1], q[2]);
            const double length = glm::length(out.rotation);
            if (!(length > 1e-6)) throw GltfError(fmt::format("node \"{}\" has a zero rotation", node.name));
            out.rotation /= length;
        }
    }

    const GltfFiles& files_;
    const tinygltf::Model& file_;
    ReadBudget budget_;
    AccessorReader accessors_;
    uint64_t image_bytes_left_ = input_limit();
    Model& model_;
    std::set<std::string> warned_;
    std::set<int> visited_;
};

}  // namespace

std::optional<Model> load_gltf(const std::filesystem::path& path, Diagnostics& diagnostics) {
    // Malformed JSON and absurd sizes reach us as exceptions of the JSON library and of the allocator.
    try {
        const std::optional<GltfFiles> files = read_gltf_files(path, diagnostics);
        if (!files) return std::nullopt;
        Model model;
        if (!files->warnings.empty()) model.warnings.push_back(files->warnings);
        Loader(*files, model).load();
        return model;
    } catch (const std::exception& error) {
        diagnostics.add({path.string(), 0, 0}, "", error.what());
        return std::nullopt;
    }
}

}  // namespace penumbra
