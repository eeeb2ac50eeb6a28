// SPDX-License-Identifier: MIT
// libpng reports errors by longjmp: whatever has a destructor lives in a PngReading, outside of the function
// that it jumps back into.
#include <png.h>

#include <cstring>
#include <string>

#include "host/images/image_decode.h"

namespace penumbra {
namespace {

struct PngReading {
    explicit PngReading(std::span<const std::byte> bytes) : left(bytes) {}
    ~PngReading() { png_destroy_read_struct(&png, &info, nullptr); }
    PngReading(const PngReading&) = delete;
    PngReading& operator=(const PngReading&) = delete;

    png_structp png = nullptr;
    png_infop info = nullptr;
    std::span<const std::byte> left;
    RgbaImage image;
    char problem[128] = {};
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
    auto& reading = *static_cast<PngReading*>(png_get_error_ptr(png));
    std::strncpy(reading.problem, text, sizeof reading.problem - 1);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void give(png_structp png, png_bytep to, size_t count) {
    auto& reading = *static_cast<PngReading*>(png_get_io_ptr(png));
    if (count > reading.left.size()) png_error(png, "the file ends early");
    std::memcpy(to, reading.left.data(), count);
    reading.left = reading.left.subspan(count);
}

// Size and kind of texels; false with `problem`.
bool read_header(PngReading& reading) {
    if (setjmp(png_jmpbuf(reading.png))) return false;
    // Nothing but the texels: text and profiles may be bombs of their own.
    png_set_keep_unknown_chunks(reading.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(reading.png, reading.info);
    return true;
}

// Into image.rgba, which has room.
bool read_texels(PngReading& reading) {
    if (setjmp(png_jmpbuf(reading.png))) return false;
    png_set_expand(reading.png);    // palettes, fewer bits than 8, the colour that is transparent
    png_set_scale_16(reading.png);  // rounds
    png_set_gray_to_rgb(reading.png);
    png_set_add_alpha(reading.png, 0xff, PNG_FILLER_AFTER);
    const int passes = png_set_interlace_handling(reading.png);
    png_read_update_info(reading.png, reading.info);
    const size_t row = size_t{4} * reading.image.width;
    if (png_get_rowbytes(reading.png, reading.info) != row)
        png_error(reading.png, "not four values per texel");
    for (int pass = 0; pass < passes; ++pass)
        for (uint32_t y = 0; y < reading.image.height; ++y)
            png_read_row(reading.png, reading.image.rgba.data() + y * row, nullptr);
    png_read_end(reading.png, nullptr);
    return true;
}

}  // namespace

RgbaImage decode_png(std::span<const std::byte> bytes, uint64_t limit) {
    PngReading reading(bytes);
    const auto fail = [&] { throw ImageError(std::string("PNG: ") + reading.problem); };
    reading.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, on_error, on_warning);
    if (reading.png) reading.info = png_create_info_struct(reading.png);
    if (!reading.info) throw std::bad_alloc();
    png_set_read_fn(reading.png, &reading, give);
    if (!read_header(reading)) fail();
    reading.image.width = png_get_image_width(reading.png, reading.info);
    reading.image.height = png_get_image_height(reading.png, reading.info);
    const uint64_t texels = uint64_t{reading.image.width} * reading.image.height;
    if (texels > limit / 4)
        throw ImageError("PNG: " + std::to_string(reading.image.width) + " x " +
                         std::to_string(reading.image.height) + " texels are more than the limit");
    // DEFLATE makes of a byte 1032 at the most (RFC 1951: 258 in two bits).
    if (png_get_rowbytes(reading.png, reading.info) * uint64_t{reading.image.height} > bytes.size() * 1032)
        throw ImageError("PNG: more texels than the file can hold");
    reading.image.rgba.resize(texels * 4);
    if (!read_texels(reading)) fail();
    return std::move(reading.image);
}

}  // namespace penumbra
