// SPDX-License-Identifier: MIT
#include "host/models/gltf_extension.h"

#include <fmt/format.h>

namespace penumbra {

int extension_integer(const tinygltf::Value& object, const char* key, const char* extension) {
    if (object.IsObject() && object.Has(key) && object.Get(key).IsNumber())
        return object.Get(key).GetNumberAsInt();
    throw GltfError(fmt::format("{}: \"{}\" is not a number", extension, key));
}

void extension_numbers(const tinygltf::Value& object, const char* key, const char* extension,
                       std::span<double> out) {
    if (!object.IsObject() || !object.Has(key)) return;
    const tinygltf::Value& list = object.Get(key);
    if (!list.IsArray() || list.ArrayLen() != out.size())
        throw GltfError(fmt::format("{}: \"{}\" is not {} numbers", extension, key, out.size()));
    for (size_t i = 0; i < out.size(); ++i) {
        const tinygltf::Value& number = list.Get(static_cast<int>(i));
        if (!number.IsNumber())
            throw GltfError(fmt::format("{}: \"{}\" is not {} numbers", extension, key, out.size()));
        out[i] = number.GetNumberAsDouble();
    }
}

std::span<const unsigned char> view_bytes(const tinygltf::Model& file, int index) {
    const tinygltf::BufferView& view = element(file.bufferViews, index, "buffer view");
    const std::vector<unsigned char>& data = element(file.buffers, view.buffer, "buffer").data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
        throw GltfError(fmt::format("buffer view {} reaches past the end of its buffer", index));
    return std::span(data).subspan(view.byteOffset, view.byteLength);
}

}  // namespace penumbra
