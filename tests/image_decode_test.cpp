// SPDX-License-Identifier: MIT
// Every kind of PNG and JPEG that its library writes comes back as 8-bit RGBA; what is cut short, damaged or
// claims more than it holds is refused with a word.
#include "host/images/image_decode.h"

#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

namespace penumbra {
namespace {

using Texels = std::vector<uint8_t>;
constexpr uint64_t plenty = 1 << 20;

struct Png {
    uint32_t width, height;
    int bits, kind;
    Texels rows;  // as the format has them
    int interlace = PNG_INTERLACE_NONE;
    std::vector<png_color> palette;
    Texels palette_alpha;
    bool gamma = false;
};

std::string encode(const Png& image) {
    std::string out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    const auto append = [](png_structp to, png_bytep bytes, size_t count) {
        static_cast<std::string*>(png_get_io_ptr(to))->append(reinterpret_cast<char*>(bytes), count);
    };
    png_set_write_fn(png, &out, append, nullptr);
    png_set_IHDR(png, info, image.width, image.height, image.bits, image.kind, image.interlace,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (!image.palette.empty())
        png_set_PLTE(png, info, image.palette.data(), static_cast<int>(image.palette.size()));
    if (!image.palette_alpha.empty())
        png_set_tRNS(png, info, image.palette_alpha.data(), static_cast<int>(image.palette_alpha.size()),
                     nullptr);
    if (image.gamma) png_set_gAMA(png, info, 1.0);
    png_write_info(png, info);
    const size_t row = image.rows.size() / image.height;
    std::vector<png_bytep> rows;
    for (uint32_t y = 0; y < image.height; ++y)
        rows.push_back(const_cast<png_bytep>(image.rows.data()) + y * row);
    png_write_image(png, rows.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return out;
}

enum class Scans { one, usual, per_coefficient };

std::string encode_jpeg(J_COLOR_SPACE space, int channels, uint32_t size, const Texels& one, Scans scans) {
    jpeg_compress_struct jpeg{};
    jpeg_error_mgr errors{};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char* bytes = nullptr;
    unsigned long count = 0;
    jpeg_mem_dest(&jpeg, &bytes, &count);
    jpeg.image_width = jpeg.image_height = size;
    jpeg.input_components = channels;
    jpeg.in_color_space = space;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    if (scans == Scans::usual) jpeg_simple_progression(&jpeg);
    std::vector<jpeg_scan_info> script;
    if (scans == Scans::per_coefficient) {  // and bit plane
        script.push_back({1, {0}, 0, 0, 0, 0});
        for (int k = 1; k < 64; ++k)
            for (const int low : {1, 0}) script.push_back({1, {0}, k, k, low ? 0 : 1, low});
        jpeg.scan_info = script.data();
        jpeg.num_scans = static_cast<int>(script.size());
    }
    jpeg_start_compress(&jpeg, TRUE);
    Texels row;
    for (uint32_t x = 0; x < size; ++x) row.insert(row.end(), one.begin(), one.end());
    JSAMPROW from = row.data();
    while (jpeg.next_scanline < jpeg.image_height) jpeg_write_scanlines(&jpeg, &from, 1);
    jpeg_finish_compress(&jpeg);
    std::string out(reinterpret_cast<char*>(bytes), count);
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
    return out;
}

RgbaImage decode(const std::string& bytes, uint64_t limit = plenty) {
    return decode_image(std::as_bytes(std::span(bytes)), limit);
}

std::string refusal(const std::string& bytes, uint64_t limit = plenty) {
    try {
        decode(bytes, limit);
    } catch (const ImageError& error) {
        return error.what();
    }
    return "";
}

TEST(ImageDecode, EveryKindOfPngBecomesRgba) {
    const struct {
        const char* what;
        Png image;
        Texels rgba;
    } cases[] = {
        {"grey", {2, 1, 8, PNG_COLOR_TYPE_GRAY, {7, 200}}, {7, 7, 7, 255, 200, 200, 200, 255}},
        {"a bit", {2, 1, 1, PNG_COLOR_TYPE_GRAY, {0x40}}, {0, 0, 0, 255, 255, 255, 255, 255}},
        {"grey, alpha", {1, 2, 8, PNG_COLOR_TYPE_GRAY_ALPHA, {9, 3, 8, 0}}, {9, 9, 9, 3, 8, 8, 8, 0}},
        {"colours", {1, 2, 8, PNG_COLOR_TYPE_RGB, {1, 2, 3, 4, 5, 6}}, {1, 2, 3, 255, 4, 5, 6, 255}},
        {"16 bits", {1, 1, 16, PNG_COLOR_TYPE_RGB, {0x12, 0xff, 0xff, 0xff, 0, 0x10}}, {0x13, 255, 0, 255}},
        {"palette",
         {2, 1, 4, PNG_COLOR_TYPE_PALETTE, {0x10}, PNG_INTERLACE_NONE, {{1, 2, 3}, {4, 5, 6}}, {77}},
         {4, 5, 6, 255, 1, 2, 3, 77}},
        {"of another gamma",
         {1, 1, 8, PNG_COLOR_TYPE_RGB, {50, 100, 150}, PNG_INTERLACE_NONE, {}, {}, true},
         {50, 100, 150, 255}}};
    for (const auto& one : cases) {
        const RgbaImage image = decode(encode(one.image));
        EXPECT_EQ(image.width, one.image.width) << one.what;
        EXPECT_EQ(image.height, one.image.height) << one.what;
        EXPECT_EQ(image.rgba, one.rgba) << one.what;
    }
}

TEST(ImageDecode, AnInterlacedPngIsThatPng) {
    Png image{13, 11, 8, PNG_COLOR_TYPE_RGBA, {}};
    for (int i = 0; i < 13 * 11 * 4; ++i) image.rows.push_back(static_cast<uint8_t>(i * 37));
    EXPECT_EQ(decode(encode(image)).rgba, image.rows);
    image.interlace = PNG_INTERLACE_ADAM7;
    EXPECT_EQ(decode(encode(image)).rgba, image.rows);
}

TEST(ImageDecode, EveryKindOfJpegBecomesRgba) {
    const struct {
        J_COLOR_SPACE space;
        Texels one;
        std::array<int, 3> rgb;
    } cases[] = {{JCS_GRAYSCALE, {90}, {90, 90, 90}},
                 {JCS_RGB, {200, 100, 50}, {200, 100, 50}},
                 {JCS_CMYK, {200, 100, 50, 128}, {100, 50, 25}}};  // inverted, as Adobe has them
    for (const auto& one : cases) {
        for (const Scans scans : {Scans::one, Scans::usual}) {
            const RgbaImage image =
                decode(encode_jpeg(one.space, static_cast<int>(one.one.size()), 17, one.one, scans));
            EXPECT_EQ(image.width, 17u);
            ASSERT_EQ(image.rgba.size(), size_t{17} * 17 * 4);
            for (size_t i = 0; i < image.rgba.size(); ++i)
                ASSERT_NEAR(image.rgba[i], i % 4 == 3 ? 255 : one.rgb[i % 4], 3) << one.space << " at " << i;
        }
    }
}

// No beginning of a file is taken for the whole, and a PNG's checksums are believed.
TEST(ImageDecode, WhatIsCutShortOrDamagedIsRefused) {
    Png image{9, 7, 8, PNG_COLOR_TYPE_RGB, {}};
    for (int i = 0; i < 9 * 7 * 3; ++i) image.rows.push_back(static_cast<uint8_t>(i * i));
    const std::string png = encode(image);
    for (const std::string& whole : {png, encode_jpeg(JCS_RGB, 3, 40, {200, 100, 50}, Scans::one),
                                     encode_jpeg(JCS_RGB, 3, 40, {200, 100, 50}, Scans::usual),
                                     encode_jpeg(JCS_CMYK, 4, 40, {200, 100, 50, 9}, Scans::one)}) {
        EXPECT_EQ(refusal(whole), "");
        for (size_t length = 0; length < whole.size(); ++length)
            EXPECT_NE(refusal(whole.substr(0, length)), "") << length << " of " << whole.size() << " bytes";
    }
    for (size_t at = 0; at < png.size(); ++at) {
        std::string changed = png;
        changed[at] = static_cast<char>(changed[at] ^ 4);
        EXPECT_NE(refusal(changed), "") << at;
    }
    // All of a scan's data gone, and the end where it should be: libjpeg would make up grey.
    std::string empty = encode_jpeg(JCS_RGB, 3, 40, {200, 100, 50}, Scans::one);
    const size_t scan = empty.find("\xff\xda");
    ASSERT_NE(scan, std::string::npos);
    empty.erase(scan + 14, empty.size() - 2 - (scan + 14));
    EXPECT_EQ(refusal(empty), "JPEG: Corrupt JPEG data: premature end of data segment");
    EXPECT_EQ(refusal("GIF89a"), "neither a PNG nor a JPEG");
    EXPECT_EQ(refusal(png.substr(0, 40)), "PNG: the file ends early");
}

TEST(ImageDecode, WhatTakesMoreThanItMayIsRefused) {
    const std::string png = encode({4, 4, 8, PNG_COLOR_TYPE_GRAY, Texels(16)}),
                      jpeg = encode_jpeg(JCS_GRAYSCALE, 1, 16, {90}, Scans::one);
    EXPECT_EQ(refusal(png, 64), "");
    EXPECT_EQ(refusal(png, 63), "PNG: 4 x 4 texels are more than the limit");
    EXPECT_EQ(refusal(jpeg, 1024), "");
    EXPECT_EQ(refusal(jpeg, 1023), "JPEG: 16 x 16 texels are more than the limit");
    // A frame header is its marker, its length, the bits, then the height and the width.
    std::string claims = jpeg;
    const size_t frame = claims.find("\xff\xc0");
    ASSERT_NE(frame, std::string::npos);
    claims.replace(frame + 5, 4, "\x03\xe8\x03\xe8", 4);
    EXPECT_EQ(refusal(claims, uint64_t{1} << 40), "JPEG: more texels than the file can hold");
    const std::string flat = encode({20000, 500, 1, PNG_COLOR_TYPE_GRAY, Texels(2500 * 500)});
    EXPECT_EQ(refusal(flat, uint64_t{1} << 30), "") << "the smallest file of its size";
    std::string lies = png;  // 1000 in each direction, and the checksum of that
    lies.replace(16, 8, std::string("\0\0\x03\xe8\0\0\x03\xe8", 8));
    uint32_t sum = ~0u;
    for (size_t i = 12; i < 29; ++i) {
        sum ^= static_cast<uint8_t>(lies[i]);
        for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0xedb88320u : 0);
    }
    for (size_t i = 0; i < 4; ++i) lies[29 + i] = static_cast<char>(~sum >> (24 - 8 * i));
    EXPECT_EQ(refusal(lies, uint64_t{1} << 40), "PNG: more texels than the file can hold");
}

// Each scan of a progressive JPEG goes over the whole image, however few bytes it has.
TEST(ImageDecode, AJpegHasScansToACertainNumber) {
    EXPECT_EQ(refusal(encode_jpeg(JCS_GRAYSCALE, 1, 16, {90}, Scans::usual)), "");
    EXPECT_EQ(refusal(encode_jpeg(JCS_GRAYSCALE, 1, 16, {90}, Scans::per_coefficient)),
              "JPEG: more scans than an image needs");
}

// What once broke something.
TEST(ImageDecode, TheCorpusIsRefused) {
    for (const char* name :
         {"chunk_bomb.png", "huffman_table_too_long.jpg", "begins_late.jpg", "no_data.png"}) {
        std::ifstream file(std::string(PENUMBRA_SOURCE_DIR "/tests/fuzz/corpus/image/") + name,
                           std::ios::binary);
        const std::string bytes(std::istreambuf_iterator<char>(file), {});
        ASSERT_FALSE(bytes.empty()) << name;
        EXPECT_NE(refusal(bytes), "") << name;
    }
}

}  // namespace
}  // namespace penumbra
