// SPDX-License-Identifier: MIT
// The layout of headers is that of OpenEXR's document "OpenEXR File Layout": magic, version, then attributes
// of a name, a type, a size and so many bytes, up to an empty name; of several parts one header after the
// other, up to one without attributes.
#include "host/images/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "host/images/input_limit.h"

namespace penumbra {

namespace {

constexpr uint32_t exr_magic = 20000630, deep_parts = 0x800, several_parts = 0x1000;
constexpr int64_t largest_axis = 1 << 16;

// Of the types whose values are all as long: OpenEXR reads so many bytes, whatever the file says.
constexpr std::pair<std::string_view, uint64_t> value_bytes[] = {{"box2f", 16},
                                                                 {"box2i", 16},
                                                                 {"chromaticities", 32},
                                                                 {"compression", 1},
                                                                 {"deepImageState", 1},
                                                                 {"double", 8},
                                                                 {"envmap", 1},
                                                                 {"float", 4},
                                                                 {"int", 4},
                                                                 {"keycode", 28},
                                                                 {"lineOrder", 1},
                                                                 {"m33d", 72},
                                                                 {"m33f", 36},
                                                                 {"m44d", 128},
                                                                 {"m44f", 64},
                                                                 {"rational", 8},
                                                                 {"tiledesc", 9},
                                                                 {"timecode", 8},
                                                                 {"v2d", 16},
                                                                 {"v2f", 8},
                                                                 {"v2i", 8},
                                                                 {"v3d", 24},
                                                                 {"v3f", 12},
                                                                 {"v3i", 12}};

struct Header {
    int64_t width = 0, height = 0;
    uint64_t channels = 0;
    int64_t tile_width = 1, tile_height = 1;
    uint8_t compression = 0;
    bool deep = false;   // any number of samples per texel
    std::string broken;  // why it ends here
};

class HeaderReader {
  public:
    explicit HeaderReader(const std::filesystem::path& path) : stream_(path, std::ios::binary) {
        std::error_code failure;
        const uint64_t bytes = std::filesystem::file_size(path, failure);
        bytes_ = failure ? 0 : bytes;
    }

    uint64_t bytes() const { return bytes_; }

    // Of every part, since OpenEXR reads them all; nothing where this is no EXR. One that is broken is the
    // last.
    std::vector<Header> read() {
        if (word() != exr_magic) return {};
        const uint32_t version = word();
        const bool several = version & several_parts;
        std::vector<Header> headers;
        do {
            Header header;
            header.deep = version & deep_parts;
            if (!read_part(header) && several && header.broken.empty()) break;
            headers.push_back(std::move(header));
        } while (several && headers.back().broken.empty());
        return headers;
    }

  private:
    // Whether it has attributes.
    bool read_part(Header& header) {
        bool any = false;
        for (std::string name = text(); stream_ && !name.empty(); name = text()) {
            any = true;
            const std::string type = text();
            const uint64_t size = word();
            if (!stream_) break;
            const auto at = static_cast<uint64_t>(stream_.tellg());
            if (size > bytes_ - std::min(bytes_, at)) {
                header.broken =
                    fmt::format("attribute \"{}\" claims {} bytes, more than the file has", name, size);
                return any;
            }
            if (!is_whole(type, at, size)) {
                header.broken = fmt::format("attribute \"{}\": {} bytes are no {}", name, size, type);
                return any;
            }
            seek(at);
            const auto is = [&](const char* wanted, const char* of_type) {
                return name == wanted && type == of_type;
            };
            if (is("dataWindow", "box2i")) {
                const auto x0 = int32_t(word()), y0 = int32_t(word()), x1 = int32_t(word()),
                           y1 = int32_t(word());
                header.width = int64_t(x1) - x0 + 1;
                header.height = int64_t(y1) - y0 + 1;
            } else if (is("tiles", "tiledesc")) {
                header.tile_width = word();
                header.tile_height = word();
            } else if (is("compression", "compression")) {
                header.compression = static_cast<uint8_t>(stream_.get());
            } else if (is("type", "string")) {
                std::string kind(std::min<uint64_t>(size, 4), ' ');
                stream_.read(kind.data(), static_cast<std::streamsize>(kind.size()));
                header.deep = header.deep || kind == "deep";
            } else if (is("channels", "chlist")) {
                header.channels = count_channels(at + size).value_or(0);
            }
            seek(at + size);
        }
        if (!stream_) header.broken = "the header is not whole";
        return any;
    }

    uint32_t word() {
        unsigned char b[4] = {};
        stream_.read(reinterpret_cast<char*>(b), 4);
        return uint32_t(b[0]) | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
    }

    std::string text() {  // at most 255 characters, and a zero
        std::string out;
        for (int c = stream_.get(); stream_ && c != 0; c = stream_.get()) {
            out += static_cast<char>(c);
            if (out.size() > 255) stream_.setstate(std::ios::failbit);
        }
        return out;
    }

    void seek(uint64_t at) { stream_.seekg(static_cast<std::streamoff>(at)); }
    bool is_at(uint64_t end) { return stream_ && static_cast<uint64_t>(stream_.tellg()) == end; }

    // Each is a name and 16 bytes, behind the last one is an empty name; nothing where that is not the end.
    std::optional<uint64_t> count_channels(uint64_t end) {
        uint64_t count = 0;
        while (!text().empty()) {
            stream_.seekg(16, std::ios::cur);
            ++count;
        }
        return is_at(end) ? std::optional(count) : std::nullopt;
    }

    // Whether a value of the type ends where the attribute does, so that OpenEXR, which goes by the type,
    // finds the next attribute at the same place. Of types that it does not know it skips what it is told to.
    bool is_whole(std::string_view type, uint64_t at, uint64_t size) {
        const auto* const known =
            std::ranges::find(value_bytes, type, &std::pair<std::string_view, uint64_t>::first);
        if (known != std::end(value_bytes)) return size == known->second;
        seek(at);
        if (type == "chlist") return count_channels(at + size).has_value();
        if (type == "preview") {
            const uint64_t width = word(), height = word();
            return size == 8 + 4 * width * height;
        }
        if (type == "stringvector") {
            for (uint64_t left = size; left > 0;) {
                const uint64_t length = left >= 4 ? word() : left;
                if (!stream_ || left < 4 || length > left - 4) return false;
                left -= 4 + length;
                stream_.seekg(static_cast<std::streamoff>(length), std::ios::cur);
            }
        }
        return type != "floatvector" || size % 4 == 0;
    }

    std::ifstream stream_;
    uint64_t bytes_ = 0;
};

// Of a part of a file of so many bytes.
std::optional<std::string> problem_of(const Header& header, uint64_t bytes) {
    const auto& [width, height, channels, tile_width, tile_height, compression, deep, broken] = header;
    if (!broken.empty()) return broken;
    // Nor does OpenEXR free all of what it has read when such a file breaks off.
    if (deep) return "deep images are not supported";
    if (width < 1 || height < 1 || width > largest_axis || height > largest_axis)
        return fmt::format("an image of {} x {} texels is not supported", width, height);
    if (tile_width < 1 || tile_height < 1 || tile_width > largest_axis || tile_height > largest_axis)
        return fmt::format("tiles of {} x {} texels are not supported", tile_width, tile_height);
    const auto whole = [](int64_t texels, int64_t tile) {
        return uint64_t((texels + tile - 1) / tile * tile);
    };
    const uint64_t needed = whole(width, tile_width) * whole(height, tile_height) * channels * sizeof(float);
    if (needed > input_limit())
        return fmt::format("{} x {} texels of {} channels take {}", width, height, channels,
                           over_input_limit());
    // Deflate makes a byte of at most 1032, runs and wavelets less; half floats are held as floats. The lossy
    // DWA, which keeps one coefficient of a flat block of 64, is left to the limit above.
    constexpr uint64_t most_per_byte = 4096, for_small_files = uint64_t(1) << 20;
    const bool dwa = compression == 8 || compression == 9;
    if (!dwa && needed > bytes * most_per_byte + for_small_files)
        return fmt::format("{} x {} texels of {} channels are more than a file of {} bytes can hold", width,
                           height, channels, bytes);
    return std::nullopt;
}

}  // namespace

std::optional<std::string> exr_size_problem(const std::filesystem::path& path) {
    HeaderReader reader(path);
    for (const Header& header : reader.read())
        if (auto problem = problem_of(header, reader.bytes())) return problem;
    return std::nullopt;
}

}  // namespace penumbra
