// SPDX-License-Identifier: MIT
#include "tests/sized_run.h"

#include <cstring>
#include <stdexcept>

#include "app/session.h"
#include "tests/gpu_test.h"

namespace penumbra::test {

Bytes cropped(const Plan& plan, const std::string& name, std::span<const std::byte> bytes, Extent frame) {
    const PlanResource& r = plan.resources[plan.output(name)->resource];
    const Extent part = r.follows ? r.follows->at(frame) : r.extent;
    const size_t texel = info(r.format).bytes, row = texel * r.extent.width;
    Bytes out;
    for (size_t y = 0; y < part.height; ++y) {
        const auto line = bytes.subspan(y * row, texel * part.width);
        out.insert(out.end(), line.begin(), line.end());
    }
    return out;
}

SizedRun::SizedRun(const CheckedPipeline& pipeline, Extent largest, const Plan& recorded) {
    DeviceTable device = device_table(handles_of(gpu()));
    device.features = features_of(gpu());
    CompileOptions options;
    options.captures = pipeline.output_names();
    options.poison = true;
    Diagnostics diagnostics;
    Target target = standalone_target(pipeline, device, {largest.width, largest.height}, recorded.facts);
    target.jitters = recorded.jitter;
    auto plan = compile(pipeline, target, options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    view_ = std::make_unique<View>(
        std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(std::move(*plan))),
        ViewOptions{1, 0});
    for (const PlanPass& pass : view_->plan().passes)  // as the recordings have it
        for (const PlanParam& param : pass.params)
            if (param.param.name == "seed" && !view_->set_param(pass.node, "seed", ParamValue(0u)))
                throw std::logic_error("a seed is no unsigned number");
}

SizedRun::Input SizedRun::bring(const HostSlot& slot, const Bytes& bytes, Extent size) const {
    Input input;
    if (slot.kind == PortKind::texels) {
        input.texels = upload_texels(gpu(), bytes, info(slot.format).vk, slot.name);
    } else if (slot.kind != PortKind::image) {
        input.buffer = upload_buffer(
            gpu(), bytes, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, slot.name);
    } else {
        const Extent part = slot.follows ? slot.follows->at(size) : slot.extent;
        const size_t texel = info(slot.format).bytes;
        Bytes padded(texel * slot.extent.width * slot.extent.height,
                     std::byte{0xff});  // NaN, where it is a number
        for (size_t y = 0; y < part.height; ++y)
            std::memcpy(&padded[texel * slot.extent.width * y], &bytes[texel * part.width * y],
                        texel * part.width);
        input.image = make_image(gpu(), info(slot.format).vk, {slot.extent.width, slot.extent.height}, 1,
                                 VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, slot.name);
        upload_image(gpu(), input.image, padded);
    }
    return input;
}

void SizedRun::frame(const RecordedFrame& frame, const RecordedFrame* last) {
    FrameDescription description = frame.description;
    if (last) description.prev_jitter = last->description.jitter;
    size_ = {description.size[0], description.size[1]};
    std::vector<Input> inputs;
    Externals externals(view_->plan());
    for (const HostSlot& slot : view_->plan().slots) {
        const Input& input = inputs.emplace_back(bring(slot, frame.slots.at(slot.name), size_));
        externals[slot.name] = {
            .image = input.image.view.get(), .texels = input.texels.view.get(), .buffer = input.buffer.get()};
    }
    gpu().run([&](VkCommandBuffer cmd) { view_->record(cmd, description, externals); });
}

Bytes SizedRun::output(const std::string& name) const {
    return cropped(view_->plan(), name, view_->captured(name), size_);
}

}  // namespace penumbra::test
