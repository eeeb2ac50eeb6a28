// SPDX-License-Identifier: MIT
#include "host/models/gltf_primitive.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <map>
#include <numeric>

#include "host/models/gltf_accessor.h"
#include "host/models/gltf_extension.h"

namespace penumbra {

struct GltfPrimitive::Decoded {
    std::unique_ptr<draco::Mesh> mesh;
    std::map<std::string, int> ids;  // of attributes, by name
};

GltfPrimitive::GltfPrimitive(const tinygltf::Model& file, const tinygltf::Primitive& primitive)
    : file_(file), primitive_(primitive) {
    constexpr const char* name = "KHR_draco_mesh_compression";
    const auto found = primitive.extensions.find(name);
    if (found == primitive.extensions.end()) return;
    const std::span<const unsigned char> bytes =
        view_bytes(file, extension_integer(found->second, "bufferView", name));
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) throw GltfError(fmt::format("{}: {}", name, mesh.status().error_msg_string()));
    decoded_ = std::make_unique<Decoded>();
    decoded_->mesh = std::move(mesh).value();
    const tinygltf::Value& attributes = found->second.Get("attributes");
    if (!attributes.IsObject()) throw GltfError(fmt::format("{} has no attributes", name));
    for (const std::string& key : attributes.Keys())
        decoded_->ids[key] = extension_integer(attributes, key.c_str(), name);
}

GltfPrimitive::~GltfPrimitive() = default;

bool GltfPrimitive::has(const std::string& attribute) const {
    return primitive_.attributes.contains(attribute) || (decoded_ && decoded_->ids.contains(attribute));
}

int GltfPrimitive::width(const std::string& attribute) const {
    const auto found = primitive_.attributes.find(attribute);
    if (found == primitive_.attributes.end()) throw GltfError(attribute + " has no accessor");
    return tinygltf::GetNumComponentsInType(
        static_cast<uint32_t>(element(file_.accessors, found->second, "accessor").type));
}

std::vector<float> GltfPrimitive::floats(const std::string& attribute, int width) const {
    if (decoded_)
        if (const auto id = decoded_->ids.find(attribute); id != decoded_->ids.end()) {
            const draco::PointAttribute* values =
                decoded_->mesh->GetAttributeByUniqueId(static_cast<uint32_t>(id->second));
            if (!values || values->num_components() != width)
                throw GltfError(fmt::format("KHR_draco_mesh_compression: {} is not what its accessor says",
                                            attribute));
            std::vector<float> out(size_t{decoded_->mesh->num_points()} * static_cast<size_t>(width));
            for (uint32_t point = 0; point < decoded_->mesh->num_points(); ++point)
                if (!values->ConvertValue<float>(values->mapped_index(draco::PointIndex(point)),
                                                 static_cast<int8_t>(width), &out[size_t{point} * static_cast<size_t>(width)]))
                    throw GltfError(fmt::format("KHR_draco_mesh_compression: {} cannot be read", attribute));
            return out;
        }
    const auto found = primitive_.attributes.find(attribute);
    if (found == primitive_.attributes.end()) throw GltfError("there is no " + attribute);
    return read_floats(file_, found->second, width);
}

std::vector<uint32_t> GltfPrimitive::corners(size_t vertices) const {
    std::vector<uint32_t> out;
    if (decoded_) {
        for (draco::FaceIndex face(0); face < decoded_->mesh->num_faces(); ++face)
            for (int corner = 0; corner < 3; ++corner)
                out.push_back(decoded_->mesh->face(face)[static_cast<size_t>(corner)].value());
    } else if (primitive_.indices >= 0) {
        out = read_indices(file_, primitive_.indices);
    } else {
        out.resize(vertices);
        std::iota(out.begin(), out.end(), 0u);
    }
    for (const uint32_t corner : out)
        if (corner >= vertices)
            throw GltfError(fmt::format("index {} is out of range ({} vertices)", corner, vertices));
    return out;
}

}  // namespace penumbra
