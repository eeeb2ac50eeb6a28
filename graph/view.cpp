// SPDX-License-Identifier: MIT
// A view's objects: immutable descriptor sets of internal resources per parity, and per frame in flight the
// sets that hold what the host passes.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "graph/interface.h"
#include "graph/view_state.h"

namespace penumbra {

namespace {

uint32_t level_count(const PlanPass& pass) {
    return std::max(static_cast<uint32_t>(pass.level_groups.size()), 1u);
}

// A mip chain's finest level.
uint64_t captured_bytes(const PlanResource& r) {
    if (r.kind == PortKind::image)
        return uint64_t{r.extent.width} * r.extent.height * r.layers * info(r.format).bytes;
    return r.count * r.element_bytes;
}

// The most descriptors that are written at once.
size_t binding_count(const Plan& plan) {
    size_t count = 0;
    for (const PlanPass& pass : plan.passes) count += pass.bindings.size();
    return count;
}

}  // namespace

ViewState::ViewState(std::shared_ptr<const Program> program, const ViewOptions& options)
    : keep_alive_(std::move(program)),
      program_(keep_alive_->state()),
      device_(*program_.device()),
      options_(options),
      memory_(device_, program_.plan(), options.transients),
      writer_(device_, binding_count(program_.plan())) {
    if (options_.frames_in_flight == 0) fail(ErrorCode::usage, "ViewOptions::frames_in_flight", "is 0");
    if (options_.heir_of && options_.heir_of->state().device_.get() != device_.get())
        fail(ErrorCode::usage, "ViewOptions::heir_of", "is on another device");
    if (options_.poison && !plan().poison)
        fail(ErrorCode::usage, "ViewOptions::poison", "needs a plan compiled with CompileOptions::poison");
    for (size_t i = 0; i < plan().passes.size(); ++i) {
        if (plan().passes[i].kind == PassKind::capture) capture_passes_.push_back(i);
        push_.push_back(plan().passes[i].push);
    }
    const uint32_t bits = device_.queue_families()[device_.handles().queue_family].timestampValidBits;
    if (options_.timestamps && bits > 0 && !plan().passes.empty()) {
        ms_per_tick_ = static_cast<double>(device_.properties().limits.timestampPeriod) * 1e-6;
        tick_mask_ = bits < 64 ? (uint64_t{1} << bits) - 1 : ~uint64_t{0};
    }
    const size_t resources = plan().resources.size(), slots = plan().slots.size();
    lent_.resize(resources);
    last_.lent.resize(resources);
    bound_.resize(slots);
    asked_to_rest_.resize(plan().members.size());
    resting_ = rested_ = asked_to_rest_;
    images_.reserve(resources + slots);
    buffers_.reserve(slots);
    ticks_.resize(2 * plan().passes.size());
    completed_.passes.resize(plan().passes.size());
    for (size_t p = 0; p < plan().passes.size(); ++p)
        completed_.passes[p].counters.resize(plan().passes[p].counters.size());
    inherited_.reserve(plan().reset.size());
    for (const ResetAction& action : plan().reset)  // whichever View::reset() is to name
        reset_.resource.reserve(plan().resources[action.resource].names.back().size());
    find_kept_memos();
    make_descriptor_pool();
    make_internal_sets();
    slots_.resize(options_.frames_in_flight);
    for (Slot& slot : slots_) make_slot(slot);
}

void ViewState::make_descriptor_pool() {
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
    const VkDevice device = device_.get();
    require(vk().vkCreateDescriptorPool(device, &create, nullptr, &pool), "vkCreateDescriptorPool",
            plan().pipeline);
    pool_ = {device_, pool};
}

VkDescriptorSet ViewState::allocate_set(size_t pass, size_t set) const {
    const VkDescriptorSetLayout layout = program_.pass(pass).set_layouts[set].get();
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_.get();
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    VkDescriptorSet handle = VK_NULL_HANDLE;
    require(vk().vkAllocateDescriptorSets(device_.get(), &allocate, &handle), "vkAllocateDescriptorSets",
            plan().passes[pass].node);
    return handle;
}

void ViewState::make_internal_sets() {
    internal_sets_.resize(plan().passes.size());
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        for (uint32_t parity = 0; parity < 2; ++parity)
            for (uint32_t level = 0; level < level_count(plan().passes[p]); ++level)
                internal_sets_[p][parity].push_back(make_internal_set(p, parity, level));
    }
}

VkDescriptorSet ViewState::make_internal_set(size_t p, uint32_t parity, uint32_t level) {
    const VkDescriptorSet set = allocate_set(p, 0);
    for (const PlanBinding& b : plan().passes[p].bindings) {
        if (b.set != 0) continue;
        const VkSampler sampler = program_.sampler(b.linear);
        const uint32_t of = b.previous ? 1 - parity : parity;
        if (b.source == BindingSource::table)
            writer_.image(set, b, {sampler, program_.table(b.index), VK_IMAGE_LAYOUT_GENERAL});
        else if (b.source == BindingSource::nothing)
            write_absent(set, b);
        else if (const ResourceHandles& r = memory_.at(b.index, of);
                 r.image && b.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER)
            writer_.buffer(set, b, {memory_.rows(b.index, of), 0, VK_WHOLE_SIZE});
        else if (r.image)
            writer_.image(set, b, {sampler, view_of(b, of, level), VK_IMAGE_LAYOUT_GENERAL});
        else if (b.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER)
            writer_.texels(set, b, r.texels);
        else
            writer_.buffer(set, b, {r.buffer, 0, VK_WHOLE_SIZE});
    }
    writer_.flush();
    return set;
}

// Storage images are one level: a chain's finest for readers of one, its own for whoever writes level by
// level.
VkImageView ViewState::view_of(const PlanBinding& b, uint32_t parity, uint32_t level) const {
    const uint32_t wanted = b.level == PlanBinding::Level::finest               ? 0
                            : b.level == PlanBinding::Level::finer && level > 0 ? level - 1
                                                                                : level;
    const VkImageView one =
        b.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE ? memory_.level(b.index, parity, wanted) : VK_NULL_HANDLE;
    return one ? one : memory_.at(b.index, parity).view;
}

void ViewState::write_absent(VkDescriptorSet set, const PlanBinding& b) {
    if (b.is_texels())
        writer_.texels(set, b, program_.absent_texels(b.format));
    else if (b.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || b.type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER)
        writer_.buffer(set, b, {program_.absent_buffer(), 0, VK_WHOLE_SIZE});
    else
        writer_.image(set, b, {program_.sampler(false), program_.absent_image(b), VK_IMAGE_LAYOUT_GENERAL});
}

void ViewState::make_slot(Slot& slot) {
    const auto passes = static_cast<uint32_t>(plan().passes.size());
    if (ms_per_tick_ > 0) {
        VkQueryPoolCreateInfo create{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
        create.queryType = VK_QUERY_TYPE_TIMESTAMP;
        create.queryCount = 2 * passes;
        VkQueryPool pool = VK_NULL_HANDLE;
        require(vk().vkCreateQueryPool(device_.get(), &create, nullptr, &pool), "vkCreateQueryPool",
                plan().pipeline);
        slot.timestamps = {device_, pool};
    }
    slot.frame_block =
        MappedBuffer(device_, sizeof(FrameBlock), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the frame block");
    slot.counters =
        MappedBuffer(device_, (plan().counters.size() + 1) * sizeof(uint32_t),
                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, "counters");
    for (const size_t p : capture_passes_)
        slot.captures.emplace_back(device_,
                                   captured_bytes(plan().resources[plan().passes[p].bindings.front().index]),
                                   VK_BUFFER_USAGE_TRANSFER_DST_BIT, "a capture of " + plan().passes[p].node);
    slot.sets.resize(passes);
    for (size_t p = 0; p < passes; ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        slot.sets[p] = allocate_set(p, 1);
        for (const PlanBinding& b : plan().passes[p].bindings) {
            if (b.source == BindingSource::frame_block)
                writer_.buffer(slot.sets[p], b, {slot.frame_block.get(), 0, VK_WHOLE_SIZE});
            if (b.source == BindingSource::counters)
                writer_.buffer(slot.sets[p], b, {slot.counters.get(), 0, VK_WHOLE_SIZE});
            if (b.set == 1 && b.source == BindingSource::nothing) write_absent(slot.sets[p], b);
        }
    }
    writer_.flush();
}

// Written every frame, even where a handle is the same as before: drivers reuse the values of destroyed
// handles.
void ViewState::write_slot_bindings(const Slot& slot) {
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        if (plan().passes[p].kind != PassKind::compute) continue;
        for (const PlanBinding& b : plan().passes[p].bindings) {
            if (b.set != 1 || (b.source != BindingSource::host && b.source != BindingSource::resource))
                continue;
            if (b.source == BindingSource::resource) {  // the host's image for an output
                writer_.image(slot.sets[p], b,
                              {program_.sampler(b.linear), lent_[b.index].view, VK_IMAGE_LAYOUT_GENERAL});
                continue;
            }
            const SlotBinding& value = bound_[b.index];
            switch (b.type) {
                case VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR:
                    writer_.structure(slot.sets[p], b, value.structure);
                    break;
                case VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER:
                case VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER:
                    writer_.texels(slot.sets[p], b, value.texels);
                    break;
                case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:  // with what lies behind, too large a range
                    writer_.buffer(slot.sets[p], b,
                                   {value.buffer, value.offset, plan().slots[b.index].bytes});
                    break;
                case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
                    writer_.buffer(slot.sets[p], b, {value.buffer, value.offset, value.range});
                    break;
                default:
                    writer_.image(slot.sets[p], b, {program_.sampler(b.linear), value.image, value.layout});
            }
        }
    }
    writer_.flush();
}

const ResourceHandles& ViewState::instance(uint32_t resource, bool previous) const {
    if (plan().resources[resource].slot) return lent_[resource];
    return memory_.at(resource, previous ? 1 - parity_ : parity_);
}

const ResourceHandles& ViewState::output(uint32_t resource) const {
    if (plan().resources[resource].slot) return last_.lent[resource];
    return memory_.at(resource, last_.parity);
}

bool ViewState::set_param(size_t pass, size_t param, const ParamValue& value) {
    if (pass >= plan().passes.size() || param >= plan().passes[pass].params.size()) return false;
    const PlanParam& p = plan().passes[pass].params[param];
    if (!fits(p.param, value)) return false;
    const std::vector<std::byte> bytes = value_bytes(p.param, value);
    std::byte* own = push_[pass].data() + p.offset;
    if (std::equal(bytes.begin(), bytes.end(), own)) return true;
    std::ranges::copy(bytes, own);
    set_ = true;
    for (KeptMemo& memo : kept_memos_)
        if (memo.makers[pass]) memo.stale = true;
    return true;
}

std::span<const std::byte> ViewState::captured(std::string_view name) const {
    for (size_t i = 0; i < capture_passes_.size(); ++i)
        if (plan().passes[capture_passes_[i]].node == name) {
            if (recorded_ == 0) return {};
            return {last_recorded().captures[i].data(), last_recorded().captures[i].size()};
        }
    fail(ErrorCode::usage, fmt::format("\"{}\"", name), "the plan does not capture it");
}

// Commands may be thrown away, and then the queries are those of an older frame or were never reset, which
// must not be read. So the host writes a word that the frame's own commands clear.
void ViewState::expect_to_run(const Slot& slot) const {
    constexpr uint32_t not_yet = 1;
    std::memcpy(slot.counters.data() + plan().counters.size() * sizeof not_yet, &not_yet, sizeof not_yet);
}

bool ViewState::has_run(const Slot& slot) const {
    uint32_t word = 0;
    std::memcpy(&word, slot.counters.data() + plan().counters.size() * sizeof word, sizeof word);
    return word == 0;
}

void ViewState::read_statistics(const Slot& slot, std::vector<PassStatistics>& passes,
                                std::vector<uint64_t>& ticks) const {
    const bool ran = has_run(slot);
    bool timed = false;
    if (slot.timestamps && ran) {
        const VkResult result = vk().vkGetQueryPoolResults(
            device_.get(), slot.timestamps.get(), 0, static_cast<uint32_t>(ticks.size()),
            ticks.size() * sizeof(uint64_t), ticks.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
        if (result != VK_NOT_READY) require(result, "vkGetQueryPoolResults", plan().pipeline);
        timed = result == VK_SUCCESS;
    }
    for (size_t p = 0; p < passes.size(); ++p) {
        passes[p].ms.reset();
        if (timed)
            passes[p].ms = static_cast<double>((ticks[2 * p + 1] - ticks[2 * p]) & tick_mask_) * ms_per_tick_;
        const std::byte* first = slot.counters.data() + plan().passes[p].counter_base * sizeof(uint32_t);
        for (uint32_t& counter : passes[p].counters) {
            counter = 0;
            if (ran) std::memcpy(&counter, first, sizeof counter);
            first += sizeof counter;
        }
    }
}

std::vector<PassStatistics> ViewState::statistics() const {
    if (recorded_ == 0) return {};
    std::vector<PassStatistics> passes = completed_.passes;  // of the right shape
    std::vector<uint64_t> ticks(ticks_.size());
    read_statistics(last_recorded(), passes, ticks);
    return passes;
}

uint64_t ViewState::bytes() const {
    uint64_t sum = memory_.bytes();
    for (const Slot& slot : slots_) {
        sum += slot.frame_block.allocated() + slot.counters.allocated();
        for (const MappedBuffer& capture : slot.captures) sum += capture.allocated();
    }
    return sum;
}

const ResourceHandles* HostPassContext::resource(std::string_view port) const {
    const PlanBinding* b = pass->binding(port);
    return b && b->source == BindingSource::resource ? &view->instance(b->index, b->previous) : nullptr;
}

const SlotBinding* HostPassContext::slot(std::string_view port) const {
    const PlanBinding* b = pass->binding(port);
    return b && b->source == BindingSource::host ? &view->bound(b->index) : nullptr;
}

std::optional<ParamValue> HostPassContext::param(std::string_view name) const {
    for (const PlanParam& p : pass->params)
        if (p.param.name == name)
            return value_of(p.param, view->push(static_cast<size_t>(pass - view->plan().passes.data()))
                                         .subspan(p.offset, layout_of(p.param.type).size));
    return std::nullopt;
}

View::View(std::shared_ptr<const Program> program, const ViewOptions& options) {
    if (!program) fail(ErrorCode::usage, "View", "the program is null");
    state_ = std::make_unique<ViewState>(std::move(program), options);
}
View::~View() = default;

namespace {

std::span<const SlotBinding> fitting(const Externals& slots, const Plan& plan) {
    if (!slots.fits(plan))
        fail(ErrorCode::usage, plan.pipeline, "the Externals are another plan's, of other slots");
    return slots;
}

}  // namespace

void View::record(VkCommandBuffer cmd, const FrameDescription& frame, const Externals& slots) {
    record(cmd, frame, fitting(slots, plan()));
}

void View::begin(VkCommandBuffer cmd, const FrameDescription& frame, const Externals& slots) {
    begin(cmd, frame, fitting(slots, plan()));
}

void View::record(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots) {
    state_->begin(cmd, frame, slots);
    for (size_t p = 0; p < plan().passes.size(); ++p) state_->record_pass(cmd, p);
    state_->end(cmd);
}

void View::begin(VkCommandBuffer cmd, const FrameDescription& frame, std::span<const SlotBinding> slots) {
    state_->begin(cmd, frame, slots);
}

void View::record_pass(VkCommandBuffer cmd, size_t pass) {
    state_->record_pass(cmd, pass);
}

void View::end(VkCommandBuffer cmd) {
    state_->end(cmd);
}

bool View::set_param(size_t pass, size_t param, const ParamValue& value) {
    return state_->set_param(pass, param, value);
}

bool View::set_awake(std::string_view member, bool awake) {
    return state_->set_awake(member, awake);
}

bool View::set_param(std::string_view node, std::string_view param, const ParamValue& value) {
    const PlanPass* pass = plan().pass(node);
    for (size_t i = 0; pass && i < pass->params.size(); ++i)
        if (pass->params[i].param.name == param)
            return set_param(static_cast<size_t>(pass - plan().passes.data()), i, value);
    return false;
}

const ResourceHandles& View::output(std::string_view name) const {
    const PlanOutput* found = plan().output(name);
    if (!found) fail(ErrorCode::usage, fmt::format("\"{}\"", name), "the plan has no such output");
    return state_->output(found->resource);
}

std::span<const std::byte> View::captured(std::string_view name) const {
    return state_->captured(name);
}

std::vector<PassStatistics> View::statistics() const {
    return state_->statistics();
}

const FrameStatistics* View::completed() const {
    return state_->completed();
}

bool View::settled() const {
    return state_->settled();
}

const Reset& View::reset() const {
    return state_->reset();
}

const Plan& View::plan() const {
    return state_->plan();
}

uint64_t View::bytes() const {
    return state_->bytes();
}

}  // namespace penumbra
