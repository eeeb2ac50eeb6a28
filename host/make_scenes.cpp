// SPDX-License-Identifier: MIT
// Writes the scenes that the project makes itself: penumbra_make_scenes DIR.
#include <cstdio>
#include <exception>
#include <filesystem>

#include "host/colonnade.h"
#include "host/glb_writer.h"
#include "host/image_file.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: penumbra_make_scenes DIR\n");
        return 2;
    }
    try {
        const std::filesystem::path path = std::filesystem::path(argv[1]) / "colonnade.glb";
        penumbra::write_file(path, penumbra::to_glb(penumbra::make_colonnade()));
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
