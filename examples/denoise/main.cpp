// SPDX-License-Identifier: MIT
// A host with rays of its own, and no scene that penumbra could trace: depth, normal, motion and one bit per
// pixel (world.h) go into denoise.json, visibility comes out. The device, its memory and its frames are the
// engine's (../engine). Where to begin with an engine of yours: replace world.h by what your G-buffer and
// shadow rays give.
//     denoise denoise.json WIDTH HEIGHT FRAMES FOLDER
// FOLDER/FRAME/ gets what went in (SLOT.bin, frame.bin) and what came out (visibility.denoise).
#include "../engine/loop.h"
#include "world.h"

namespace {

template <class T>
std::vector<char> bytes_of(const std::vector<T>& list) {
    const auto* first = reinterpret_cast<const char*>(list.data());
    return {first, first + sizeof(T) * list.size()};
}

void write(const std::filesystem::path& file, std::span<const char> bytes) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream out(file, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) std::fprintf(stderr, "cannot write %s\n", file.c_str()), std::exit(1);
}

float from_half(uint16_t bits) {  // of numbers from 0 to 1
    if (bits < 0x400) return static_cast<float>(bits) * 0x1p-24f;
    return std::ldexp(static_cast<float>(1024 + (bits & 1023)), (bits >> 10) - 25);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 6) return std::fputs("usage: denoise denoise.json WIDTH HEIGHT FRAMES FOLDER\n", stderr), 2;
    const auto number = [&](int i) { return static_cast<uint32_t>(std::atoi(argv[i])); };
    const world::Size size{number(2), number(3)};
    const uint32_t frames = number(4);
    const auto file = [&](uint32_t f, const std::string& name) {
        return std::filesystem::path(argv[5]) / std::to_string(f) / name;
    };
    double rays_error = 0, error = 0;  // of the last frame's bits, and of what became of them
    const int code = engine::run(
        argv[1], {size.width, size.height}, frames,
        {[&](uint32_t f, const std::string& slot) {
             const world::Frame frame = world::render(size, static_cast<int>(f));
             const std::vector<penumbra::blocks::Sun> sun{world::sun()};
             const std::vector<char> bytes = slot == "depth"    ? bytes_of(frame.depth)
                                             : slot == "normal" ? bytes_of(frame.normal)
                                             : slot == "motion" ? bytes_of(frame.motion)
                                             : slot == "hits"
                                                 ? bytes_of(frame.hits)
                                                 : bytes_of(sun);  // and sun_prev: it stands still
             write(file(f, slot + ".bin"), bytes);
             return bytes;
         },
         [&](uint32_t f) {
             const penumbra::FrameDescription frame = world::describe(size, static_cast<int>(f));
             write(file(f, "frame.bin"), {reinterpret_cast<const char*>(&frame), sizeof frame});
             return frame;
         },
         [&](uint32_t f, std::span<const char> visibility) {
             write(file(f, "visibility.denoise"), visibility);
             if (f + 1 != frames) return;
             const world::Frame frame = world::render(size, static_cast<int>(f));
             for (uint32_t y = 0; y < size.height; ++y)
                 for (uint32_t x = 0; x < size.width; ++x) {
                     const auto truth = world::truth(size, static_cast<int>(f), x, y);
                     if (!truth) continue;
                     uint16_t bits;
                     std::memcpy(&bits, &visibility[2 * (size_t{y} * size.width + x)], 2);
                     const bool lit =
                         !(frame.hits[size_t{y / 4} * ((size.width + 7) / 8) + x / 8] >> (y % 4 * 8 + x % 8) &
                           1);
                     rays_error += std::pow(lit - *truth, 2);
                     error += std::pow(static_cast<double>(from_half(bits)) - *truth, 2);
                 }
         }});
    std::printf("rays that each of them is worth: %.1f\n", rays_error / error);
    if (!(error < rays_error)) return std::fputs("no better than the rays\n", stderr), 1;
    return code;
}
