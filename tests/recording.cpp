// SPDX-License-Identifier: MIT
#include "tests/recording.h"

#include <algorithm>
#include <fstream>
#include <glm/gtc/type_ptr.hpp>
#include <stdexcept>

#include "app/session.h"
#include "host/scene/moved_boxes.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

template <class T>
std::vector<std::byte> bytes_of(const T& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    return {bytes.begin(), bytes.end()};
}

std::vector<std::byte> texels_of(const std::vector<Texel>& texels) {
    const auto bytes = std::as_bytes(std::span(texels));
    return {bytes.begin(), bytes.end()};
}

std::vector<std::byte> image_bytes(const GpuImage& image) {
    return read_image(gpu(), image.get(), image.format, image.extent,
                      VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

std::vector<std::byte> slot_bytes(const Session& session, const StandaloneFrame& frame,
                                  const std::string& name, uint32_t index) {
    const GBufferImages& images = session.host().images();
    if (name == "depth") return image_bytes(images.depth);
    if (name == "normal") return image_bytes(images.normal);
    if (name == "motion") return image_bytes(images.motion);
    if (name == "albedo") return image_bytes(images.albedo);
    if (name == "sun") return bytes_of(frame.sun);
    if (name == "sun_prev") return bytes_of(frame.sun_prev);
    if (name == "scene") return bytes_of(frame.scene);
    if (name == "scene.nodes" || name == "scene.nodes_words") return texels_of(session.bvh()->bvh().nodes);
    if (name == "scene.leaves" || name == "scene.leaves_words") return texels_of(session.bvh()->bvh().leaves);
    if (name == "hits") {
        const auto hits = session.view().captured("hits");
        return {hits.begin(), hits.end()};
    }
    if (name == "moved_boxes") {
        const double now = session.host().moment(index),
                     before = index ? session.host().moment(index - 1) : now;
        return bytes_of(moved_block(
            session.host().scene().moved_boxes(before, now),
            glm::make_vec3(frame.description.camera.position.data()) - session.host().shot().origin));
    }
    if (name == "neighbours") return texels_of(leaf_neighbours(session.bvh()->bvh()));
    throw std::invalid_argument("no recording of the slot " + name);
}

void write(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace

Facts recorded_facts() {
    return {{"alpha", false}, {"translucent", false}};
}

namespace {

// Rays for a pipeline that is given them: those of one_ray.json, told as little of itself as denoise.json is.
// It gives the same image.
CheckedPipeline tracer_of(const CheckedPipeline& pipeline) {
    if (!pipeline.input("hits")) return pipeline;
    return shipped_pipeline("one_ray", {"nodes.gather.params.rays=bits"});
}

}  // namespace

Recording record(const CheckedPipeline& pipeline, const Shot& shot, uint32_t frames, const Facts& facts,
                 bool jitter) {
    SessionOptions options;
    options.size = shot.size;
    options.captures = pipeline.output_names();
    options.seed = 0;
    options.pass_costs = false;
    options.facts = facts;
    if (!jitter) options.jitter = false;
    for (const Fact& fact : pipeline.domain->facts) options.facts.try_emplace(fact.name, true);
    const CheckedPipeline tracer = tracer_of(pipeline);
    const bool foreign = tracer.name != pipeline.name;
    if (foreign) options.captures.push_back("hits");
    const auto session = open_session(tracer, shot, options, test_nodes());
    Recording recording{session->plan(), {}};
    if (foreign) {
        DeviceTable device = device_table(handles_of(gpu()));
        Target target = standalone_target(pipeline, device, shot.size, options.facts);
        target.jitters = session->plan().jitter;
        Diagnostics diagnostics;
        auto plan = compile(pipeline, target, {}, diagnostics);
        if (!plan) throw std::runtime_error(diagnostics.text());
        recording.plan = std::move(*plan);
    }
    for (uint32_t f = 0; f < frames; ++f) {
        session->run_frame(f, f == 0);
        const StandaloneFrame frame = session->host().frame(f, f == 0);
        RecordedFrame& to = recording.frames.emplace_back();
        to.description = session->frame_description();
        for (const HostSlot& slot : recording.plan.slots)
            to.slots[slot.name] = slot_bytes(*session, frame, slot.name, f);
        for (const std::string& name : pipeline.output_names()) {
            const auto bytes = session->view().captured(name);
            to.outputs[name] = {bytes.begin(), bytes.end()};
        }
    }
    return recording;
}

Plan record_plaza(const CheckedPipeline& pipeline, std::array<uint32_t, 2> size, uint32_t frames,
                  const std::filesystem::path& folder) {
    // Its plan is made by hosts that say nothing of jitter: theirs is jittered where a node asks for it.
    const bool jitter = tracer_of(pipeline).name == pipeline.name;
    Recording recording = record(pipeline, plaza_shot(size, frames), frames, recorded_facts(), jitter);
    for (uint32_t f = 0; f < frames; ++f) {
        const RecordedFrame& frame = recording.frames[f];
        const std::filesystem::path to = folder / std::to_string(f);
        std::filesystem::create_directories(to);
        for (const auto& [name, bytes] : frame.slots) write(to / (name + ".bin"), bytes);
        for (const auto& [name, bytes] : frame.outputs) write(to / (name + ".out"), bytes);
        write(to / "frame.bin", bytes_of(frame.description));
        write(to / "frame_block.bin", bytes_of(make_frame_block(frame.description)));
    }
    return std::move(recording.plan);
}

}  // namespace penumbra::test
