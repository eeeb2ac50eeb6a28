// SPDX-License-Identifier: MIT
// libjpeg reports errors by a call that must not return, here by longjmp: whatever has a destructor lives in
// a JpegReading, outside of the function that it jumps back into.
#include <csetjmp>
#include <cstdio>
#include <string>

#include "host/images/image_decode.h"

// After <cstdio>, whose types it takes on trust.
#include <jerror.h>
#include <jpeglib.h>

namespace penumbra {
namespace {

// Encoders write about ten. A scan of a few bytes goes over all of the image.
constexpr int most_scans = 100;

struct JpegReading {
    JpegReading();
    ~JpegReading() { jpeg_destroy_decompress(&jpeg); }
    JpegReading(const JpegReading&) = delete;
    JpegReading& operator=(const JpegReading&) = delete;

    jpeg_decompress_struct jpeg{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    jpeg_source_mgr source{};
    std::jmp_buf back{};
    RgbaImage image;
    char problem[JMSG_LENGTH_MAX] = {};
};

JpegReading& reading_of(j_common_ptr jpeg) {
    return *static_cast<JpegReading*>(jpeg->client_data);
}

[[noreturn]] void on_error(j_common_ptr jpeg) {
    JpegReading& reading = reading_of(jpeg);
    jpeg->err->format_message(jpeg, reading.problem);
    std::longjmp(reading.back, 1);
}

[[noreturn]] void give_up(j_common_ptr jpeg, const char* why) {
    JpegReading& reading = reading_of(jpeg);
    std::snprintf(reading.problem, sizeof reading.problem, "%s", why);
    std::longjmp(reading.back, 1);
}

// Below 0: data that is not as it should be, which libjpeg makes up something for. Some is found in whole
// files.
void on_message(j_common_ptr jpeg, int level) {
    const int what = jpeg->err->msg_code;
    const bool harmless = what == JWRN_EXTRANEOUS_DATA || what == JWRN_JFIF_MAJOR || what == JWRN_ADOBE_XFORM;
    if (level < 0 && !harmless) on_error(jpeg);
}

void begin(j_decompress_ptr) {}

// All of the file was there from the start.
boolean more(j_decompress_ptr jpeg) {
    give_up(reinterpret_cast<j_common_ptr>(jpeg), "the file ends early");
}

void skip(j_decompress_ptr jpeg, long count) {
    if (count <= 0) return;
    if (static_cast<size_t>(count) > jpeg->src->bytes_in_buffer) more(jpeg);
    jpeg->src->next_input_byte += count;
    jpeg->src->bytes_in_buffer -= static_cast<size_t>(count);
}

void count_scans(j_common_ptr jpeg) {
    if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number > most_scans)
        give_up(jpeg, "more scans than an image needs");
}

JpegReading::JpegReading() {
    jpeg.err = jpeg_std_error(&errors);
    jpeg.client_data = this;
    errors.error_exit = on_error;
    errors.emit_message = on_message;
    progress.progress_monitor = count_scans;
    source.init_source = begin;
    source.fill_input_buffer = more;
    source.skip_input_data = skip;
    source.resync_to_restart = jpeg_resync_to_restart;
    source.term_source = begin;
}

bool read_header(JpegReading& reading, std::span<const std::byte> bytes) {
    if (setjmp(reading.back)) return false;
    jpeg_create_decompress(&reading.jpeg);
    reading.jpeg.progress = &reading.progress;
    reading.source.next_input_byte = reinterpret_cast<const JOCTET*>(bytes.data());
    reading.source.bytes_in_buffer = bytes.size();
    reading.jpeg.src = &reading.source;
    jpeg_read_header(&reading.jpeg, TRUE);
    return true;
}

// Inks to colours, in place. Adobe's programs store them inverted (libjpeg.txt, "Special color spaces").
void from_cmyk(uint8_t* texel, bool inverted) {
    const auto light = [&](int i) { return inverted ? texel[i] : 255 - texel[i]; };
    const int black = light(3);
    for (int i = 0; i < 3; ++i) texel[i] = static_cast<uint8_t>((light(i) * black + 127) / 255);
    texel[3] = 255;
}

// Into image.rgba, which has room.
bool read_texels(JpegReading& reading) {
    if (setjmp(reading.back)) return false;
    jpeg_decompress_struct& jpeg = reading.jpeg;
    const bool cmyk = jpeg.jpeg_color_space == JCS_CMYK || jpeg.jpeg_color_space == JCS_YCCK;
    jpeg.out_color_space = cmyk ? JCS_CMYK : JCS_EXT_RGBA;
    jpeg_start_decompress(&jpeg);
    const size_t row = size_t{4} * reading.image.width;
    while (jpeg.output_scanline < jpeg.output_height) {
        JSAMPROW to = reading.image.rgba.data() + jpeg.output_scanline * row;
        jpeg_read_scanlines(&jpeg, &to, 1);
        if (cmyk)
            for (size_t x = 0; x < row; x += 4) from_cmyk(to + x, jpeg.saw_Adobe_marker);
    }
    jpeg_finish_decompress(&jpeg);
    return true;
}

}  // namespace

RgbaImage decode_jpeg(std::span<const std::byte> bytes, uint64_t limit) {
    JpegReading reading;
    const auto fail = [&] { throw ImageError(std::string("JPEG: ") + reading.problem); };
    if (!read_header(reading, bytes)) fail();
    reading.image.width = reading.jpeg.image_width;
    reading.image.height = reading.jpeg.image_height;
    const uint64_t texels = uint64_t{reading.image.width} * reading.image.height;
    if (texels > limit / 4)
        throw ImageError("JPEG: " + std::to_string(reading.image.width) + " x " +
                         std::to_string(reading.image.height) + " texels are more than the limit");
    // A block of 64 texels takes a bit or more, but for arithmetic coding, which nobody's viewer reads.
    if (reading.jpeg.arith_code) throw ImageError("JPEG: arithmetic coding is not supported");
    if (texels > bytes.size() * 512) throw ImageError("JPEG: more texels than the file can hold");
    reading.image.rgba.resize(texels * 4);
    if (!read_texels(reading)) fail();
    return std::move(reading.image);
}

}  // namespace penumbra
