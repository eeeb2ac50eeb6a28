// SPDX-License-Identifier: MIT
// A view's objects: immutable descriptor sets of internal resources per parity, and per frame in flight the
// sets that hold what the host passes.
#include "penumbra/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>

#include "graph/interface.h"

namespace penumbra {

// Collects descriptor writes; the infos they point to stay put until flush().
class View::Writer {
  public:
    explicit Writer(VkDevice device) : device_(device) {}
    ~Writer() { flush(); }
    void image(VkDescriptorSet set, const PlanBinding& b, const VkDescriptorImageInfo& info) {
        write(set, b).pImageInfo = &images_.emplace_back(info);
    }
    void buffer(VkDescriptorSet set, const PlanBinding& b, const VkDescriptorBufferInfo& info) {
        write(set, b).pBufferInfo = &buffers_.emplace_back(info);
    }
    void texels(VkDescriptorSet set, const PlanBinding& b, VkBufferView view) {
        write(set, b).pTexelBufferView = &views_.emplace_back(view);
    }
    void structure(VkDescriptorSet set, const PlanBinding& b, VkAccelerationStructureKHR handle) {
        VkWriteDescriptorSetAccelerationStructureKHR structure{
            VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
        structure.accelerationStructureCount = 1;
        structure.pAccelerationStructures = &handles_.emplace_back(handle);
        write(set, b).pNext = &structures_.emplace_back(structure);
    }

  private:
    VkWriteDescriptorSet& write(VkDescriptorSet set, const PlanBinding& b) {
        VkWriteDescriptorSet w{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        w.dstSet = set;
        w.dstBinding = b.binding;
        w.descriptorCount = 1;
        w.descriptorType = b.type;
        return writes_.emplace_back(w);
    }
    void flush() {
        vkUpdateDescriptorSets(device_, static_cast<uint32_t>(writes_.size()), writes_.data(), 0, nullptr);
    }

    VkDevice device_;
    std::vector<VkWriteDescriptorSet> writes_;
    std::deque<VkDescriptorImageInfo> images_;
    std::deque<VkDescriptorBufferInfo> buffers_;
    std::deque<VkBufferView> views_;
    std::deque<VkAccelerationStructureKHR> handles_;
    std::deque<VkWriteDescriptorSetAccelerationStructureKHR> structures_;
};

namespace {

uint32_t level_count(const PlanPass& pass) {
    return std::max(static_cast<uint32_t>(pass.level_groups.size()), 1u);
}

// Storage images are one level: a chain's finest for readers of one, its own for whoever writes level by
// level.
VkImageView view_of(const ResourceInstance& r, const PlanBinding& b, uint32_t level) {
    if (b.type != VK_DESCRIPTOR_TYPE_STORAGE_IMAGE || r.level_views.empty()) return r.image_view.get();
    if (b.level == PlanBinding::Level::finest) return r.level_views.front().get();
    return r.level_views[b.level == PlanBinding::Level::finer && level > 0 ? level - 1 : level].get();
}

// A mip chain's finest level.
uint64_t captured_bytes(const PlanResource& r) {
    if (r.kind == PortKind::image)
        return uint64_t{r.extent.width} * r.extent.height * r.layers * info(r.format).bytes;
    return r.count * r.element_bytes;
}

}  // namespace

View::View(std::shared_ptr<const Program> program, const ViewOptions& options)
    : program_(std::move(program)), options_(options), memory_(program_->handles(), program_->plan()) {
    if (options_.frames_in_flight == 0) options_.frames_in_flight = 1;
    if (options_.poison && !plan().poison)
        throw VulkanError(VK_ERROR_FEATURE_NOT_PRESENT,
                          "poison needs a plan compiled with CompileOptions::poison");
    for (size_t i = 0; i < plan().passes.size(); ++i) {
        if (plan().passes[i].kind == PassKind::capture) capture_passes_.push_back(i);
        push_.push_back(plan().passes[i].push);
    }
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(program_->handles().physical, &properties);
    uint32_t families = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(program_->handles().physical, &families, nullptr);
    std::vector<VkQueueFamilyProperties> queues(families);
    vkGetPhysicalDeviceQueueFamilyProperties(program_->handles().physical, &families, queues.data());
    const uint32_t bits = queues[program_->handles().queue_family].timestampValidBits;
    if (bits > 0 && !plan().passes.empty()) {
        ms_per_tick_ = static_cast<double>(properties.limits.timestampPeriod) * 1e-6;
        tick_mask_ = bits < 64 ? (uint64_t{1} << bits) - 1 : ~uint64_t{0};
    }
    const VkDevice device = program_->handles().device;
    begin_label_ = reinterpret_cast<PFN_vkCmdBeginDebugUtilsLabelEXT>(
        vkGetDeviceProcAddr(device, "vkCmdBeginDebugUtilsLabelEXT"));
    end_label_ = reinterpret_cast<PFN_vkCmdEndDebugUtilsLabelEXT>(
        vkGetDeviceProcAddr(device, "vkCmdEndDebugUtilsLabelEXT"));
    make_descriptor_pool();
    make_internal_sets();
    slots_.resize(options_.frames_in_flight);
    for (Slot& slot : slots_) make_slot(slot);
}

void View::make_descriptor_pool() {
    std::map<VkDescriptorType, uint32_t> counts;
    uint32_t sets = 0;
    const uint32_t n = options_.frames_in_flight;
    for (const PlanPass& pass : plan().passes) {
        if (pass.kind != PassKind::compute) continue;
        const uint32_t levels = level_count(pass);
        sets += 2 * levels + n;
        for (const PlanBinding& b : pass.bindings) counts[b.type] += b.set == 1 ? n : 2 * levels;
    }
    if (sets == 0) return;
    std::vector<VkDescriptorPoolSize> sizes;
    for (const auto& [type, count] : counts) sizes.push_back({type, count});
    VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    create.maxSets = sets;
    create.poolSizeCount = static_cast<uint32_t>(sizes.size());
    create.pPoolSizes = sizes.data();
    VkDescriptorPool pool = VK_NULL_HANDLE;
    const VkDevice device = program_->handles().device;
    check(vkCreateDescriptorPool(device, &create, nullptr, &pool), "vkCreateDescriptorPool", plan().pipeline);
    pool_ = {device, pool};
}

VkDescriptorSet View::allocate_set(size_t pass, size_t set) const {
    const VkDescriptorSetLayout layout = program_->pass(pass).set_layouts[set].get();
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_.get();
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    VkDescriptorSet handle = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(program_->handles().device, &allocate, &handle),
          "vkAllocateDescriptorSets", plan().passes[pass].node);
    return handle;
}

void View::make_internal_sets() {
    internal_sets_.resize(plan().passes.size());
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        for (uint32_t parity = 0; parity < 2; ++parity)
            for (uint32_t level = 0; level < level_count(plan().passes[p]); ++level)
                internal_sets_[p][parity].push_back(make_internal_set(p, parity, level));
    }
}

VkDescriptorSet View::make_internal_set(size_t p, uint32_t parity, uint32_t level) {
    const VkDescriptorSet set = allocate_set(p, 0);
    Writer writer(program_->handles().device);
    for (const PlanBinding& b : plan().passes[p].bindings) {
        if (b.set != 0) continue;
        const VkSampler sampler = program_->sampler(b.linear);
        if (b.source == BindingSource::table)
            writer.image(set, b,
                         {sampler, program_->table(b.index), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
        else if (b.source == BindingSource::nothing)
            write_absent(writer, set, b);
        else if (const ResourceInstance& r = memory_.at(b.index, b.previous ? 1 - parity : parity); r.image)
            writer.image(set, b, {sampler, view_of(r, b, level), VK_IMAGE_LAYOUT_GENERAL});
        else if (b.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER)
            writer.texels(set, b, r.buffer_view.get());
        else
            writer.buffer(set, b, {r.buffer.get(), 0, VK_WHOLE_SIZE});
    }
    return set;
}

void View::write_absent(Writer& writer, VkDescriptorSet set, const PlanBinding& b) const {
    if (b.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER)
        writer.texels(set, b, program_->absent_texels(b.format));
    else if (b.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || b.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER)
        writer.buffer(set, b, {program_->absent_buffer(), 0, VK_WHOLE_SIZE});
    else
        writer.image(set, b, {program_->sampler(false), program_->absent_image(b), VK_IMAGE_LAYOUT_GENERAL});
}

void View::make_slot(Slot& slot) {
    const DeviceHandles& handles = program_->handles();
    const auto passes = static_cast<uint32_t>(plan().passes.size());
    if (ms_per_tick_ > 0) {
        VkQueryPoolCreateInfo create{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
        create.queryType = VK_QUERY_TYPE_TIMESTAMP;
        create.queryCount = 2 * passes;
        VkQueryPool pool = VK_NULL_HANDLE;
        check(vkCreateQueryPool(handles.device, &create, nullptr, &pool), "vkCreateQueryPool",
              plan().pipeline);
        slot.timestamps = {handles.device, pool};
    }
    slot.frame_block =
        MappedBuffer(handles, sizeof(FrameBlock), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the frame block");
    slot.counters =
        MappedBuffer(handles, std::max<size_t>(plan().counters.size(), 1) * sizeof(uint32_t),
                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, "counters");
    for (const size_t p : capture_passes_)
        slot.captures.emplace_back(handles,
                                   captured_bytes(plan().resources[plan().passes[p].bindings.front().index]),
                                   VK_BUFFER_USAGE_TRANSFER_DST_BIT, "a capture of " + plan().passes[p].node);
    slot.sets.resize(passes);
    Writer writer(handles.device);
    for (size_t p = 0; p < passes; ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        slot.sets[p] = allocate_set(p, 1);
        for (const PlanBinding& b : plan().passes[p].bindings) {
            if (b.source == BindingSource::frame_block)
                writer.buffer(slot.sets[p], b, {slot.frame_block.get(), 0, VK_WHOLE_SIZE});
            if (b.source == BindingSource::counters)
                writer.buffer(slot.sets[p], b, {slot.counters.get(), 0, VK_WHOLE_SIZE});
        }
    }
}

void View::check_slot_bindings(std::span<const SlotBinding> bindings) const {
    if (bindings.size() != plan().slots.size())
        throw VulkanError(VK_ERROR_INITIALIZATION_FAILED, fmt::format("{} slots were bound, the plan has {}",
                                                                      bindings.size(), plan().slots.size()));
    for (size_t i = 0; i < bindings.size(); ++i) {
        const SlotBinding& b = bindings[i];
        const PortKind kind = plan().slots[i].kind;
        const bool bound = kind == PortKind::image       ? b.image != VK_NULL_HANDLE
                           : kind == PortKind::texels    ? b.texels != VK_NULL_HANDLE
                           : kind == PortKind::structure ? b.structure != VK_NULL_HANDLE
                                                         : b.buffer != VK_NULL_HANDLE;
        if (!bound)
            throw VulkanError(VK_ERROR_INITIALIZATION_FAILED,
                              fmt::format("nothing is bound to the slot \"{}\"", plan().slots[i].name));
    }
}

// Written every frame, even where a handle is the same as before: drivers reuse the values of destroyed
// handles.
void View::write_slot_bindings(const Slot& slot, std::span<const SlotBinding> bindings) {
    Writer writer(program_->handles().device);
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        for (const PlanBinding& b : plan().passes[p].bindings) {
            if (b.source != BindingSource::host) continue;
            const SlotBinding& value = bindings[b.index];
            switch (b.type) {
                case VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR:
                    writer.structure(slot.sets[p], b, value.structure);
                    break;
                case VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER:
                    writer.texels(slot.sets[p], b, value.texels);
                    break;
                case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
                case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
                    writer.buffer(slot.sets[p], b, {value.buffer, value.offset, value.range});
                    break;
                default:
                    writer.image(slot.sets[p], b, {program_->sampler(b.linear), value.image, value.layout});
            }
        }
    }
}

const ResourceInstance& View::instance(const PlanBinding& binding) const {
    return memory_.at(binding.index, binding.previous ? 1 - parity_ : parity_);
}

bool View::set_param(size_t pass, size_t param, const ParamValue& value) {
    const PlanParam& p = plan().passes.at(pass).params.at(param);
    if (!fits(p.param, value)) return false;
    const std::vector<std::byte> bytes = value_bytes(p.param, value);
    std::memcpy(push_[pass].data() + p.offset, bytes.data(), bytes.size());
    return true;
}

bool View::set_param(std::string_view node, std::string_view param, const ParamValue& value) {
    const PlanPass* pass = plan().pass(node);
    for (size_t i = 0; pass && i < pass->params.size(); ++i)
        if (pass->params[i].param.name == param)
            return set_param(static_cast<size_t>(pass - plan().passes.data()), i, value);
    return false;
}

const ResourceInstance& View::output(std::string_view name) const {
    const PlanOutput* found = plan().output(name);
    if (!found) throw VulkanError(VK_ERROR_UNKNOWN, fmt::format("the plan has no output \"{}\"", name));
    return memory_.at(found->resource, parity_);
}

std::span<const std::byte> View::captured(std::string_view name) const {
    for (size_t i = 0; i < capture_passes_.size(); ++i)
        if (plan().passes[capture_passes_[i]].node == name)
            return {slots_[slot_].captures[i].data(), slots_[slot_].captures[i].size()};
    throw VulkanError(VK_ERROR_UNKNOWN, fmt::format("the plan does not capture \"{}\"", name));
}

std::vector<PassStatistics> View::statistics() const {
    const Slot& slot = slots_[slot_];
    std::vector<PassStatistics> result(plan().passes.size());
    std::vector<uint64_t> ticks(2 * result.size());
    const bool timed =
        slot.timestamps && !ticks.empty() &&
        vkGetQueryPoolResults(program_->handles().device, slot.timestamps.get(), 0,
                              static_cast<uint32_t>(ticks.size()), ticks.size() * sizeof(uint64_t),
                              ticks.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT) == VK_SUCCESS;
    for (size_t p = 0; p < result.size(); ++p) {
        if (timed)
            result[p].ms = static_cast<double>((ticks[2 * p + 1] - ticks[2 * p]) & tick_mask_) * ms_per_tick_;
        result[p].counters.resize(plan().passes[p].counters.size());
        std::memcpy(result[p].counters.data(),
                    slot.counters.data() + plan().passes[p].counter_base * sizeof(uint32_t),
                    result[p].counters.size() * sizeof(uint32_t));
    }
    return result;
}

}  // namespace penumbra
