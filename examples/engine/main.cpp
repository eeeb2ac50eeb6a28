// SPDX-License-Identifier: MIT
// An engine with a frame graph, an allocator and barriers of its own, in which penumbra is one node with
// ports: the G-buffer goes in, visibility comes out into an image that the engine's graph owns. What the
// G-buffer pass would render is read from files (FOLDER/FRAME/SLOT.bin).
//     engine PIPELINE.json WIDTH HEIGHT FRAMES FOLDER
#include "loop.h"

int main(int argc, char** argv) {
    if (argc != 6) return std::fputs("usage: engine PIPELINE.json WIDTH HEIGHT FRAMES FOLDER\n", stderr), 2;
    const auto number = [&](int i) { return static_cast<uint32_t>(std::atoi(argv[i])); };
    const auto folder = [&](uint32_t frame) {
        return std::filesystem::path(argv[5]) / std::to_string(frame);
    };
    return engine::run(
        argv[1], {number(2), number(3)}, number(4),
        {[&](uint32_t f, const std::string& slot) { return engine::read(folder(f) / (slot + ".bin")); },
         [&](uint32_t f) {
             penumbra::FrameDescription frame;
             std::memcpy(static_cast<void*>(&frame), engine::read(folder(f) / "frame.bin").data(),
                         sizeof frame);
             return frame;
         },
         [&](uint32_t f, std::span<const char> visibility) {
             std::ofstream(folder(f) / "visibility.engine", std::ios::binary)
                 .write(visibility.data(), static_cast<std::streamsize>(visibility.size()));
         }});
}
