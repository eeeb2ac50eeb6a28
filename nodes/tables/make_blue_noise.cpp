// SPDX-License-Identifier: MIT
// Build tool: writes the blue-noise table as raw texels (128 x 128, 32 bits each, little-endian, row by row).
#include <cstdio>
#include <fstream>

#include "nodes/tables/blue_noise.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_blue_noise FILE\n");
        return 2;
    }
    std::ofstream file(argv[1], std::ios::binary);
    for (uint32_t texel : penumbra::blue_noise_table()) {
        const char bytes[4] = {char(texel & 255), char(texel >> 8 & 255), char(texel >> 16 & 255),
                               char(texel >> 24)};
        file.write(bytes, 4);
    }
    file.close();
    if (!file) {
        std::fprintf(stderr, "make_blue_noise: cannot write %s\n", argv[1]);
        return 1;
    }
}
