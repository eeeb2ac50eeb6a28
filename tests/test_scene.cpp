// SPDX-License-Identifier: MIT
#include "tests/test_scene.h"

#include <unistd.h>

#include <filesystem>

#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/models/shapes.h"

namespace penumbra::test {
namespace {

Model make_plaza() {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.75f, 1}, -1}, {{0.6f, 0.3f, 0.2f, 1}, -1}};
    const auto add = [&](const char* name, Shape shape, int material) {
        Mesh mesh;
        mesh.parts.push_back(to_part(std::move(shape), material));
        model.meshes.push_back(std::move(mesh));
        Node node;
        node.name = name;
        node.mesh = static_cast<int>(model.meshes.size()) - 1;
        model.nodes.push_back(node);
    };
    add("floor", ground(20, 20, 8, 8), 0);
    add("bar", rod({-3, 1.5, 0}, {3, 1.5, 0.5}, 0.08, 12), 1);
    add("block", box({-1.2, 0, -1.5}, {-0.4, 1.1, -0.7}), 1);
    return model;
}

// The file is gone when the process ends.
struct PlazaFile {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("penumbra_plaza_" + std::to_string(getpid()) + ".glb");
    PlazaFile() { write_file(path, to_glb(make_plaza())); }
    PlazaFile(const PlazaFile&) = delete;
    PlazaFile& operator=(const PlazaFile&) = delete;
    ~PlazaFile() {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    }
};

const std::filesystem::path& plaza_file() {
    static const PlazaFile file;
    return file.path;
}

}  // namespace

Shot plaza_shot(std::array<uint32_t, 2> size, uint32_t frames) {
    Shot shot;
    shot.name = "plaza";
    shot.model = plaza_file();
    shot.size = size;
    shot.frames = frames;
    shot.camera = {{0, {0.5, 4, 4}, {0, 0, 0}, {0, 1, 0}}, {16, {0.8, 4, 4.2}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = 1.5;
    shot.sun = {{0, {0.4, 0.8, 0.2}}, {16, {0.45, 0.8, 0.2}}};
    ShotLight& lamp = shot.lights["lamp"];
    lamp.kind = LightKind::disc;
    lamp.radius = 0.4;
    lamp.range = 20;
    lamp.keys = {{0, {0.2, 3, 0.1}, {0.1, -1, 0.1}, {1, 0.1, 0.3}, 1, 1}};
    shot.objects["block"].keys = {{0, {0, 0, 0}, {0, 0, 0}}, {16, {0.3, 0.2, 0}, {0, 20, 0}}};
    return shot;
}

}  // namespace penumbra::test
