// SPDX-License-Identifier: MIT
#include "tests/reflections/radiance_run.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <numeric>
#include <span>
#include <stdexcept>

#include "app/outputs.h"
#include "app/radiance_truth.h"
#include "host/models/glb_writer.h"
#include "host/models/model_builder.h"
#include "tests/gpu_test.h"
#include "tests/shot_run.h"
#include "tests/test_folder.h"
#include "tests/view_run.h"

namespace penumbra::test {
Shot night_shot(const Model& model, std::array<uint32_t, 2> size, uint32_t frames) {
    static const TestFolder folder;
    static int number = 0;
    Shot shot;
    shot.name = "night";
    shot.model = folder / fmt::format("{}.glb", number++);
    write_file(shot.model, to_glb(model));
    shot.size = size;
    shot.frames = frames;
    shot.camera = {{0, {0, 1.5, 3}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun = {{0, {0, -1, 0}}};
    return shot;
}

EnvironmentSky linear_sky(double down, double up) {
    return {true, glm::dvec3(down), glm::dvec3(up)};
}

Material shining(std::array<float, 3> radiance) {
    Material material;
    material.base_color = {0, 0, 0, 1};
    material.emissive = radiance;
    return material;
}

Model striped_floor(const std::vector<float>& roughness) {
    std::vector<Material> materials;
    for (const float r : roughness) {
        Material& material = materials.emplace_back();
        material.base_color = {0, 0, 0, 1};
        material.roughness = r;
        material.metallic = 1;
    }
    ModelBuilder builder(materials);
    const double width = 8.0 / static_cast<double>(roughness.size());
    for (size_t i = 0; i < roughness.size(); ++i) {
        Shape strip = ground(width / 2, 3, 1, 1);
        glm::dmat4 place(1);
        place[3] = {-4 + width * (static_cast<double>(i) + 0.5), 0, 0, 1};
        strip.transform(place);
        builder.solid("strip", strip, static_cast<int>(i));
    }
    return builder.take();
}

glm::dvec3 mirrored(const Camera& camera, std::array<uint32_t, 2> size, size_t pixel, glm::dvec3& origin) {
    const double x = 2 * (static_cast<double>(pixel % size[0]) + 0.5) / size[0] - 1,
                 y = 2 * (static_cast<double>(pixel / size[0]) + 0.5) / size[1] - 1;
    const auto& m = camera.clip_from_view;
    const glm::dmat3 world_from_view = glm::make_mat3(camera.world_from_view.data());
    const glm::dvec3 direction = glm::normalize(world_from_view * glm::dvec3(x / m[0], y / m[5], -1));
    const glm::dvec3 eye = glm::make_vec3(camera.position.data());
    origin = eye - direction * (eye.y / direction.y);
    return {direction.x, -direction.y, direction.z};
}

std::unique_ptr<Session> open_shipped(const std::string& name, const Shot& shot,
                                      const std::vector<std::string>& settings,
                                      const std::vector<std::string>& also, const Facts& facts, bool jitter) {
    const CheckedPipeline pipeline = shipped_pipeline(name, settings);
    SessionOptions options;
    options.size = shot.size;
    options.facts = facts;
    if (!jitter) options.jitter = false;
    options.captures = pipeline.output_names();
    options.captures.insert(options.captures.end(), also.begin(), also.end());
    return open_session(pipeline, shot, options);
}

namespace {
double sum_of_word(uint32_t word, uint32_t tenth_bits) {
    double sum = 0;
    for (uint32_t i = 0; i < 3; ++i) sum += 2 * (word >> 9 * i & 511) + (tenth_bits >> i & 1);
    return std::ldexp(sum, static_cast<int>(word >> 27) - 25);
}
}  // namespace

ViewRunOptions radiance_host_options() {
    ViewRunOptions options;
    options.formats = {{"depth", Format::r32f},
                       {"normal", Format::rgba32f},
                       {"motion", Format::rgba16f},
                       {"material", Format::rg8}};
    options.facts = {{"moves", true}};
    return options;
}

void hand_over_guides(ViewRun& host, const Session& session) {
    const GBufferImages& images = session.host().images();
    for (const auto& [name, image] : {std::pair{"depth", &images.depth},
                                      {"normal", &images.normal},
                                      {"motion", &images.motion},
                                      {"material", &images.material}})
        host.set(name, read_image(gpu(), image->get(), image->format, image->extent, GBuffer::final_layout));
}

double mean_accumulated(const Session& session) {
    const auto words = captured<uint32_t>(session.view(), "accumulated");
    const auto bytes = captured<uint8_t>(session.view(), "frames");
    double sum = 0;
    for (size_t i = 0; i < words.size(); ++i) sum += sum_of_word(words[i], bytes[i] >> 5);
    return sum / (3.0 * static_cast<double>(words.size()));
}

std::vector<double> gathered(const Session& session) {
    std::vector<double> means;
    const auto words = captured<std::array<uint32_t, 2>>(session.view(), "gathered");
    for (const auto& [radiance, rest] : words) means.push_back(sum_of_word(radiance, 0) / 3);
    return means;
}

double mean_gathered(const Session& session) {
    const auto pixels = gathered(session);
    return std::reduce(pixels.begin(), pixels.end()) / static_cast<double>(pixels.size());
}

std::array<std::vector<float>, 3> colors(const Session& session) {
    for (const PlanPass& pass : session.plan().passes)
        if (pass.kind == PassKind::capture) {
            const PlanarImage image = captured_image(session, pass.node);
            return {image.find("R")->values, image.find("G")->values, image.find("B")->values};
        }
    throw std::logic_error("nothing is captured");
}

PlanarImage truth_of(const Shot& shot, const std::string& signal, uint32_t rays, uint32_t frame) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_radiance_truth(gpu(), shot, signal, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    return radiance_truth(gpu(), *session, frame, rays);
}

}  // namespace penumbra::test
