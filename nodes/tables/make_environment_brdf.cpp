// SPDX-License-Identifier: MIT
// Build tool: writes the table of the node `compose` as raw texels (rg32f, little-endian, row by row).
#include <bit>
#include <cstdio>
#include <fstream>

#include "nodes/tables/environment_brdf.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_environment_brdf FILE\n");
        return 2;
    }
    std::ofstream file(argv[1], std::ios::binary);
    for (const float value : penumbra::environment_brdf_table())
        for (int shift = 0; shift < 32; shift += 8)
            file.put(static_cast<char>(std::bit_cast<uint32_t>(value) >> shift & 255));
    file.close();
    if (!file) {
        std::fprintf(stderr, "make_environment_brdf: cannot write %s\n", argv[1]);
        return 1;
    }
}
