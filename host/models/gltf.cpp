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
#include <set>
#include <span>
#include <utility>

#include "host/images/image_decode.h"
#include "host/images/input_limit.h"
#include "host/models/gltf_accessor.h"
#include "host/models/gltf_extension.h"
#include "host/models/gltf_files.h"
#include "host/models/gltf_lights.h"
#include "host/models/gltf_meshopt.h"
#include "host/models/gltf_motion.h"
#include "host/models/gltf_primitive.h"
#include "host/models/translucency.h"

namespace penumbra {

namespace {

// Extensions that a file may require: those that are read, and those that do not change where its triangles
// are.
bool is_harmless(std::string_view extension) {
    constexpr std::string_view known[] = {
        "KHR_lights_punctual",        "KHR_mesh_quantization",   "KHR_texture_transform",
        "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
        "KHR_texture_basisu",         "EXT_texture_webp",        "EXT_texture_avif",
        "MSFT_texture_dds",           "KHR_animation_pointer",   "KHR_xmp_json_ld",
        "KHR_node_visibility"};
    return extension.starts_with("KHR_materials_") || std::ranges::find(known, extension) != std::end(known);
}

// Extensions that change a picture in ways that are not drawn, and what is seen instead.
constexpr std::pair<const char*, const char*> undrawn[] = {
    {"KHR_materials_unlit", "is drawn lit"},
    {"KHR_materials_volume", "is a thin wall"},
    {"KHR_materials_pbrSpecularGlossiness", "is drawn without its specular colour"},
    {"KHR_materials_variants", "is drawn in its first variant"},
    {"KHR_animation_pointer", "is not played"}};

constexpr const char *transmission = "KHR_materials_transmission",
                     *specular_glossiness = "KHR_materials_pbrSpecularGlossiness",
                     *node_visibility = "KHR_node_visibility";

// KHR_node_visibility: neither the node nor what hangs on it.
bool is_hidden(const tinygltf::Node& node) {
    const auto found = node.extensions.find(node_visibility);
    if (found == node.extensions.end() || !found->second.IsObject() || !found->second.Has("visible"))
        return false;
    const tinygltf::Value& visible = found->second.Get("visible");
    if (!visible.IsBool()) throw GltfError(fmt::format("{}: \"visible\" is no boolean", node_visibility));
    return !visible.Get<bool>();
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
        for (const auto& [extension, what] : undrawn)
            if (std::ranges::find(file_.extensionsUsed, extension) != file_.extensionsUsed.end())
                warn(fmt::format("what needs {} {}", extension, what));
        for (size_t image = 0; image < file_.images.size(); ++image) add_texture(image);
        for (const tinygltf::Material& material : file_.materials) {
            add_material(in_core_terms(material));
            count_transmittance(material.name, model_.materials.back());
        }
        for (const auto& [what, beyond] : beyond_)
            warn(beyond.second.size() == 1 ? beyond.first
                                           : fmt::format("{} (one of {} materials where it is too large)",
                                                         beyond.first, beyond.second.size()));
        for (const tinygltf::Mesh& mesh : file_.meshes) add_mesh(mesh);
        model_node_.assign(file_.nodes.size(), -1);
        add_scene();
        name_lights(model_);
        read_skins(file_, accessors_, model_node_, model_, tell_);
        for (Node& node : model_.nodes)
            if (node.skin >= 0 && model_.skins[static_cast<size_t>(node.skin)].joints.empty()) node.skin = -1;
        check_joints(model_);
        read_animations(file_, accessors_, budget_, model_node_, model_, tell_);
        if (file_.scenes.size() > 1)
            warn(fmt::format("the file has {} scenes; {} is shown", file_.scenes.size(),
                             file_.defaultScene < 0 ? "the first" : "its default one"));
        if (model_.triangle_count() == 0) warn("there are no triangles");
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
        std::string& problem = image_problems_.emplace_back(files_.unread[image]);
        if (!problem.empty()) return;
        try {
            RgbaImage decoded = decode_image(bytes, image_bytes_left_);
            image_bytes_left_ -= decoded.rgba.size();
            texture = {decoded.width, decoded.height, std::move(decoded.rgba)};
        } catch (const ImageError& error) {
            problem = fmt::format("cannot be read ({})", error.what());
        }
    }

    std::string unread(int image, const char* kind) const {
        const auto i = static_cast<size_t>(image);
        return fmt::format("{} {}: the {} factor is used", image_name(file_, i), image_problems_[i], kind);
    }

    // What is beyond its bounds is told once, however many materials have it.
    float material_factor(const tinygltf::Material& material, const std::string& what, double value,
                          double most) {
        const std::string name = fmt::format("material \"{}\": {}", material.name, what);
        return static_cast<float>(factor(name, value, most, [&](const std::string& text) {
            beyond_.try_emplace(what, text, std::set<size_t>{})
                .first->second.second.insert(model_.materials.size());
        }));
    }

    // With what KHR_materials_pbrSpecularGlossiness says of its colour and roughness, where the core's
    // material does not say it as well.
    tinygltf::Material in_core_terms(tinygltf::Material material) {
        const auto found = material.extensions.find(specular_glossiness);
        if (found == material.extensions.end()) return material;
        const tinygltf::TextureInfo diffuse =
            extension_texture(found->second, "diffuseTexture", specular_glossiness);
        auto& core = material.pbrMetallicRoughness;
        if (core.baseColorTexture.index >= 0 ||
            (material.values.contains("baseColorFactor") && diffuse.index < 0))
            return material;
        core = {};
        core.baseColorTexture = diffuse;
        extension_numbers(found->second, "diffuseFactor", specular_glossiness, core.baseColorFactor);
        constexpr const char* gloss = "glossinessFactor";
        core.metallicFactor = 0;
        core.roughnessFactor =
            1 - material_factor(material, gloss,
                                extension_number(found->second, gloss, specular_glossiness, 1), 1);
        return material;
    }

    // Of two textures, a wide and a high one, what they let through is far larger than both.
    void count_transmittance(const std::string& name, const Material& material) {
        const uint64_t bytes = transmittance_bytes(model_, material);
        if (bytes == 0 || !mapped_
                               .insert({material.texture, material.transmission_texture,
                                        material.metallic_roughness_texture})
                               .second)
            return;
        if (bytes > map_bytes_left_)
            throw GltfError(fmt::format("material \"{}\": what its textures let through takes {}", name,
                                        over_input_limit()));
        map_bytes_left_ -= bytes;
    }

    void add_material(const tinygltf::Material& material) {
        Material& out = model_.materials.emplace_back();
        const auto& pbr = material.pbrMetallicRoughness;
        for (size_t i = 0; i < std::min<size_t>(4, pbr.baseColorFactor.size()); ++i)
            out.base_color[i] = material_factor(material, "base colour", pbr.baseColorFactor[i], 1);
        if (material.normalTexture.index >= 0)
            warn("normal maps are not drawn: a surface is as flat as its triangles");
        read_alpha_mode(material, out);
        const TextureUse& use = texture_uses_.emplace_back(use_of(material));
        read_surface(material, use, out);
        if (pbr.baseColorTexture.index < 0) return;
        const tinygltf::Texture& texture = element(file_.textures, pbr.baseColorTexture.index, "texture");
        if (texture.source < 0) {
            warn("textures without a core image (a PNG or JPEG) are ignored: the colour factor is used");
            return;
        }
        element(file_.images, texture.source, "image");
        if (model_.textures[static_cast<size_t>(texture.source)].width == 0) {
            warn(unread(texture.source, "colour"));
            return;
        }
        out.texture = texture.source;
        if (!(out.alpha_cutoff || out.alpha_blend || out.transmission > 0) || texture.sampler < 0) return;
        const tinygltf::Sampler& sampler = element(file_.samplers, texture.sampler, "sampler");
        if (sampler.wrapS != TINYGLTF_TEXTURE_WRAP_REPEAT || sampler.wrapT != TINYGLTF_TEXTURE_WRAP_REPEAT)
            warn(
                "textures of alpha-tested and translucent materials are repeated, whatever their samplers "
                "say");
    }

    // Sections 3.9.2 and 3.9.3, and KHR_materials_emissive_strength: what reflections see of a surface.
    void read_surface(const tinygltf::Material& material, const TextureUse& use, Material& out) {
        const auto& pbr = material.pbrMetallicRoughness;
        const auto named = [&](const char* what, double value, double most) {
            return material_factor(material, what, value, most);
        };
        out.metallic = named("metallicFactor", pbr.metallicFactor, 1);
        out.roughness = named("roughnessFactor", pbr.roughnessFactor, 1);
        const auto extended = [&](const char* extension, const char* what, double otherwise, double most) {
            const auto found = material.extensions.find(extension);
            if (found == material.extensions.end()) return static_cast<float>(otherwise);
            const std::string of = fmt::format("material \"{}\": {}", material.name, extension);
            return named(what, extension_number(found->second, what, of, otherwise), most);
        };
        const float strength = extended("KHR_materials_emissive_strength", "emissiveStrength", 1, 1e6);
        for (size_t i = 0; i < std::min<size_t>(3, material.emissiveFactor.size()); ++i)
            out.emissive[i] = named("emissiveFactor", material.emissiveFactor[i], 1) * strength;
        out.metallic_roughness_texture =
            surface_image("metallic-roughness", pbr.metallicRoughnessTexture, use);
        out.emissive_texture = surface_image("emissive", material.emissiveTexture, use);
        out.transmission = extended(transmission, "transmissionFactor", 0, 1);
        out.transmission_texture = surface_image("transmission", transmission_info(material), use);
    }

    static tinygltf::TextureInfo transmission_info(const tinygltf::Material& material) {
        const auto found = material.extensions.find(transmission);
        if (found == material.extensions.end()) return {};
        return extension_texture(found->second, "transmissionTexture", transmission);
    }

    // A vertex has one pair of coordinates here: those of the first texture that the material has.
    static TextureUse use_of(const tinygltf::Material& material) {
        const auto& pbr = material.pbrMetallicRoughness;
        const tinygltf::TextureInfo& emissive = material.emissiveTexture;
        for (const tinygltf::TextureInfo& info :
             {pbr.baseColorTexture, pbr.metallicRoughnessTexture, emissive, transmission_info(material)})
            if (info.index >= 0) return texture_use(info);
        return {};
    }

    // The image of a texture of the given kind, or -1 with a warning where it cannot be used.
    int surface_image(const char* kind, const tinygltf::TextureInfo& info, const TextureUse& use) {
        if (info.index < 0) return -1;
        const tinygltf::Texture& texture = element(file_.textures, info.index, "texture");
        if (texture_use(info) != use || texture.source < 0) {
            warn(fmt::format(
                "{} textures without a core image, or with other coordinates than the base colour's, "
                "are ignored: the factor is used",
                kind));
            return -1;
        }
        element(file_.images, texture.source, "image");
        if (model_.textures[static_cast<size_t>(texture.source)].width > 0) return texture.source;
        warn(unread(texture.source, kind));
        return -1;
    }

    // Section 3.9.4.
    void read_alpha_mode(const tinygltf::Material& material, Material& out) {
        if (material.alphaMode == "MASK") {
            if (!(material.alphaCutoff >= 0 && std::isfinite(material.alphaCutoff)))
                throw GltfError(fmt::format("material \"{}\": alphaCutoff {} is not a number from 0 on",
                                            material.name, material.alphaCutoff));
            out.alpha_cutoff = material.alphaCutoff;
        } else if (material.alphaMode == "BLEND") {
            out.alpha_blend = true;
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
        if (primitive.material >= 0) element(file_.materials, primitive.material, "material");
        const TextureUse use =
            primitive.material < 0 ? TextureUse{} : texture_uses_[static_cast<size_t>(primitive.material)];
        if (auto part = read_primitive(file_, accessors_, budget_, primitive, use, tell_))
            add_part(model_, mesh, std::move(*part));
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
        struct Pending {
            int node, parent;  // the file's, the model's
            bool hidden;
        };
        std::vector<Pending> pending{{root, root_parent, false}};
        while (!pending.empty()) {
            const auto [index, parent, in_hidden] = pending.back();
            pending.pop_back();
            const tinygltf::Node& node = element(file_.nodes, index, "node");
            if (!visited_.insert(index).second) {
                throw GltfError(fmt::format("node {} is reached twice: nodes must form trees", index));
            }
            Node& out = model_.nodes.emplace_back();
            out.name = node.name;
            out.parent = parent;
            const bool hidden = in_hidden || is_hidden(node);
            if (node.mesh >= 0) element(file_.meshes, node.mesh, "mesh");
            if (node.skin >= 0) element(file_.skins, node.skin, "skin");
            out.mesh = hidden ? -1 : node.mesh;
            out.skin = out.mesh >= 0 ? node.skin : -1;
            read_transform(node, out);
            const int self = static_cast<int>(model_.nodes.size()) - 1;
            model_node_[static_cast<size_t>(index)] = self;
            const std::vector<double>& weights = node.mesh >= 0 && node.weights.empty()
                                                     ? file_.meshes[static_cast<size_t>(node.mesh)].weights
                                                     : node.weights;
            budget_.spend(weights.size() * sizeof(double));
            out.weights = weights;
            add_camera(node, self);
            if (!hidden) {
                read_light(file_, node, self, model_, tell_);
                add_instances(node, self);
            }
            const std::vector<int> last_first(node.children.rbegin(), node.children.rend());
            for (const int child : last_first) pending.push_back({child, self, hidden});
        }
    }

    void add_camera(const tinygltf::Node& node, int self) {
        if (node.camera < 0) return;
        const tinygltf::Camera& camera = element(file_.cameras, node.camera, "camera");
        if (camera.type != "perspective") {
            warn("orthographic cameras are not looked through");
            return;
        }
        const double fov = glm::degrees(camera.perspective.yfov), near = camera.perspective.znear;
        if (!(fov > 0.01 && fov < 170 && near > 1e-6 && near < 1e6)) {
            warn(fmt::format(
                "camera \"{}\" is not looked through: a field of view of {:.4g} degrees from {:.4g} m on",
                camera.name, fov, near));
            return;
        }
        model_.cameras.push_back({self, fov, near});
    }

    // A child of the node for each instance, which then has no mesh of its own.
    void add_instances(const tinygltf::Node& node, int self) {
        constexpr const char* name = "EXT_mesh_gpu_instancing";
        const auto found = node.extensions.find(name);
        if (found == node.extensions.end() || node.mesh < 0) return;
        const tinygltf::Value attributes =
            found->second.IsObject() ? found->second.Get("attributes") : tinygltf::Value();
        const auto read = [&](const char* key, int width) -> std::span<const float> {
            if (!attributes.IsObject() || !attributes.Has(key)) return {};
            const std::vector<float>& numbers =
                accessors_.floats(extension_integer(attributes, key, name), width);
            if (!are_finite(numbers))
                throw GltfError(fmt::format("{}: {} of node \"{}\" is not finite", name, key, node.name));
            return numbers;
        };
        const std::span<const float> t = read("TRANSLATION", 3), r = read("ROTATION", 4),
                                     s = read("SCALE", 3);
        const size_t count = std::max({t.size() / 3, r.size() / 4, s.size() / 3});
        for (const auto& [size, width] : {std::pair(t.size(), size_t{3}), {r.size(), 4}, {s.size(), 3}})
            if (size != 0 && size != count * width)
                throw GltfError(fmt::format("{}: attributes differ in count", name));
        // Many nodes may share their accessors. Where a frame is posed, each instance has the weights, too:
        // the node's, or as many as there are targets by an animation.
        const size_t weights =
            std::max(model_.nodes[static_cast<size_t>(self)].weights.size(), targets_of(model_, node.mesh));
        budget_.spend(count * (sizeof(Node) + weights * sizeof(double)));
        model_.nodes[static_cast<size_t>(self)].mesh = -1;
        if (std::exchange(model_.nodes[static_cast<size_t>(self)].skin, -1) >= 0)
            warn("instances with a skin are in their rest pose");
        for (size_t i = 0; i < count; ++i) {
            Node& out = model_.nodes.emplace_back();
            out.parent = self;
            out.mesh = node.mesh;
            out.weights_of = self;
            if (!t.empty()) out.translation = glm::make_vec3(&t[3 * i]);
            if (!r.empty())
                out.rotation = glm::normalize(glm::dquat(r[4 * i + 3], r[4 * i], r[4 * i + 1], r[4 * i + 2]));
            if (!s.empty()) out.scale = glm::make_vec3(&s[3 * i]);
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
    uint64_t image_bytes_left_ = input_limit(), map_bytes_left_ = input_limit();
    std::set<std::array<int, 3>> mapped_;  // textures of maps that are counted
    Model& model_;
    std::set<std::string> warned_;
    std::set<int> visited_;
    std::vector<int> model_node_;              // of the file's nodes; -1: not shown
    std::vector<TextureUse> texture_uses_;     // of materials
    std::vector<std::string> image_problems_;  // of images; empty: none
    std::map<std::string, std::pair<std::string, std::set<size_t>>> beyond_;  // a text, materials; by factor
    const GltfTell tell_ = [this](const std::string& text) { warn(text); };
};

}  // namespace

std::optional<Model> load_gltf(const std::filesystem::path& path, Diagnostics& diagnostics) {
    // Malformed JSON reaches us as exceptions of the JSON library.
    try {
        std::optional<GltfFiles> files = read_gltf_files(path, diagnostics);
        if (!files) return std::nullopt;
        ReadBudget budget(files->bytes);
        decode_meshopt(files->model, budget);
        Model model;
        Loader(*files, model).load();
        return model;
    } catch (const std::bad_alloc&) {
        throw;  // the file is not to blame
    } catch (const std::exception& error) {
        diagnostics.add({path.string(), 0, 0}, "", error.what());
        return std::nullopt;
    }
}

}  // namespace penumbra
