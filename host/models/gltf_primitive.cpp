// SPDX-License-Identifier: MIT
#include "host/models/gltf_primitive.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>

#include "host/models/gltf_extension.h"

namespace penumbra {
namespace {

constexpr const char* draco_name = "KHR_draco_mesh_compression";

// Attributes by name, `width` floats per vertex.
class Attributes {
  public:
    Attributes(const tinygltf::Model& file, AccessorReader& accessors, ReadBudget& budget,
               const tinygltf::Primitive& primitive)
        : file_(file), accessors_(accessors), budget_(budget), primitive_(primitive) {
        const auto found = primitive.extensions.find(draco_name);
        if (found != primitive.extensions.end()) decode(found->second);
    }

    bool has(const std::string& name) const { return primitive_.attributes.contains(name); }

    int width(const std::string& name) const {
        return tinygltf::GetNumComponentsInType(
            static_cast<uint32_t>(element(file_.accessors, primitive_.attributes.at(name), "accessor").type));
    }

    const std::vector<float>& floats(const std::string& name, int width) {
        const auto id = ids_.find(name);
        if (id == ids_.end()) return accessors_.floats(primitive_.attributes.at(name), width);
        const auto components = static_cast<size_t>(width);
        const draco::PointAttribute* values =
            mesh_->GetAttributeByUniqueId(static_cast<uint32_t>(id->second));
        if (!values || values->num_components() != width)
            throw GltfError(fmt::format("{}: {} is not what its accessor says", draco_name, name));
        budget_.spend(mesh_->num_points() * components * sizeof(float));
        std::vector<float>& out = decoded_[name];
        out.resize(mesh_->num_points() * components);
        for (uint32_t point = 0; point < mesh_->num_points(); ++point)
            if (!values->ConvertValue<float>(values->mapped_index(draco::PointIndex(point)),
                                             static_cast<int8_t>(width), &out[point * components]))
                throw GltfError(fmt::format("{}: {} cannot be read", draco_name, name));
        return out;
    }

    // Three per triangle, or as the primitive's mode has them; less than `vertices` each.
    std::vector<uint32_t> corners(size_t vertices) {
        std::vector<uint32_t> out;
        if (mesh_) {
            budget_.spend(uint64_t{mesh_->num_faces()} * 3 * sizeof(uint32_t));
            for (draco::FaceIndex face(0); face < mesh_->num_faces(); ++face)
                for (size_t corner = 0; corner < 3; ++corner)
                    out.push_back(mesh_->face(face)[corner].value());
        } else if (primitive_.indices >= 0) {
            out = accessors_.indices(primitive_.indices);
        } else {
            budget_.spend(vertices * sizeof(uint32_t));
            out.resize(vertices);
            std::iota(out.begin(), out.end(), 0u);
        }
        for (const uint32_t corner : out)
            if (corner >= vertices)
                throw GltfError(fmt::format("index {} is out of range ({} vertices)", corner, vertices));
        return out;
    }

  private:
    void decode(const tinygltf::Value& how) {
        const auto bytes = view_bytes(file_, extension_integer(how, "bufferView", draco_name));
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        draco::Decoder decoder;
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        if (!mesh.ok()) throw GltfError(fmt::format("{}: {}", draco_name, mesh.status().error_msg_string()));
        mesh_ = std::move(mesh).value();
        const tinygltf::Value attributes = how.Get("attributes");
        if (!attributes.IsObject()) throw GltfError(fmt::format("{} has no attributes", draco_name));
        for (const std::string& key : attributes.Keys())
            ids_[key] = extension_integer(attributes, key.c_str(), draco_name);
    }

    const tinygltf::Model& file_;
    AccessorReader& accessors_;
    ReadBudget& budget_;
    const tinygltf::Primitive& primitive_;
    std::unique_ptr<draco::Mesh> mesh_;
    std::map<std::string, int> ids_;  // of Draco's attributes, by name
    std::map<std::string, std::vector<float>> decoded_;
};

// Of vertices that other primitives have, too, those of these corners, which from then on count among
// them alone: many primitives of a file may share one accessor.
std::vector<uint32_t> keep_used(std::vector<uint32_t>& corners) {
    std::vector<uint32_t> used = corners;
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (uint32_t& corner : corners)
        corner = static_cast<uint32_t>(std::ranges::lower_bound(used, corner) - used.begin());
    return used;
}

// Section 3.7.2.1: strips and fans to lists, with the winding kept. Repeated corners join one strip to the
// next and are no triangles.
std::vector<uint32_t> to_triangles(const std::vector<uint32_t>& corners, int mode) {
    std::vector<uint32_t> out;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        out = corners;
        out.resize(corners.size() - corners.size() % 3);
        return out;
    }
    for (size_t i = 2; i < corners.size(); ++i) {
        const size_t odd = i & 1;
        const std::array<uint32_t, 3> triangle =
            mode == TINYGLTF_MODE_TRIANGLE_FAN
                ? std::array{corners[i - 1], corners[i], corners[0]}
                : std::array{corners[i - 2], corners[i - 1 + odd], corners[i - odd]};
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
            out.insert(out.end(), triangle.begin(), triangle.end());
    }
    return out;
}

// The vectors of those vertices that are used; all of them where none is named.
template <class Vector>
std::vector<Vector> vectors(const std::vector<float>& numbers, const std::vector<uint32_t>& used) {
    constexpr auto width = static_cast<size_t>(Vector::length());
    std::vector<Vector> out(used.empty() ? numbers.size() / width : used.size());
    for (size_t i = 0; i < out.size(); ++i) {
        const size_t from = width * (used.empty() ? i : used[i]);
        for (int c = 0; c < Vector::length(); ++c) out[i][c] = numbers[from + static_cast<size_t>(c)];
    }
    return out;
}

void check_count(size_t numbers, int width, size_t vertices, const std::string& name) {
    if (numbers != vertices * static_cast<size_t>(width))
        throw GltfError(fmt::format("{} and POSITION differ in count", name));
}

std::vector<std::array<uint8_t, 4>> to_bytes(const std::vector<glm::vec4>& colors) {
    std::vector<std::array<uint8_t, 4>> out(colors.size());
    for (size_t i = 0; i < out.size(); ++i)
        for (size_t c = 0; c < 4; ++c) {
            const float v = colors[i][static_cast<int>(c)];
            out[i][c] = static_cast<uint8_t>(std::lround((v >= 0 ? std::min(v, 1.0f) : 0) * 255));
        }
    return out;
}

// Weights become a sum of 1; a vertex without any follows its first joint.
void bind_joints(const std::vector<glm::vec4>& joints, Part& part) {
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

}  // namespace

// KHR_texture_transform: translation * rotation * scale, of coordinates of its own choice.
TextureUse texture_use(const tinygltf::TextureInfo& info) {
    TextureUse use;
    use.coordinates = info.texCoord;
    constexpr const char* name = "KHR_texture_transform";
    const auto found = info.extensions.find(name);
    if (found != info.extensions.end()) {
        double offset[2] = {0, 0}, scale[2] = {1, 1};
        extension_numbers(found->second, "offset", name, offset);
        extension_numbers(found->second, "scale", name, scale);
        const double rotation = extension_number(found->second, "rotation", name, 0);
        if (found->second.Has("texCoord"))
            use.coordinates = extension_integer(found->second, "texCoord", name);
        const double c = std::cos(rotation), s = std::sin(rotation);
        use.transform = {
            {c * scale[0], -s * scale[0], 0}, {s * scale[1], c * scale[1], 0}, {offset[0], offset[1], 1}};
    }
    if (use.coordinates < 0) throw GltfError(fmt::format("there is no TEXCOORD_{}", use.coordinates));
    return use;
}

std::optional<Part> read_primitive(const tinygltf::Model& file, AccessorReader& accessors, ReadBudget& budget,
                                   const tinygltf::Primitive& primitive, const TextureUse& use,
                                   const GltfTell& tell) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN) throw GltfError(fmt::format("there is no mode {}", mode));
    if (mode < TINYGLTF_MODE_TRIANGLES) {
        tell("points and lines are ignored: they cast no shadow");
        return std::nullopt;
    }
    if (!primitive.attributes.contains("POSITION")) {
        tell("a primitive without positions is ignored");
        return std::nullopt;
    }
    Attributes data(file, accessors, budget, primitive);
    const std::vector<float>& numbers = data.floats("POSITION", 3);
    const size_t vertices = numbers.size() / 3;
    std::vector<uint32_t> corners = data.corners(vertices), used;
    if (corners.size() < vertices) used = keep_used(corners);
    const size_t kept = used.empty() ? vertices : used.size();
    budget.spend(kept * (sizeof(glm::vec3) + sizeof(glm::vec2)) + corners.size() * 3 * sizeof(uint32_t));
    const auto read = [&]<class Vector>(const std::string& name, Vector) {
        const std::vector<float>& values = data.floats(name, Vector::length());
        check_count(values.size(), Vector::length(), vertices, name);
        return vectors<Vector>(values, used);
    };

    Part part;
    part.material = primitive.material;
    part.single_sided =
        primitive.material < 0 || !file.materials[static_cast<size_t>(primitive.material)].doubleSided;
    part.positions = vectors<glm::vec3>(numbers, used);
    if (const std::string name = fmt::format("TEXCOORD_{}", use.coordinates); data.has(name)) {
        part.uv = read(name, glm::vec2());
        for (glm::vec2& at : part.uv) {
            at = glm::vec2(use.transform * glm::dvec3(at, 1));
            if (std::isfinite(at.x) && std::isfinite(at.y)) continue;
            tell("texture coordinates that are not finite are taken as 0");
            at = glm::vec2(0);
        }
    }
    if (data.has("COLOR_0")) {
        budget.spend(kept * (sizeof(glm::vec4) + 4));
        std::vector<glm::vec4> colors;
        if (data.width("COLOR_0") == 4)
            colors = read("COLOR_0", glm::vec4());
        else
            for (const glm::vec3& color : read("COLOR_0", glm::vec3())) colors.emplace_back(color, 1);
        part.colors = to_bytes(colors);
        const auto is_clear = [](const std::array<uint8_t, 4>& color) { return color[3] < 255; };
        if (primitive.material >= 0 &&
            file.materials[static_cast<size_t>(primitive.material)].alphaMode != "OPAQUE" &&
            std::ranges::any_of(part.colors, is_clear))
            tell("the alpha of vertex colours is ignored");
    }
    if (data.has("JOINTS_0") != data.has("WEIGHTS_0"))
        throw GltfError("of JOINTS_0 and WEIGHTS_0 it has one, which says nothing without the other");
    if (data.has("JOINTS_0")) {
        if (data.has("JOINTS_1")) tell("of more than four joints per vertex the first four are used");
        budget.spend(kept * (2 * sizeof(glm::vec4) + 8));
        part.weights = read("WEIGHTS_0", glm::vec4());
        bind_joints(read("JOINTS_0", glm::vec4()), part);
    }
    for (const auto& target : primitive.targets) {
        budget.spend(kept * sizeof(glm::vec3));
        std::vector<glm::vec3>& offsets = part.targets.emplace_back(kept, glm::vec3(0));
        const auto position = target.find("POSITION");
        if (position == target.end()) continue;
        const std::vector<float>& values = accessors.floats(position->second, 3);
        check_count(values.size(), 3, vertices, "a morph target");
        offsets = vectors<glm::vec3>(values, used);
        for (const glm::vec3& offset : offsets)
            if (!are_finite({&offset.x, 3})) throw GltfError("a morph target is not finite");
    }
    part.indices = to_triangles(corners, mode);
    return part;
}

}  // namespace penumbra
