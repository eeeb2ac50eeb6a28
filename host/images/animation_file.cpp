// SPDX-License-Identifier: MIT
#include "host/images/animation_file.h"

#include <fmt/format.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <cstring>
#include <memory>

#include "host/images/image_file.h"

namespace penumbra {
namespace {

constexpr float quality = 80;  // noise stays noise, and a page of several shots stays some megabytes

[[noreturn]] void fail(const std::string& why) {
    throw FileError("an animation: " + why);
}

struct FreePicture {
    void operator()(WebPPicture* picture) const { WebPPictureFree(picture); }
};

}  // namespace

std::vector<std::byte> webp_animation(uint32_t width, uint32_t height,
                                      std::span<const std::vector<uint8_t>> frames, int frame_ms) {
    if (frames.empty()) fail("no frames");
    if (width == 0 || height == 0 || width > WEBP_MAX_DIMENSION || height > WEBP_MAX_DIMENSION)
        fail(fmt::format("{}x{} is no size for WebP, which takes up to {} a side", width, height,
                         WEBP_MAX_DIMENSION));
    WebPAnimEncoderOptions options;
    WebPConfig config;
    if (!WebPAnimEncoderOptionsInit(&options) || !WebPConfigInit(&config))
        fail("libwebp is of another version");
    options.anim_params.loop_count = 0;  // for ever
    config.quality = quality;
    const auto w = static_cast<int>(width), h = static_cast<int>(height);
    const std::unique_ptr<WebPAnimEncoder, decltype(&WebPAnimEncoderDelete)> encoder(
        WebPAnimEncoderNew(w, h, &options), WebPAnimEncoderDelete);
    if (!encoder) fail("no encoder");
    int at_ms = 0;
    for (const std::vector<uint8_t>& frame : frames) {
        if (frame.size() != size_t{4} * width * height) fail("a frame of another size");
        WebPPicture picture;
        if (!WebPPictureInit(&picture)) fail("libwebp is of another version");
        const std::unique_ptr<WebPPicture, FreePicture> owner(&picture);
        picture.use_argb = 1;
        picture.width = w;
        picture.height = h;
        if (!WebPPictureImportRGBA(&picture, frame.data(), 4 * w) ||
            !WebPAnimEncoderAdd(encoder.get(), &picture, at_ms, &config))
            fail(WebPAnimEncoderGetError(encoder.get()));
        at_ms += frame_ms;
    }
    WebPData data;
    WebPDataInit(&data);
    if (!WebPAnimEncoderAdd(encoder.get(), nullptr, at_ms, nullptr) ||
        !WebPAnimEncoderAssemble(encoder.get(), &data))
        fail(WebPAnimEncoderGetError(encoder.get()));
    std::vector<std::byte> bytes(data.size);
    std::memcpy(bytes.data(), data.bytes, data.size);
    WebPDataClear(&data);
    return bytes;
}

}  // namespace penumbra
