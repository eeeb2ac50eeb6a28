// SPDX-License-Identifier: MIT
// PNG (ISO/IEC 15948): chunks of length, type, data, checksum. JPEG (ITU-T T.81): segments behind markers,
// found as stb_image finds them, which passes over what stands between them.
#include "host/images/image_checks.h"

#include <cstdint>

namespace penumbra {
namespace {

class Bytes {
  public:
    explicit Bytes(std::span<const std::byte> bytes) : bytes_(bytes) {}
    bool at_end() const { return at_ >= bytes_.size(); }
    size_t left() const { return bytes_.size() - at_; }
    void skip(size_t count) { at_ += count < left() ? count : left(); }
    // Behind the end: 0, as stb_image reads it.
    uint32_t one() { return at_end() ? 0 : std::to_integer<uint32_t>(bytes_[at_++]); }
    uint32_t two() {
        const uint32_t high = one();
        return high << 8 | one();
    }
    uint32_t four() {
        const uint32_t high = two();
        return high << 16 | two();
    }

  private:
    std::span<const std::byte> bytes_;
    size_t at_ = 0;
};

bool table_fits(Bytes& bytes) {
    // Length, then per table its class and number, how many codes have each of 16 lengths, and their values.
    const uint32_t length = bytes.two();
    for (uint32_t done = 2; done < length && !bytes.at_end();) {
        bytes.one();
        uint32_t codes = 0;
        for (int i = 0; i < 16; ++i) codes += bytes.one();
        if (codes > 256) return false;
        bytes.skip(codes);
        done += 17 + codes;
    }
    return true;
}

// Behind the signature.
bool chunks_fit(Bytes bytes) {
    constexpr uint32_t end = 0x49454e44;
    while (!bytes.at_end()) {
        const uint32_t length = bytes.four();
        if (bytes.four() == end) return true;  // what follows is not read
        if (bytes.left() < 4 || length > bytes.left() - 4) return false;
        bytes.skip(length + size_t{4});
    }
    return true;
}

// Behind the first marker.
bool tables_fit(Bytes bytes) {
    while (!bytes.at_end()) {
        if (bytes.one() != 0xff) continue;
        uint32_t marker = 0xff;
        while (marker == 0xff && !bytes.at_end()) marker = bytes.one();
        constexpr uint32_t tables = 0xc4, end = 0xd9;
        if (marker == end) return true;
        if (marker == 0 || (marker >= 0xd0 && marker <= 0xd7)) continue;  // within a scan
        if (marker == tables) {
            if (!table_fits(bytes)) return false;
        } else {
            const uint32_t length = bytes.two();
            bytes.skip(length < 2 ? 0 : length - 2);
        }
    }
    return true;
}

}  // namespace

bool is_sound_image(std::span<const std::byte> all) {
    Bytes png(all), jpeg(all);
    if (png.four() == 0x89504e47 && png.four() == 0x0d0a1a0a) return chunks_fit(png);
    return jpeg.two() == 0xffd8 && tables_fit(jpeg);
}

}  // namespace penumbra
