// SPDX-License-Identifier: MIT
// Reads accessors element by element through a checked view of their bytes.
#include "host/models/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "host/images/input_limit.h"

namespace penumbra {

namespace {

// A model larger than this is an attack or a broken file; it also keeps the products below in 64 bits.
constexpr uint64_t most_elements = uint64_t(1) << 31;

struct Elements {
    const unsigned char* data = nullptr;
    uint64_t stride = 0;
    uint64_t count = 0;
    const unsigned char* at(uint64_t i) const { return data + i * stride; }
};

// `count` elements of `element_bytes` at `offset` of a buffer view, checked to lie inside it and its buffer.
Elements view_elements(const tinygltf::Model& file, int view_index, uint64_t offset, uint64_t count,
                       uint64_t element_bytes, bool may_have_stride) {
    const std::span<const std::byte> bytes = view_bytes(file, view_index);
    const tinygltf::BufferView& view = element(file.bufferViews, view_index, "buffer view");
    const uint64_t stride = may_have_stride && view.byteStride ? view.byteStride : element_bytes;
    if (count > most_elements || stride > 252 + element_bytes) {
        throw GltfError(
            fmt::format("buffer view {} is read with {} elements of stride {}", view_index, count, stride));
    }
    const uint64_t needed = count ? (count - 1) * stride + element_bytes : 0;
    if (offset > bytes.size() || needed > bytes.size() - offset) {
        throw GltfError(fmt::format("an accessor reaches past the end of buffer view {}", view_index));
    }
    return {reinterpret_cast<const unsigned char*>(bytes.data()) + offset, stride, count};
}

template <class T>
T load(const unsigned char* from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
}

template <class T>
float load_number(const unsigned char* from, bool normalized) {
    const float value = static_cast<float>(load<T>(from));
    if constexpr (std::numeric_limits<T>::is_integer) {
        if (normalized) return std::max(value / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
    }
    return value;
}

uint32_t component_bytes(int type) {
    const int bytes = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type));
    if (bytes != 1 && bytes != 2 && bytes != 4)
        throw GltfError(fmt::format("component type {} is not known", type));
    return static_cast<uint32_t>(bytes);
}

float load_component(const unsigned char* from, int type, bool normalized) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return load_number<int8_t>(from, normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return load_number<uint8_t>(from, normalized);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return load_number<int16_t>(from, normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return load_number<uint16_t>(from, normalized);
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return load_number<float>(from, false);
        default:
            throw GltfError(fmt::format("component type {} cannot hold coordinates", type));
    }
}

uint32_t load_index(const unsigned char* from, int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return load<uint8_t>(from);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return load<uint16_t>(from);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return load<uint32_t>(from);
        default:
            throw GltfError(fmt::format("component type {} cannot hold indices", type));
    }
}

const tinygltf::Accessor& checked_accessor(const tinygltf::Model& file, int index, int width) {
    const tinygltf::Accessor& accessor = element(file.accessors, index, "accessor");
    if (tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)) != width) {
        throw GltfError(fmt::format("accessor {} does not have {} components", index, width));
    }
    if (accessor.count > most_elements)
        throw GltfError(fmt::format("accessor {} has {} elements", index, accessor.count));
    return accessor;
}

}  // namespace

std::span<const std::byte> view_bytes(const tinygltf::Model& file, int index) {
    const tinygltf::BufferView& view = element(file.bufferViews, index, "buffer view");
    const std::vector<unsigned char>& data = element(file.buffers, view.buffer, "buffer").data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
        throw GltfError(fmt::format("buffer view {} reaches past the end of its buffer", index));
    return std::as_bytes(std::span(data)).subspan(view.byteOffset, view.byteLength);
}

ReadBudget::ReadBudget(uint64_t file_bytes) : left_(input_limit()), file_bytes_(file_bytes) {
    constexpr uint64_t per_byte = 1024, for_small_files = uint64_t(1) << 20;
    const uint64_t of_file = file_bytes > left_ / per_byte ? left_ : file_bytes * per_byte + for_small_files;
    by_file_ = of_file < left_;
    left_ = std::min(left_, of_file);
}

void ReadBudget::spend(uint64_t bytes) {
    if (bytes > left_)
        throw GltfError(by_file_
                            ? fmt::format("a thousand times what {} bytes of files can hold", file_bytes_)
                            : over_input_limit());
    left_ -= bytes;
}

bool are_finite(std::span<const float> numbers) {
    return std::ranges::all_of(numbers, [](float v) { return std::isfinite(v); });
}

const std::vector<float>& AccessorReader::floats(int accessor, int width) {
    const auto found = floats_.find(accessor);
    if (found == floats_.end()) return floats_[accessor] = read_floats(accessor, width);
    checked_accessor(file_, accessor, width);  // what was read may have been asked for with another width
    return found->second;
}

std::vector<float> AccessorReader::read_floats(int index, int width) {
    const tinygltf::Model& file = file_;
    const tinygltf::Accessor& accessor = checked_accessor(file, index, width);
    const uint64_t step = component_bytes(accessor.componentType);
    const uint64_t element_bytes = step * static_cast<uint64_t>(width);
    std::vector<float> out;
    const auto copy = [&](const unsigned char* from, uint64_t to) {
        for (uint64_t c = 0; c < static_cast<uint64_t>(width); ++c) {
            out[to * static_cast<uint64_t>(width) + c] =
                load_component(from + c * step, accessor.componentType, accessor.normalized);
        }
    };
    Elements elements;
    if (accessor.bufferView >= 0)
        elements = view_elements(file, accessor.bufferView, accessor.byteOffset, accessor.count,
                                 element_bytes, true);
    budget_.spend(accessor.count * static_cast<uint64_t>(width) * sizeof(float));
    out.resize(accessor.count * static_cast<uint64_t>(width));  // zeros, where nothing is stored
    for (uint64_t i = 0; i < elements.count; ++i) copy(elements.at(i), i);
    if (!accessor.sparse.isSparse) return out;

    const auto& sparse = accessor.sparse;
    if (sparse.count < 0) throw GltfError(fmt::format("accessor {} has a negative sparse count", index));
    const uint64_t overrides = static_cast<uint64_t>(sparse.count);
    const Elements where =
        view_elements(file, sparse.indices.bufferView, static_cast<uint64_t>(sparse.indices.byteOffset),
                      overrides, component_bytes(sparse.indices.componentType), false);
    const Elements values =
        view_elements(file, sparse.values.bufferView, static_cast<uint64_t>(sparse.values.byteOffset),
                      overrides, element_bytes, false);
    for (uint64_t i = 0; i < overrides; ++i) {
        const uint32_t target = load_index(where.at(i), sparse.indices.componentType);
        if (target >= accessor.count)
            throw GltfError(fmt::format("accessor {}: sparse index {} is out of range", index, target));
        copy(values.at(i), target);
    }
    return out;
}

std::vector<uint32_t> AccessorReader::indices(int index) {
    const tinygltf::Accessor& accessor = checked_accessor(file_, index, 1);
    if (accessor.sparse.isSparse || accessor.bufferView < 0) {
        throw GltfError(fmt::format("accessor {}: indices must be stored in full", index));
    }
    const Elements elements = view_elements(file_, accessor.bufferView, accessor.byteOffset, accessor.count,
                                            component_bytes(accessor.componentType), false);
    budget_.spend(accessor.count * sizeof(uint32_t));
    std::vector<uint32_t> out(elements.count);
    for (uint64_t i = 0; i < elements.count; ++i) out[i] = load_index(elements.at(i), accessor.componentType);
    return out;
}

}  // namespace penumbra
