// SPDX-License-Identifier: MIT
#include "tests/test_scene.h"

#include "host/models/glb_writer.h"
#include "tests/scene_file.h"

namespace penumbra::test {
namespace {

Model make_plaza() {
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.75f, 1}, -1}, {{0.6f, 0.3f, 0.2f, 1}, -1}};
    add(model, "floor", ground(20, 20, 8, 8), 0);
    add(model, "bar", rod({-3, 1.5, 0}, {3, 1.5, 0.5}, 0.08, 12), 1);
    add(model, "block", box({-1.2, 0, -1.5}, {-0.4, 1.1, -0.7}), 1);
    return model;
}

}  // namespace

Shot plaza_shot(std::array<uint32_t, 2> size, uint32_t frames) {
    static const SceneFile file("plaza.glb", to_glb(make_plaza()));
    Shot shot;
    shot.name = "plaza";
    shot.model = file.path();
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
