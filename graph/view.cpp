// SPDX-License-Identifier: MIT
// A view's objects: immutable descriptor sets of internal resources per parity, and per frame in flight the
// sets that hold what the host passes.
#include "graph/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <deque>

namespace penumbra {
namespace {

// Collects descriptor writes; the infos they point to stay put until flush().
class Writer {
  public:
    explicit Writer(VkDevice device) : device_(device) {}
    ~Writer() { flush(); }
    void image(VkDescriptorSet set, uint32_t binding, VkDescriptorType type,
               const VkDescriptorImageInfo& info) {
        write(set, binding, type).pImageInfo = &images_.emplace_back(info);
    }
    void buffer(VkDescriptorSet set, uint32_t binding, VkDescriptorType type,
                const VkDescriptorBufferInfo& info) {
        write(set, binding, type).pBufferInfo = &buffers_.emplace_back(info);
    }
    void texels(VkDescriptorSet set, uint32_t binding, VkBufferView view) {
        write(set, binding, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER).pTexelBufferView =
            &views_.emplace_back(view);
    }
    void tlas(VkDescriptorSet set, uint32_t binding, VkAccelerationStructureKHR handle) {
        VkWriteDescriptorSetAccelerationStructureKHR structure{
            VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
        structure.accelerationStructureCount = 1;
        structure.pAccelerationStructures = &handles_.emplace_back(handle);
        write(set, binding, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR).pNext =
            &structures_.emplace_back(structure);
    }

  private:
    VkWriteDescriptorSet& write(VkDescriptorSet set, uint32_t binding, VkDescriptorType type) {
        VkWriteDescriptorSet w{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        w.dstSet = set;
        w.dstBinding = binding;
        w.descriptorCount = 1;
        w.descriptorType = type;
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

uint32_t level_count(const PlanPass& pass) {
    return std::max(static_cast<uint32_t>(pass.level_groups.size()), 1u);
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
        counts[VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER] += n;
        counts[VK_DESCRIPTOR_TYPE_STORAGE_BUFFER] += n;
        for (const Table& table : pass.entry->type.tables)
            if (exists(pass.variant, table.name)) counts[VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER] += n;
        for (const PlanBinding& binding : pass.bindings) {
            counts[descriptor_type(plan(), pass, binding)] += binding.host ? n : 2 * levels;
            if (writes_chain(binding)) counts[VK_DESCRIPTOR_TYPE_STORAGE_IMAGE] += 2 * levels;
        }
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
    const VkDevice device = program_->handles().device;
    const PlanPass& pass = plan().passes[p];
    const VkDescriptorSetLayout layout = program_->pass(p).set_layouts[0].get();
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_.get();
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(device, &allocate, &set), "vkAllocateDescriptorSets", pass.node);
    Writer writer(device);
    for (const PlanBinding& binding : pass.bindings) {
        if (binding.host) continue;
        const Port& port =
            binding.port->updates.empty() ? *binding.port : *pass.entry->type.port(binding.port->updates);
        const ResourceInstance& r = memory_.at(binding.index, binding.previous ? 1 - parity : parity);
        const VkDescriptorType type = descriptor_type(plan(), pass, binding);
        const auto image = [&](VkImageView view) {
            return VkDescriptorImageInfo{program_->sampler(port.linear), view, VK_IMAGE_LAYOUT_GENERAL};
        };
        // A storage image is one level: the one that a dispatch writes, or a chain's finest for readers of
        // one.
        const auto level_view = [&](uint32_t l) {
            return r.level_views.empty() ? r.image_view.get() : r.level_views[l].get();
        };
        if (r.image && type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE) {
            writer.image(set, binding.binding, type, image(level_view(writes_chain(binding) ? level : 0)));
            if (writes_chain(binding))
                writer.image(set, binding.binding + 1, type, image(level_view(level > 0 ? level - 1 : 0)));
        } else if (r.image) {
            writer.image(set, binding.binding, type, image(r.image_view.get()));
        } else if (type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER) {
            writer.texels(set, binding.binding, r.buffer_view.get());
        } else {
            writer.buffer(set, binding.binding, type, {r.buffer.get(), 0, VK_WHOLE_SIZE});
        }
    }
    return set;
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
    for (size_t p = 0; p < passes; ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        const VkDescriptorSetLayout layout = program_->pass(p).set_layouts[1].get();
        VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
        allocate.descriptorPool = pool_.get();
        allocate.descriptorSetCount = 1;
        allocate.pSetLayouts = &layout;
        check(vkAllocateDescriptorSets(handles.device, &allocate, &slot.sets[p]), "vkAllocateDescriptorSets",
              plan().passes[p].node);
    }
    write_fixed_bindings(slot);
}

void View::write_fixed_bindings(const Slot& slot) {
    Writer writer(program_->handles().device);
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        const PlanPass& pass = plan().passes[p];
        if (pass.kind != PassKind::compute) continue;
        const NodeType& type = pass.entry->type;
        writer.buffer(slot.sets[p], frame_binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                      {slot.frame_block.get(), 0, VK_WHOLE_SIZE});
        writer.buffer(slot.sets[p], counters_binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                      {slot.counters.get(), 0, VK_WHOLE_SIZE});
        for (uint32_t t = 0; t < type.tables.size(); ++t)
            if (exists(pass.variant, type.tables[t].name))
                writer.image(
                    slot.sets[p], first_table_binding(type) + t, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                    {program_->sampler(false), program_->table(type.name, type.tables[t].name).view.get(),
                     VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
    }
}

void View::check_slot_bindings(std::span<const SlotBinding> bindings) const {
    if (bindings.size() != plan().slots.size())
        throw VulkanError(VK_ERROR_INITIALIZATION_FAILED, fmt::format("{} slots were bound, the plan has {}",
                                                                      bindings.size(), plan().slots.size()));
    for (size_t i = 0; i < bindings.size(); ++i) {
        const SlotBinding& b = bindings[i];
        const PortKind kind = plan().slots[i].kind;
        const bool bound = kind == PortKind::image    ? b.image != VK_NULL_HANDLE
                           : kind == PortKind::texels ? b.texels != VK_NULL_HANDLE
                           : kind == PortKind::scene  ? b.tlas != VK_NULL_HANDLE
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
        const PlanPass& pass = plan().passes[p];
        if (pass.kind != PassKind::compute) continue;
        for (const PlanBinding& binding : pass.bindings) {
            if (!binding.host) continue;
            const SlotBinding& value = bindings[binding.index];
            const uint32_t at = binding.binding;
            const VkDescriptorType type = descriptor_type(plan(), pass, binding);
            if (type == VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR)
                writer.tlas(slot.sets[p], at, value.tlas);
            else if (type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER)
                writer.texels(slot.sets[p], at, value.texels);
            else if (type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER)
                writer.buffer(slot.sets[p], at, type, {value.buffer, value.offset, value.range});
            else
                writer.image(slot.sets[p], at, type,
                             {program_->sampler(binding.port->linear), value.image, value.layout});
        }
    }
}

const ResourceInstance& View::instance(const PlanBinding& binding) const {
    return memory_.at(binding.index, binding.previous ? 1 - parity_ : parity_);
}

bool View::set_param(std::string_view node, std::string_view param, const ParamValue& value) {
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        const PlanPass& pass = plan().passes[p];
        if (pass.node != node || !pass.entry) continue;
        const NodeType& type = pass.entry->type;
        const PushConstants layout = push_constants(type);
        for (size_t i = 0; i < type.params.size(); ++i)
            if (type.params[i].name == param && layout.offsets[i] && fits(type.params[i], value)) {
                const std::vector<std::byte> bytes = value_bytes(type.params[i], value);
                std::memcpy(push_[p].data() + *layout.offsets[i], bytes.data(), bytes.size());
                return true;
            }
    }
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
        if (!plan().passes[p].entry) continue;
        result[p].counters.resize(plan().passes[p].entry->type.counters.size());
        std::memcpy(result[p].counters.data(),
                    slot.counters.data() + plan().passes[p].counter_base * sizeof(uint32_t),
                    result[p].counters.size() * sizeof(uint32_t));
    }
    return result;
}

}  // namespace penumbra
