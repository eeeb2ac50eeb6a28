// SPDX-License-Identifier: MIT
// The layout of headers is that of OpenEXR's document "OpenEXR File Layout": magic, version, then attributes
// of a name, a type, a size and so many bytes, up to an empty name.
#include "host/images/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "host/images/input_limit.h"

namespace penumbra {

namespace {

constexpr uint32_t exr_magic = 20000630;
constexpr int64_t largest_axis = 1 << 16;

struct Header {
    int64_t width = 0, height = 0;
    uint64_t channels = 0;
    int64_t tile_width = 1, tile_height = 1;
    uint8_t compression = 0;
};

class HeaderReader {
  public:
    explicit HeaderReader(const std::filesystem::path& path) : stream_(path, std::ios::binary) {
        std::error_code failure;
        const uint64_t bytes = std::filesystem::file_size(path, failure);
        bytes_ = failure ? 0 : bytes;
    }

    uint64_t bytes() const { return bytes_; }

    // Nothing where this is no EXR; an attribute that is larger than the rest of the file makes it none.
    std::optional<Header> read() {
        if (word() != exr_magic) return std::nullopt;
        word();  // version and flags; of several parts the first is read
        Header header;
        for (std::string name = text(); stream_ && !name.empty(); name = text()) {
            const std::string type = text();
            const uint64_t size = word(), at = static_cast<uint64_t>(stream_.tellg());
            if (!stream_ || size > bytes_ - std::min(bytes_, at)) return std::nullopt;
            const auto is = [&](const char* wanted, uint64_t least) {
                return name == wanted && size >= least;
            };
            if (is("dataWindow", 16)) {
                const auto x0 = int32_t(word()), y0 = int32_t(word()), x1 = int32_t(word()),
                           y1 = int32_t(word());
                header.width = int64_t(x1) - x0 + 1;
                header.height = int64_t(y1) - y0 + 1;
            } else if (is("tiles", 8)) {
                header.tile_width = word();
                header.tile_height = word();
            } else if (is("compression", 1)) {
                header.compression = static_cast<uint8_t>(stream_.get());
            } else if (is("channels", 1)) {
                header.channels = count_channels(at + size);
            }
            stream_.seekg(static_cast<std::streamoff>(at + size));
        }
        if (!stream_) return std::nullopt;
        return header;
    }

  private:
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

    uint64_t count_channels(uint64_t end) {  // each a name and 16 bytes
        uint64_t count = 0;
        while (stream_ && static_cast<uint64_t>(stream_.tellg()) < end && !text().empty()) {
            stream_.seekg(16, std::ios::cur);
            ++count;
        }
        return count;
    }

    std::ifstream stream_;
    uint64_t bytes_ = 0;
};

}  // namespace

std::optional<std::string> exr_size_problem(const std::filesystem::path& path) {
    HeaderReader reader(path);
    const std::optional<Header> header = reader.read();
    if (!header) return std::nullopt;
    const auto [width, height, channels, tile_width, tile_height, compression] = *header;
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
    if (!dwa && needed > reader.bytes() * most_per_byte + for_small_files)
        return fmt::format("{} x {} texels of {} channels are more than a file of {} bytes can hold", width,
                           height, channels, reader.bytes());
    return std::nullopt;
}

}  // namespace penumbra
