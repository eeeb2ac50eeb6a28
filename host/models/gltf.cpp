// SPDX-License-Identifier: MIT
// tinygltf parses; this file checks what it parsed and turns it into a Model. Reference: glTF 2.0
// specification.
#include "host/models/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/gtc/type_ptr.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "host/models/gltf_accessor.h"
#include "host/models/gltf_extension.h"
#include "host/models/gltf_meshopt.h"
#include "host/models/gltf_motion.h"
#include "host/models/gltf_primitive.h"
#include "host/models/gltf_text.h"

namespace penumbra {

namespace {

// Extensions that a file may require: those that are read, and those that do not change where its triangles are.
bool is_harmless(std::string_view extension) {
    constexpr std::string_view known[] = {"KHR_lights_punctual",   "KHR_mesh_quantization",
                                          "KHR_texture_transform", "KHR_draco_mesh_compression",
                                          "EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
                                          "KHR_texture_basisu",    "EXT_texture_webp",
                                          "EXT_texture_avif",      "MSFT_texture_dds",
                                          "KHR_animation_pointer", "KHR_xmp_json_ld"};
    return extension.starts_with("KHR_materials_") || std::ranges::find(known, extension) != std::end(known);
}

// Extensions that change a picture in ways that are not drawn, and what is seen instead.
constexpr std::pair<const char*, const char*> undrawn[] = {
    {"KHR_materials_unlit", "is drawn lit"},
    {"KHR_materials_transmission", "is drawn and casts shadows as if opaque"},
    {"KHR_materials_pbrSpecularGlossiness", "is drawn in its base colour"},
    {"KHR_materials_variants", "is drawn in its first variant"},
    {"KHR_texture_basisu", "is not read: the colour factor is used"},
    {"EXT_texture_webp", "is not read: the colour factor is used"},
    {"EXT_texture_avif", "is not read: the colour factor is used"},
    {"MSFT_texture_dds", "is not read: the colour factor is used"},
    {"KHR_animation_pointer", "is not played"}};

// How a base colour texture is looked up: which coordinates, and what is done to them.
struct TextureUse {
    int coordinates = 0;  // TEXCOORD_n
    glm::dmat3 transform{1};
};

class Loader {
  public:
    Loader(const tinygltf::Model& file, Model& model) : file_(file), model_(model) {}

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
        for (const tinygltf::Image& image : file_.images) add_texture(image);
        for (const tinygltf::Material& material : file_.materials) add_material(material);
        for (const tinygltf::Mesh& mesh : file_.meshes) add_mesh(mesh);
        model_node_.assign(file_.nodes.size(), -1);
        add_scene();
        const auto tell = [this](const std::string& text) { warn(text); };
        read_skins(file_, model_node_, model_, tell);
        for (Node& node : model_.nodes)
            if (node.skin >= 0 && model_.skins[static_cast<size_t>(node.skin)].joints.empty()) node.skin = -1;
        check_joints();
        read_animations(
            file_, model_node_, [this](int node) { return targets_of(node); }, model_, tell);
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

    void add_texture(const tinygltf::Image& image) {
        Texture& texture = model_.textures.emplace_back();
        const size_t texels =
            static_cast<size_t>(std::max(image.width, 0)) * static_cast<size_t>(std::max(image.height, 0));
        const size_t step = static_cast<size_t>(image.bits) / 8;
        if (texels == 0 || image.component != 4 || step == 0 || image.image.size() < texels * 4 * step)
            return;
        texture.width = static_cast<uint32_t>(image.width);
        texture.height = static_cast<uint32_t>(image.height);
        texture.rgba.resize(texels * 4);
        // 16-bit images are little-endian here: the high byte is the last one.
        for (size_t i = 0; i < texels * 4; ++i) texture.rgba[i] = image.image[i * step + step - 1];
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
        if (std::ranges::any_of(material.emissiveFactor, [](double v) { return v > 0; }))
            warn("emissive materials are drawn in their base colour alone");
        TextureUse& use = texture_uses_.emplace_back();
        if (pbr.baseColorTexture.index < 0) return;
        const tinygltf::Texture& texture = element(file_.textures, pbr.baseColorTexture.index, "texture");
        use = texture_use(pbr.baseColorTexture);
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

    // KHR_texture_transform: translation * rotation * scale, of coordinates of its own choice.
    static TextureUse texture_use(const tinygltf::TextureInfo& info) {
        TextureUse use;
        use.coordinates = info.texCoord;
        constexpr const char* name = "KHR_texture_transform";
        const auto found = info.extensions.find(name);
        if (found != info.extensions.end()) {
            double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
            extension_numbers(found->second, "offset", name, offset);
            extension_numbers(found->second, "scale", name, scale);
            if (found->second.Has("rotation")) {
                if (!found->second.Get("rotation").IsNumber())
                    throw GltfError("KHR_texture_transform: \"rotation\" is not a number");
                rotation = found->second.Get("rotation").GetNumberAsDouble();
            }
            if (found->second.Has("texCoord")) use.coordinates = extension_integer(found->second, "texCoord", name);
            const double c = std::cos(rotation), s = std::sin(rotation);
            use.transform = {{c * scale[0], -s * scale[0], 0}, {s * scale[1], c * scale[1], 0}, {offset[0], offset[1], 1}};
        }
        if (use.coordinates < 0) throw GltfError(fmt::format("there is no TEXCOORD_{}", use.coordinates));
        return use;
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
        const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
        if (mode < TINYGLTF_MODE_TRIANGLES) {
            warn("points and lines are ignored: they cast no shadow");
            return;
        }
        if (!primitive.attributes.contains("POSITION")) {
            warn("a primitive without positions is ignored");
            return;
        }
        if (primitive.material >= 0) element(file_.materials, primitive.material, "material");

        const GltfPrimitive data(file_, primitive);
        Part part;
        part.positions = vectors<glm::vec3>(data.floats("POSITION", 3));
        const size_t vertices = part.positions.size();
        const TextureUse use = primitive.material < 0 ? TextureUse{} : texture_uses_[static_cast<size_t>(primitive.material)];
        if (const std::string name = fmt::format("TEXCOORD_{}", use.coordinates); data.has(name))
            part.uv = read_uv(data.floats(name, 2), vertices, name, use);
        if (data.has("COLOR_0")) part.colors = read_colors(data, vertices);
        if (data.has("JOINTS_0") && data.has("WEIGHTS_0")) read_joints(data, part);
        read_targets(primitive, part);
        part.indices = to_triangles(data.corners(vertices), mode);
        part.material = primitive.material;
        add_part(model_, mesh, std::move(part));
    }

    template <class Vector>
    static std::vector<Vector> vectors(const std::vector<float>& numbers) {
        constexpr auto width = static_cast<size_t>(Vector::length());
        std::vector<Vector> out(numbers.size() / width);
        for (size_t i = 0; i < out.size(); ++i)
            for (int c = 0; c < Vector::length(); ++c) out[i][c] = numbers[width * i + static_cast<size_t>(c)];
        return out;
    }

    static void check_count(size_t count, size_t vertices, const std::string& name) {
        if (count != vertices) throw GltfError(fmt::format("{} and POSITION differ in count", name));
    }

    std::vector<glm::vec2> read_uv(const std::vector<float>& values, size_t vertices, const std::string& name,
                                   const TextureUse& use) {
        std::vector<glm::vec2> uv = vectors<glm::vec2>(values);
        check_count(uv.size(), vertices, name);
        for (glm::vec2& at : uv) {
            at = glm::vec2(use.transform * glm::dvec3(at, 1));
            if (std::isfinite(at.x) && std::isfinite(at.y)) continue;
            warn("texture coordinates that are not finite are taken as 0");
            at = glm::vec2(0);
        }
        return uv;
    }

    static std::vector<std::array<uint8_t, 4>> read_colors(const GltfPrimitive& data, size_t vertices) {
        const auto width = static_cast<size_t>(data.width("COLOR_0"));
        if (width != 3 && width != 4) throw GltfError("COLOR_0 has neither 3 nor 4 components");
        const std::vector<float> values = data.floats("COLOR_0", static_cast<int>(width));
        check_count(values.size() / width, vertices, "COLOR_0");
        std::vector<std::array<uint8_t, 4>> colors(vertices, {255, 255, 255, 255});
        for (size_t i = 0; i < vertices; ++i)
            for (size_t c = 0; c < width; ++c)
                if (const float v = values[i * width + c]; std::isfinite(v))
                    colors[i][c] = static_cast<uint8_t>(std::lround(std::clamp(v, 0.0f, 1.0f) * 255));
        return colors;
    }

    void read_joints(const GltfPrimitive& data, Part& part) {
        const std::vector<glm::vec4> joints = vectors<glm::vec4>(data.floats("JOINTS_0", 4));
        part.weights = vectors<glm::vec4>(data.floats("WEIGHTS_0", 4));
        check_count(joints.size(), part.positions.size(), "JOINTS_0");
        check_count(part.weights.size(), part.positions.size(), "WEIGHTS_0");
        if (data.has("JOINTS_1")) warn("of more than four joints per vertex the first four are used");
        for (size_t i = 0; i < joints.size(); ++i) {
            std::array<uint16_t, 4>& joint = part.joints.emplace_back();
            float sum = 0;
            for (int k = 0; k < 4; ++k) {
                float& weight = part.weights[i][k];
                if (!(weight > 0 && std::isfinite(weight))) weight = 0;
                if (!(joints[i][k] >= 0 && joints[i][k] < 65536)) throw GltfError("JOINTS_0 are no indices");
                joint[static_cast<size_t>(k)] = static_cast<uint16_t>(joints[i][k]);
                sum += weight;
            }
            part.weights[i] = sum > 0 ? part.weights[i] / sum : glm::vec4(1, 0, 0, 0);
        }
    }

    void read_targets(const tinygltf::Primitive& primitive, Part& part) {
        for (const auto& target : primitive.targets) {
            std::vector<glm::vec3>& offsets = part.targets.emplace_back();
            if (const auto position = target.find("POSITION"); position != target.end())
                offsets = vectors<glm::vec3>(read_floats(file_, position->second, 3));
            else
                offsets.resize(part.positions.size());
            check_count(offsets.size(), part.positions.size(), "a morph target");
        }
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
            if (node.skin >= 0) element(file_.skins, node.skin, "skin");
            out.skin = node.mesh >= 0 ? node.skin : -1;
            read_transform(node, out);
            const int self = static_cast<int>(model_.nodes.size()) - 1;
            model_node_[static_cast<size_t>(index)] = self;
            if (node.mesh >= 0) out.weights = file_.meshes[static_cast<size_t>(node.mesh)].weights;
            if (!node.weights.empty()) out.weights = node.weights;
            add_camera(node, self);
            add_light(node, self);
            add_instances(node, self);
            const std::vector<int> last_first(node.children.rbegin(), node.children.rend());
            for (const int child : last_first) pending.emplace_back(child, self);
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
            warn(fmt::format("camera \"{}\" is not looked through: a field of view of {} degrees from {} m on",
                             camera.name, fov, near));
            return;
        }
        model_.cameras.push_back({self, fov, near});
    }

    // The sun is all the light there is.
    void add_light(const tinygltf::Node& node, int self) {
        constexpr const char* name = "KHR_lights_punctual";
        const auto found = node.extensions.find(name);
        if (found == node.extensions.end()) return;
        const tinygltf::Light& light = element(file_.lights, extension_integer(found->second, "light", name), "light");
        if (light.type == "directional")
            model_.suns.push_back(self);
        else
            warn(fmt::format("{}: {} lights are not drawn", name, light.type));
    }

    // A child of the node for each instance, which then has no mesh of its own.
    void add_instances(const tinygltf::Node& node, int self) {
        constexpr const char* name = "EXT_mesh_gpu_instancing";
        const auto found = node.extensions.find(name);
        if (found == node.extensions.end() || node.mesh < 0) return;
        const tinygltf::Value attributes = found->second.IsObject() ? found->second.Get("attributes") : tinygltf::Value();
        const auto read = [&](const char* key, int width) {
            return attributes.IsObject() && attributes.Has(key)
                       ? read_floats(file_, extension_integer(attributes, key, name), width)
                       : std::vector<float>{};
        };
        const std::vector<float> t = read("TRANSLATION", 3), r = read("ROTATION", 4), s = read("SCALE", 3);
        const size_t count = std::max({t.size() / 3, r.size() / 4, s.size() / 3});
        for (const auto& [size, width] : {std::pair(t.size(), size_t{3}), {r.size(), 4}, {s.size(), 3}})
            if (size != 0 && size != count * width) throw GltfError(fmt::format("{}: attributes differ in count", name));
        model_.nodes[static_cast<size_t>(self)].mesh = -1;
        for (size_t i = 0; i < count; ++i) {
            Node& out = model_.nodes.emplace_back();
            out.parent = self;
            out.mesh = node.mesh;
            if (!t.empty()) out.translation = glm::make_vec3(&t[3 * i]);
            if (!r.empty()) out.rotation = glm::normalize(glm::dquat(r[4 * i + 3], r[4 * i], r[4 * i + 1], r[4 * i + 2]));
            if (!s.empty()) out.scale = glm::make_vec3(&s[3 * i]);
        }
    }

    size_t targets_of(int node) const {
        const int mesh = model_.nodes[static_cast<size_t>(node)].mesh;
        if (mesh < 0) return 0;
        size_t count = 0;
        for (const Part& part : model_.meshes[static_cast<size_t>(mesh)].parts)
            count = std::max(count, part.targets.size());
        return count;
    }

    void check_joints() const {
        for (const Node& node : model_.nodes) {
            if (node.skin < 0) continue;
            const size_t joints = model_.skins[static_cast<size_t>(node.skin)].joints.size();
            for (const Part& part : model_.meshes[static_cast<size_t>(node.mesh)].parts)
                for (size_t i = 0; i < part.joints.size(); ++i)
                    for (int k = 0; k < 4; ++k)
                        if (part.weights[i][k] > 0 && part.joints[i][static_cast<size_t>(k)] >= joints)
                            throw GltfError(fmt::format("node \"{}\": a vertex is moved by joint {} of {}", node.name,
                                                        part.joints[i][static_cast<size_t>(k)], joints));
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

    const tinygltf::Model& file_;
    Model& model_;
    std::set<std::string> warned_;
    std::set<int> visited_;
    std::vector<int> model_node_;           // of the file's nodes; -1: not shown
    std::vector<TextureUse> texture_uses_;  // of materials
};

// Takes every image; one that cannot be decoded stays empty, and the materials that use it say so.
bool decode_image(tinygltf::Image* image, const int index, std::string*, std::string*, int width, int height,
                  const unsigned char* bytes, int size, void* options) {
    std::string ignored_error, ignored_warning;
    if (!tinygltf::LoadImageData(image, index, &ignored_error, &ignored_warning, width, height, bytes, size,
                                 options)) {
        image->width = image->height = 0;
        image->image.clear();
    }
    return true;
}

std::string one_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    std::ranges::replace(text, '\n', ' ');
    return text;
}

std::string read_bytes(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    if (!in && !in.eof()) throw GltfError("cannot be read");
    if (bytes.empty()) throw GltfError("the file is empty");
    if (bytes.size() > std::numeric_limits<unsigned int>::max()) throw GltfError("the file has more than 4 GiB");
    return bytes;
}

bool is_binary(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".glb";
}

}  // namespace

std::optional<Model> load_gltf(const std::filesystem::path& path, Diagnostics& diagnostics) {
    const Place place{path.string(), 0, 0};
    std::error_code failure;
    if (!std::filesystem::is_regular_file(path, failure)) {
        diagnostics.add(place, "", "no such file");
        return std::nullopt;
    }
    // Malformed JSON and absurd sizes reach us as exceptions of the JSON library and of the allocator.
    try {
        tinygltf::TinyGLTF loader;
        loader.SetImageLoader(decode_image, nullptr);  // null: the default options, which convert to RGBA
        tinygltf::Model file;
        std::string error, warning;
        const std::string bytes = taken_by_tinygltf(read_bytes(path));
        if (const std::string version = old_version(bytes); !version.empty()) {
            diagnostics.add(place, "", fmt::format("is glTF {}; this program reads glTF 2.0", version));
            return std::nullopt;
        }
        const auto size = static_cast<unsigned int>(bytes.size());
        const std::string folder = std::filesystem::absolute(path).parent_path().string();
        const bool good = is_binary(path)
                              ? loader.LoadBinaryFromMemory(&file, &error, &warning, reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
                              : loader.LoadASCIIFromString(&file, &error, &warning, bytes.data(), size, folder);
        if (!good) {
            diagnostics.add(place, "", "not a valid glTF 2.0 file: " + one_line(error));
            return std::nullopt;
        }
        Model model;
        if (!warning.empty()) model.warnings.push_back(one_line(warning));
        decode_meshopt(file);
        Loader(file, model).load();
        return model;
    } catch (const std::exception& error) {
        diagnostics.add(place, "", error.what());
        return std::nullopt;
    }
}

}  // namespace penumbra
