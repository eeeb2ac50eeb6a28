// SPDX-License-Identifier: MIT
// Files: shots, models, images. They are read by name, so each process keeps one file of its own in memory.
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "host/images/image_decode.h"
#include "host/images/image_file.h"
#include "host/models/gltf.h"
#include "host/scene/scene.h"
#include "host/shots/shot.h"
#include "tests/fuzz/targets.h"

namespace penumbra::test {
namespace {

// A file in memory with these bytes, and a link to it with the wanted ending.
class MemoryFile {
  public:
    MemoryFile(Bytes bytes, const char* ending) : file_(::memfd_create("input", 0)) {
        if (file_ < 0 || ::write(file_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
            throw std::runtime_error("no file in memory");
        path_ = std::filesystem::temp_directory_path() / ("fuzz_" + std::to_string(::getpid()) + ending);
        std::filesystem::remove(path_);
        std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(file_), path_);
    }
    ~MemoryFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
        ::close(file_);
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    int file_;
    std::filesystem::path path_;
};

// Little, so that a bomb is seen as one and an input takes milliseconds.
void limit_mib(const char* limit) {
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", limit, 1);
}

// A PNG's chunks with the checksums that they ought to have: without them a change never gets to a decoder.
std::vector<std::byte> checked_again(Bytes bytes) {
    constexpr size_t around = 12;  // length, type and checksum
    std::vector<std::byte> out(bytes.begin(), bytes.end());
    const auto byte = [&](size_t at) { return std::to_integer<uint32_t>(out[at]); };
    for (size_t at = 8; out.size() - at >= around;) {
        const uint32_t length = byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3);
        if (length > out.size() - at - around) break;
        const auto sum = static_cast<uint32_t>(
            ::crc32(0, reinterpret_cast<const Bytef*>(&out[at + 4]), static_cast<uInt>(length + 4)));
        for (size_t i = 0; i < 4; ++i) out[at + 8 + length + i] = std::byte(sum >> (24 - 8 * i));
        at += around + length;
    }
    return out;
}

void decode(Bytes bytes) {
    try {
        const RgbaImage image = decode_image(bytes, uint64_t{16} << 20);
        promise(image.rgba.size() == size_t{4} * image.width * image.height, "not four values per texel");
    } catch (const ImageError& error) {
        promise(*error.what() != 0, "an image is refused without a word");
    }
}

}  // namespace

void fuzz_shot(Bytes bytes) {
    const MemoryFile file(bytes, ".shot.json");
    Diagnostics diagnostics;
    const auto shot = read_shot(file.path(), diagnostics);
    promise(shot.has_value() == diagnostics.empty(), "the shot: " + diagnostics.text());
    if (!shot) return;
    for (const uint32_t frame : {0u, shot->frames / 2, shot->frames - 1})
        promise(std::isfinite(sun_at(*shot, frame).to_sun.y), "the sun is nowhere");
}

void fuzz_gltf(Bytes bytes) {
    limit_mib("64");
    const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
    const MemoryFile file(bytes, binary ? ".glb" : ".gltf");
    Diagnostics diagnostics;
    auto model = load_gltf(file.path(), diagnostics);
    promise(model.has_value() == diagnostics.empty(), "the model: " + diagnostics.text());
    if (!model) return;
    for (const Mesh& mesh : model->meshes)
        for (const Part& part : mesh.parts)
            for (const uint32_t index : part.indices)
                promise(index < part.positions.size(), "an index lies outside of its part");
    uint64_t shown = 0;
    for (const Node& node : model->nodes)
        if (node.mesh >= 0)
            for (const Part& part : model->meshes[static_cast<size_t>(node.mesh)].parts)
                shown += part.indices.size();
    if (shown < 100'000) Scene(std::move(*model), Shot{}).triangles(0);
}

void fuzz_exr(Bytes bytes) {
    limit_mib("8");
    const MemoryFile file(bytes, ".exr");
    Diagnostics diagnostics;
    const auto image = read_exr(file.path(), diagnostics);
    promise(image.has_value() == diagnostics.empty(), "the image: " + diagnostics.text());
    if (!image) return;
    for (const Plane& plane : image->planes)
        promise(plane.values.size() + plane.words.size() == size_t{image->width} * image->height,
                "a plane has another size than its image");
}

void fuzz_image(Bytes bytes) {
    decode(bytes);
    if (bytes.size() > 8 && bytes[0] == std::byte{0x89}) decode(checked_again(bytes));
}

}  // namespace penumbra::test
