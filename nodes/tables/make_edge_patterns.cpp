// SPDX-License-Identifier: MIT
// Build tool: writes the table of edge patterns as raw texels (32 x 16, 8 bits, row by row).
#include <cstdio>
#include <fstream>

#include "nodes/tables/edge_patterns.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_edge_patterns FILE\n");
        return 2;
    }
    std::ofstream file(argv[1], std::ios::binary);
    for (const uint8_t byte : penumbra::edge_pattern_table()) file.put(static_cast<char>(byte));
    file.close();
    if (!file) {
        std::fprintf(stderr, "make_edge_patterns: cannot write %s\n", argv[1]);
        return 1;
    }
}
