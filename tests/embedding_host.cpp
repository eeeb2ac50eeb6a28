// SPDX-License-Identifier: MIT
#include "tests/embedding_host.h"

#include <cstring>
#include <stdexcept>

namespace penumbra::test {

CheckedPipeline checked(const std::string& body, const NodeSet& set) {
    Diagnostics diagnostics;
    const auto pipeline =
        parse_pipeline(R"({ "penumbra": 1, "name": "p", )" + body + "}", "p.json", {}, diagnostics);
    auto result = pipeline ? check(*pipeline, set, diagnostics) : std::nullopt;
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

const char* const given_and_history = R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["blended"],
    "nodes": { "blend": { "type": "toy_blend", "in": { "value": "given", "history": "blended@-1" } } })";

std::shared_ptr<const Plan> plan_of(const CheckedPipeline& pipeline, const CompileOptions& options) {
    Diagnostics diagnostics;
    auto plan = compile(pipeline, {.extent = {width, height}, .device = device_table(handles_of(gpu()))},
                        options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<const Plan>(std::move(*plan));
}

CompileOptions capturing(const CheckedPipeline& pipeline, bool share) {
    CompileOptions options;
    options.captures = pipeline.output_names();
    options.share_transients = share;
    return options;
}

FrameDescription description(uint32_t index, Extent size) {
    FrameDescription frame;
    frame.camera.clip_from_view = frame.previous.clip_from_view = perspective(1.0, 1.0, 0.1);
    frame.size = {size.width, size.height};
    frame.index = index;
    return frame;
}

std::vector<float> floats(std::span<const std::byte> bytes) {
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

Outputs outputs_of(const View& view) {
    Outputs outputs;
    for (const PlanOutput& output : view.plan().outputs)
        outputs[output.name] = floats(view.captured(output.name));
    return outputs;
}

Outputs run_toys(const DeviceHandles& handles, uint32_t frames) {
    const CheckedPipeline pipeline = toy_pipeline_file();
    View view(std::make_shared<Program>(handles, plan_of(pipeline, capturing(pipeline))), {});
    for (uint32_t f = 0; f < frames; ++f)
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
    return outputs_of(view);
}

GpuImage image_of(VkFormat format, VkImageUsageFlags usage) {
    return make_image(gpu(), format, {width, height}, 1, usage | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                      "the host's");
}

std::shared_ptr<const Program> program_with(const CheckedPipeline& pipeline, const Facts& facts, bool hand_on,
                                            Extent extent) {
    CompileOptions options = capturing(pipeline);
    options.hand_on_history = hand_on;
    Diagnostics diagnostics;
    auto plan =
        compile(pipeline, {.extent = extent, .facts = facts, .device = device_table(handles_of(gpu()))},
                options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(std::move(*plan)));
}

}  // namespace penumbra::test
