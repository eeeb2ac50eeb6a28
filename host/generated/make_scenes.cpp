// SPDX-License-Identifier: MIT
// Writes the scenes that the project makes itself, and the one shot whose keys are computed:
// penumbra_make_scenes DIR.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <span>

#include "host/generated/generated_scenes.h"
#include "host/generated/lamp.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: penumbra_make_scenes DIR\n");
        return 2;
    }
    try {
        const std::filesystem::path folder = argv[1];
        for (const penumbra::GeneratedScene& scene : penumbra::generated_scenes)
            penumbra::write_file(folder / (std::string(scene.name) + ".glb"), penumbra::to_glb(scene.make()));
        const std::string shot = penumbra::make_lamp_shot();
        penumbra::write_file(folder / "lamp.shot.json", std::as_bytes(std::span(shot)));
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
