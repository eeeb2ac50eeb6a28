// SPDX-License-Identifier: MIT
#include "host/models/gltf_extension.h"

#include <fmt/format.h>

#include <algorithm>

namespace penumbra {
namespace {

const char* kind_of(const tinygltf::Value& value) {
    return value.IsString()   ? "a string"
           : value.IsBool()   ? "a boolean"
           : value.IsArray()  ? "an array"
           : value.IsObject() ? "an object"
                              : "null";
}

}  // namespace

double factor(const std::string& what, double value, double most, const GltfTell& tell) {
    if (!(value >= 0)) throw GltfError(fmt::format("{} {} is not a number from 0 on", what, value));
    constexpr double rounding = 1e-3;  // of a factor, less than an 8-bit colour shows
    if (value > most * (1 + rounding)) tell(fmt::format("{} {} is taken as {}", what, value, most));
    return std::min(value, most);
}

int extension_integer(const tinygltf::Value& object, const char* key, const char* extension) {
    if (object.IsObject() && object.Has(key) && object.Get(key).IsNumber())
        return object.Get(key).GetNumberAsInt();
    throw GltfError(fmt::format("{}: \"{}\" is not a number", extension, key));
}

tinygltf::TextureInfo extension_texture(const tinygltf::Value& object, const char* key,
                                        const char* extension) {
    tinygltf::TextureInfo info;
    if (!object.IsObject() || !object.Has(key)) return info;
    const tinygltf::Value& value = object.Get(key);
    info.index = extension_integer(value, "index", extension);
    if (value.Has("texCoord")) info.texCoord = extension_integer(value, "texCoord", extension);
    if (value.Has("extensions"))
        for (const std::string& name : value.Get("extensions").Keys())
            info.extensions[name] = value.Get("extensions").Get(name);
    return info;
}

double extension_number(const tinygltf::Value& object, const char* key, const std::string& extension,
                        double otherwise) {
    if (!object.IsObject() || !object.Has(key)) return otherwise;
    const tinygltf::Value& number = object.Get(key);
    if (number.IsNumber()) return number.GetNumberAsDouble();
    throw GltfError(fmt::format("{}: \"{}\": expected a number, not {}", extension, key, kind_of(number)));
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

}  // namespace penumbra
