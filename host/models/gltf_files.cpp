// SPDX-License-Identifier: MIT
// tinygltf hands images over as a pointer into a buffer that it has not compared with the buffer's size, so
// nothing is decoded while it parses; and it would read whatever it is pointed at, a device or a pipe among
// them.
#include "host/models/gltf_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <new>
#include <string_view>

#include "host/images/input_limit.h"
#include "host/models/gltf_accessor.h"
#include "host/models/gltf_text.h"

namespace penumbra {

namespace {

struct Reading {
    uint64_t limit = 0, bytes = 0;
    std::vector<std::vector<std::byte>> loose_images;
};

bool is_file(const std::string& name, void*) {
    std::error_code failure;
    return std::filesystem::is_regular_file(name, failure);
}

std::string as_it_is(const std::string& name, void*) {
    return name;
}

bool read_whole(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* data) {
    Reading& reading = *static_cast<Reading*>(data);
    std::error_code failure;
    const uint64_t size = is_file(name, nullptr) ? std::filesystem::file_size(name, failure) : 0;
    if (!is_file(name, nullptr) || failure) {
        *error += "no regular file";
        return false;
    }
    if (size > reading.limit - reading.bytes) {
        *error += over_input_limit();
        return false;
    }
    reading.bytes += size;
    out->resize(size);
    std::ifstream stream(name, std::ios::binary);
    stream.read(reinterpret_cast<char*>(out->data()), static_cast<std::streamsize>(size));
    if (!stream) *error += "cannot be read";
    return static_cast<bool>(stream);
}

// Takes every image: what it is shows when it is decoded. Bytes of a buffer are found again by their buffer
// view.
bool keep_image(tinygltf::Image* image, const int index, std::string*, std::string*, int, int,
                const unsigned char* bytes, int size, void* data) {
    if (image->bufferView >= 0) return true;
    auto& kept = static_cast<Reading*>(data)->loose_images;
    kept.resize(std::max(kept.size(), static_cast<size_t>(index) + 1));
    const std::span loose(reinterpret_cast<const std::byte*>(bytes), static_cast<size_t>(size));
    kept[static_cast<size_t>(index)].assign(loose.begin(), loose.end());
    return true;
}

std::string one_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    std::ranges::replace(text, '\n', ' ');
    return text;
}

// tinygltf walks "extras" and extensions by recursion, on whatever stack there is.
bool is_nested_too_deep(std::string_view json) {
    constexpr size_t deepest = 256;
    size_t depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (quoted && c == '\\') ++i;
        if (c == '"') quoted = !quoted;
        if (quoted) continue;
        if ((c == '[' || c == '{') && ++depth > deepest) return true;
        if ((c == ']' || c == '}') && depth > 0) --depth;
    }
    return false;
}

bool is_binary(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".glb" || extension == ".vrm";
}

}  // namespace

std::optional<GltfFiles> read_gltf_files(const std::filesystem::path& path, Diagnostics& diagnostics) {
    const Place place{path.string(), 0, 0};
    const auto refuse = [&](const std::string& why) {
        diagnostics.add(place, "", why);
        return std::nullopt;
    };
    std::error_code failure;
    if (std::filesystem::is_directory(path, failure)) return refuse("is a folder");
    if (!std::filesystem::is_regular_file(path, failure)) return refuse("no such file");
    Reading reading;
    reading.limit = input_limit();
    std::vector<unsigned char> bytes;
    std::string error, warning;
    if (!read_whole(&bytes, &error, path.string(), &reading)) return refuse(error);
    const std::string_view document =
        document_of({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (document.size() > largest_document())
        return refuse(fmt::format("its JSON of {} bytes would take {}", document.size(), over_input_limit()));
    if (is_nested_too_deep(document)) return refuse("its JSON is nested more than 256 levels deep");
    if (const std::string version = old_version(bytes); !version.empty())
        return refuse(fmt::format("is glTF {}; this program reads glTF 2.0", version));
    make_readable(bytes);

    GltfFiles files;
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_image, &reading);
    loader.SetFsCallbacks({is_file, as_it_is, read_whole, nullptr, &reading});
    const std::string folder = path.parent_path().string();
    const auto size = static_cast<unsigned int>(bytes.size());
    if (size != bytes.size()) return refuse("a glTF has less than 4 GiB");
    const bool good =
        is_binary(path)
            ? loader.LoadBinaryFromMemory(&files.model, &error, &warning, bytes.data(), size, folder)
            : loader.LoadASCIIFromString(&files.model, &error, &warning,
                                         reinterpret_cast<const char*>(bytes.data()), size, folder);
    // The library puts what its parser throws into words; what a file says may stand in those of others.
    if (!good && error == std::bad_alloc().what()) throw std::bad_alloc();
    if (!good) return refuse("not a valid glTF 2.0 file: " + one_line(error));
    files.loose_images = std::move(reading.loose_images);
    files.loose_images.resize(files.model.images.size());
    files.bytes = reading.bytes;
    files.warnings = one_line(warning);
    return files;
}

std::span<const std::byte> encoded_image(const GltfFiles& files, size_t image) {
    const int view = files.model.images.at(image).bufferView;
    if (view < 0) return files.loose_images.at(image);
    return view_bytes(files.model, view);
}

}  // namespace penumbra
