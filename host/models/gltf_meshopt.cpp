// SPDX-License-Identifier: MIT
#include "host/models/gltf_meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <string>
#include <vector>

#include "host/models/gltf_extension.h"

namespace penumbra {
namespace {

constexpr const char* name = "EXT_meshopt_compression";

std::string text_member(const tinygltf::Value& object, const char* key, const char* otherwise) {
    return object.Has(key) && object.Get(key).IsString() ? object.Get(key).Get<std::string>() : otherwise;
}

// `count` elements of `stride` bytes.
std::vector<unsigned char> decoded(const tinygltf::Value& how, std::span<const unsigned char> source,
                                   size_t count, size_t stride) {
    const std::string mode = text_member(how, "mode", ""), filter = text_member(how, "filter", "NONE");
    std::vector<unsigned char> out(count * stride);
    int failure = -1;
    if (mode == "ATTRIBUTES" && stride % 4 == 0 && stride <= 256)
        failure = meshopt_decodeVertexBuffer(out.data(), count, stride, source.data(), source.size());
    else if (mode == "TRIANGLES" && count % 3 == 0 && (stride == 2 || stride == 4))
        failure = meshopt_decodeIndexBuffer(out.data(), count, stride, source.data(), source.size());
    else if (mode == "INDICES" && (stride == 2 || stride == 4))
        failure = meshopt_decodeIndexSequence(out.data(), count, stride, source.data(), source.size());
    else
        throw GltfError(
            fmt::format("{}: mode \"{}\" with {} elements of {} bytes", name, mode, count, stride));
    if (failure) throw GltfError(fmt::format("{}: a buffer view cannot be decoded", name));
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
        meshopt_decodeFilterOct(out.data(), count, stride);
    else if (filter == "QUATERNION" && stride == 8)
        meshopt_decodeFilterQuat(out.data(), count, stride);
    else if (filter == "EXPONENTIAL" && stride % 4 == 0)
        meshopt_decodeFilterExp(out.data(), count, stride);
    else if (filter != "NONE")
        throw GltfError(fmt::format("{}: there is no filter \"{}\" of {} bytes", name, filter, stride));
    return out;
}

}  // namespace

void decode_meshopt(tinygltf::Model& file, ReadBudget& budget) {
    for (tinygltf::BufferView& view : file.bufferViews) {
        const auto found = view.extensions.find(name);
        if (found == view.extensions.end()) continue;
        const tinygltf::Value& how = found->second;
        const auto number = [&](const char* key, int64_t most) {
            const int64_t value = extension_integer(how, key, name);
            if (value < 0 || value > most) throw GltfError(fmt::format("{}: \"{}\" is {}", name, key, value));
            return static_cast<size_t>(value);
        };
        const std::vector<unsigned char>& data =
            element(file.buffers, extension_integer(how, "buffer", name), "buffer").data;
        const size_t offset = how.Has("byteOffset") ? number("byteOffset", INT32_MAX) : 0,
                     length = number("byteLength", INT32_MAX), stride = number("byteStride", 256),
                     count = number("count", 1 << 28);
        if (offset > data.size() || length > data.size() - offset)
            throw GltfError(fmt::format("{}: a buffer view reaches past the end of its buffer", name));
        budget.spend(uint64_t{count} * stride);
        if (stride == 0) throw GltfError(fmt::format("{}: elements of no bytes", name));
        tinygltf::Buffer buffer;
        buffer.data = decoded(how, std::span(data).subspan(offset, length), count, stride);
        view.byteOffset = 0;
        view.byteLength = buffer.data.size();
        view.buffer = static_cast<int>(file.buffers.size());
        file.buffers.push_back(std::move(buffer));
    }
}

}  // namespace penumbra
