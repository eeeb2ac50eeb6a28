// SPDX-License-Identifier: MIT
// tinygltf hands images over as a pointer into a buffer that it has not compared with the buffer's size, so
// nothing is decoded while it parses; and it would read whatever it is pointed at, a device or a pipe among
// them.
#include "host/models/gltf_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <fstream>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/images/input_limit.h"
#include "host/models/gltf_accessor.h"
#include "host/models/gltf_text.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

struct Reading {
    uint64_t limit = 0, bytes = 0;
    std::vector<uint64_t> lengths;  // of the files that are buffers, which are the first ones that are read
    size_t next_length = 0;
    std::vector<std::vector<std::byte>> loose_images;
};

// A path takes far more memory than its text: of a URI that is too long to be one, none is made.
constexpr size_t longest_path = 4096;

bool is_file(const std::string& name, void*) {
    std::error_code failure;
    return name.size() <= longest_path && std::filesystem::is_regular_file(name, failure);
}

std::string as_it_is(const std::string& name, void*) {
    return name;
}

bool read_whole(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* data) {
    Reading& reading = *static_cast<Reading*>(data);
    std::error_code failure;
    uint64_t size = is_file(name, nullptr) ? std::filesystem::file_size(name, failure) : 0;
    if (!is_file(name, nullptr) || failure) {
        *error += "no regular file";
        return false;
    }
    if (reading.next_length < reading.lengths.size())
        size = std::min(size, reading.lengths[reading.next_length++]);
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

// Without what a terminal would take as a command.
std::string printable(std::string_view text) {
    std::string out(text);
    std::ranges::replace_if(
        out, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return out;
}

// At most `most` bytes, and no part of a character.
std::string cut(std::string_view text, size_t most) {
    if (text.size() <= most) return printable(text);
    size_t end = most - 3;
    while (end > 0 && (text[end] & 0xC0) == 0x80) --end;
    return printable(text.substr(0, end)) + "...";
}

// Without all of what a file may have in one word, a whole buffer among them.
std::string one_line(std::string_view text) {
    constexpr size_t longest_word = 200, quoted = 80, longest = 1000;
    std::string out;
    while (!text.empty()) {
        const std::string_view word = text.substr(0, text.find_first_of(" \n"));
        text.remove_prefix(std::min(word.size() + 1, text.size()));
        if (!word.empty())
            out += (out.empty() ? "" : " ") + cut(word, word.size() > longest_word ? quoted : longest_word);
    }
    return cut(out, longest);
}

std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

// A file that is there and may be meant by a name that is none: in another case, with \ for /, or in the
// model's own folder.
std::string meant_by(std::string name, const fs::path& folder) {
    std::ranges::replace(name, '\\', '/');
    fs::path found;
    std::error_code failure;
    for (const fs::path& part : fs::path(name).relative_path()) {
        fs::path next = fs::exists(folder / found / part, failure) ? part : fs::path();
        for (fs::directory_iterator entry(folder / found, failure);
             next.empty() && !failure && entry != fs::directory_iterator(); entry.increment(failure))
            if (lower(entry->path().filename().string()) == lower(part.string()))
                next = entry->path().filename();
        if (next.empty()) break;
        found /= next;
    }
    if (fs::is_regular_file(folder / found, failure)) return found.generic_string();
    const size_t slash = name.rfind('/');
    return slash == name.npos ? "" : meant_by(name.substr(slash + 1), folder);
}

// Why the files of images were not read, by image. The parser has its reasons for all of them in one text.
std::vector<std::string> unread_images(const GltfFiles& files, const fs::path& folder) {
    int hints_left = 32;  // each looks through folders
    std::vector<std::string> out(files.model.images.size());
    for (size_t i = 0; i < out.size(); ++i) {
        const tinygltf::Image& image = files.model.images[i];
        if (image.bufferView >= 0 || !files.loose_images[i].empty()) continue;
        const std::string name = percent_decoded(image.uri);
        const bool may_be_path = name.size() <= longest_path;
        std::error_code failure;
        if (may_be_path && fs::is_regular_file(folder / name, failure)) {
            out[i] = fs::file_size(folder / name, failure) == 0
                         ? "is empty"
                         : "cannot be read (it is locked, or the model's files are together " +
                               over_input_limit() + ")";
            continue;
        }
        out[i] = name.starts_with("data:") ? "cannot be read (its data: has no base64)" : "is not there";
        const std::string meant = may_be_path && hints_left-- > 0 ? meant_by(name, folder) : "";
        if (!meant.empty()) out[i] += fmt::format(" (did you mean \"{}\"?)", printable(meant));
    }
    return out;
}

// What is wrong with a file that is no glTF, or not all of one; else nothing.
std::string not_gltf(std::string_view bytes) {
    if (bytes.empty()) return "is empty";
    if (bytes.starts_with("glTF")) {
        constexpr size_t header = 12;
        uint32_t length = 0;
        if (bytes.size() >= header) std::memcpy(&length, bytes.data() + 8, sizeof length);
        if (bytes.size() >= std::max<size_t>(header, length)) return "";
        return fmt::format("is cut off: {} bytes of the {} that its header says", bytes.size(),
                           std::max<size_t>(header, length));
    }
    const size_t bom = bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0,
                 first = bytes.find_first_not_of(" \t\r\n", bom);
    if (first != bytes.npos && bytes[first] == '{') return "";
    constexpr size_t quoted = 48;
    const std::string_view words = bytes.substr(0, quoted);
    const auto end = std::ranges::find_if_not(words, [](char c) { return c >= ' ' && c <= '~'; });
    if (end == words.begin()) return "is no glTF";
    return fmt::format("begins with \"{}\", which is no glTF", std::string(words.begin(), end));
}

// Of an asset's minVersion, which is there or empty. What is no version is none that is read.
bool is_beyond_2_0(std::string_view version) {
    if (version.empty()) return false;
    unsigned major = 0, minor = 0;
    const char* const end = version.data() + version.size();
    auto read = std::from_chars(version.data(), end, major);
    if (read.ec == std::errc() && read.ptr != end && *read.ptr == '.')
        read = std::from_chars(read.ptr + 1, end, minor);
    return read.ec != std::errc() || read.ptr != end || std::pair(major, minor) > std::pair(2u, 0u);
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
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (const std::string why = not_gltf(all); !why.empty()) return refuse(why);
    const bool is_binary = all.starts_with("glTF");
    const std::string_view document = document_of(all);
    if (document.size() > largest_document())
        return refuse(fmt::format("its JSON of {} bytes would take {}", document.size(), over_input_limit()));
    if (is_nested_too_deep(document)) return refuse("its JSON is nested more than 256 levels deep");
    if (const std::string version = old_version(bytes); !version.empty())
        return refuse(fmt::format("is glTF {}; this program reads glTF 2.0", version));
    ReadableGltf readable = make_readable(bytes);
    if (!readable.wrong.empty()) return refuse(readable.wrong);
    reading.lengths = std::move(readable.lengths);

    GltfFiles files;
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_image, &reading);
    loader.SetFsCallbacks({is_file, as_it_is, read_whole, nullptr, &reading});
    const std::string folder = path.parent_path().string();
    const auto size = static_cast<unsigned int>(bytes.size());
    if (size != bytes.size()) return refuse("a glTF has less than 4 GiB");
    const bool good =
        is_binary ? loader.LoadBinaryFromMemory(&files.model, &error, &warning, bytes.data(), size, folder)
                  : loader.LoadASCIIFromString(&files.model, &error, &warning,
                                               reinterpret_cast<const char*>(bytes.data()), size, folder);
    // The library puts what its parser throws into words; what a file says may stand in those of others.
    if (!good && error == std::bad_alloc().what()) throw std::bad_alloc();
    if (!good) return refuse("not a valid glTF 2.0 file: " + one_line(error));
    if (const std::string& least = files.model.asset.minVersion; is_beyond_2_0(least))
        return refuse(fmt::format("needs glTF {}; this program reads glTF 2.0", cut(least, 20)));
    files.loose_images = std::move(reading.loose_images);
    files.loose_images.resize(files.model.images.size());
    files.bytes = reading.bytes;
    files.unread = unread_images(files, path.parent_path());
    return files;
}

std::string image_name(const tinygltf::Model& file, size_t image) {
    const std::string &uri = file.images.at(image).uri, &name = file.images.at(image).name;
    if (uri.empty() && name.empty()) return fmt::format("image {}", image);
    constexpr size_t longest = 80;
    // Asked for each material, of a text that may be long: no more of it is decoded than is shown.
    const std::string start = (uri.empty() ? name : uri).substr(0, 3 * longest + 3);
    return fmt::format("image \"{}\"", cut(uri.empty() ? start : percent_decoded(start), longest));
}

std::span<const std::byte> encoded_image(const GltfFiles& files, size_t image) {
    const int view = files.model.images.at(image).bufferView;
    if (view < 0) return files.loose_images.at(image);
    return view_bytes(files.model, view);
}

}  // namespace penumbra
