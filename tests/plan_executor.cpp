// SPDX-License-Identifier: MIT
#include "tests/plan_executor.h"

#include <algorithm>
#include <cstring>

#include "tests/plan_objects.h"

namespace penumbra::test {

struct PlanExecutor::Parts : PlanObjects {
    std::map<std::string, GpuImage> no_image;
    std::map<std::string, Owned<VkBufferView>> no_texels;
    std::vector<GpuImage> slot_images;  // of this frame, by slot
    std::vector<GpuTexels> slot_texels;
    std::vector<GpuBuffer> slot_buffers;
    uint32_t frames = 0, parity = 0;
    std::array<uint32_t, 2> size{};  // of this frame

    explicit Parts(const std::filesystem::path& folder) : PlanObjects(folder) {}

    const Instance& instance(size_t resource, bool previous) const {
        const std::vector<Instance>& both = resources[resource];
        return both.size() == 1 ? both[0] : both[previous ? 1 - parity : parity];
    }

    // What follows the frame's size, of this frame.
    std::array<uint32_t, 2> follow(const Json& follows) const {
        std::array<uint32_t, 2> of = size;
        for (const Json& step : follows)
            for (size_t axis = 0; axis < 2; ++axis) {
                const uint32_t div = step[axis], mul = step[2 + axis];
                of[axis] = std::max((of[axis] + div - 1) / div * mul, 1u);
            }
        return of;
    }

    std::array<uint32_t, 2> size_of(const Json& thing) const {
        return thing["follows"].is_null() ? thing["size"].get<std::array<uint32_t, 2>>()
                                          : follow(thing["follows"]);
    }

    std::array<uint32_t, 3> groups_of(const Json& pass, const Json& largest, uint32_t level) const {
        auto groups = largest.get<std::array<uint32_t, 3>>();
        if (pass["follows"].is_null()) return groups;
        const std::array<uint32_t, 2> over = follow(pass["follows"]);
        for (size_t axis = 0; axis < 2; ++axis) {
            const uint32_t pixels = pass["group_pixels"][axis];
            groups[axis] = (std::max(over[axis] >> level, 1u) + pixels - 1) / pixels;
        }
        return groups;
    }

    void bring(const std::map<std::string, std::vector<std::byte>>& slots) {
        slot_images.clear();
        slot_texels.clear();
        slot_buffers.clear();
        for (const Json& slot : plan["slots"]) {
            const std::vector<std::byte>& bytes = slots.at(slot["name"]);
            slot_images.emplace_back();
            slot_texels.emplace_back();
            slot_buffers.emplace_back();
            if (slot["kind"] == "image") {
                slot_images.back() =
                    make_image(gpu(), formats.at(slot["format"]), {size_of(slot)[0], size_of(slot)[1]}, 1,
                               VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, "slot");
                upload_image(gpu(), slot_images.back(), bytes);
            } else if (slot["kind"] == "texels") {
                slot_texels.back() = upload_texels(gpu(), bytes, formats.at(slot["format"]), "slot");
            } else {
                slot_buffers.back() = upload_buffer(
                    gpu(), bytes, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                    "slot");
            }
        }
    }

    // 1x1 images that are bound and never read, in the general layout.
    VkImageView no_image_view(const Json& b, VkCommandBuffer cmd) {
        const std::string key = b["format"].get<std::string>() + (b["array"] ? "[]" : "");
        GpuImage& image = no_image[key];
        if (!image.get()) {
            image = (b["array"] ? make_layered_image : make_image)(
                gpu(), formats.at(b["format"]), {1, 1}, 1,
                b["type"] == "storage_image" ? VK_IMAGE_USAGE_STORAGE_BIT : VK_IMAGE_USAGE_SAMPLED_BIT,
                "nothing");
            VkImageMemoryBarrier2 barrier = activation(image.get());
            if (is_depth(image.format)) barrier.subresourceRange.aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT;
            barrier.dstStageMask = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
            barrier.dstAccessMask = VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
            record_barrier(cmd, nullptr, {barrier});
        }
        return image.view.get();
    }

    static VkImageMemoryBarrier2 activation(VkImage image) {
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image;
        barrier.subresourceRange = whole;
        return barrier;
    }

    static void record_barrier(VkCommandBuffer cmd, const VkMemoryBarrier2* memory,
                               const std::vector<VkImageMemoryBarrier2>& images) {
        VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        info.memoryBarrierCount = memory ? 1 : 0;
        info.pMemoryBarriers = memory;
        info.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
        info.pImageMemoryBarriers = images.data();
        if (memory || !images.empty()) vkCmdPipelineBarrier2(cmd, &info);
    }

    void record_dependency(VkCommandBuffer cmd, const Json& d) const {
        VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
        memory.srcStageMask = flags(d["from_stages"], stages);
        memory.srcAccessMask = flags(d["from_access"], accesses);
        memory.dstStageMask = flags(d["to_stages"], stages);
        memory.dstAccessMask = flags(d["to_access"], accesses);
        std::vector<VkImageMemoryBarrier2> images;
        for (const Json& a : d["activations"]) {
            images.push_back(activation(instance(a["resource"], false).image.get()));
            images.back().srcStageMask = flags(a["from_stages"], stages);
            images.back().srcAccessMask = flags(a["from_access"], accesses);
            images.back().dstStageMask = flags(a["to_stages"], stages);
            images.back().dstAccessMask = flags(a["to_access"], accesses);
        }
        record_barrier(cmd, memory.srcStageMask ? &memory : nullptr, images);
    }

    static void record_everything(VkCommandBuffer cmd, std::vector<VkImageMemoryBarrier2> images) {
        constexpr VkAccessFlags2 any = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
        const VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,   nullptr,
                                      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, any,
                                      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, any};
        for (VkImageMemoryBarrier2& image : images) {
            image.srcStageMask = image.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
            image.dstAccessMask = any;
        }
        record_barrier(cmd, &memory, images);
    }

    static void record_clear(VkCommandBuffer cmd, const Instance& r) {
        const VkClearColorValue zero{};
        if (r.image)
            vkCmdClearColorImage(cmd, r.image.get(), VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &whole);
        else
            vkCmdFillBuffer(cmd, r.buffer.get(), 0, VK_WHOLE_SIZE, 0);
    }

    VkDescriptorSet fill(const Json& pass, const Pass& objects, uint32_t set, uint32_t level,
                         VkCommandBuffer cmd) {
        const VkDescriptorSetLayout layout = objects.layouts[set].get();
        VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
        allocate.descriptorPool = pool.get();
        allocate.descriptorSetCount = 1;
        allocate.pSetLayouts = &layout;
        VkDescriptorSet handle = VK_NULL_HANDLE;
        check(vkAllocateDescriptorSets(device(), &allocate, &handle), "vkAllocateDescriptorSets", "");
        for (const Json& b : pass["bindings"]) {
            if (b["set"] != set) continue;
            VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
            write.dstSet = handle;
            write.dstBinding = b["binding"];
            write.descriptorCount = 1;
            write.descriptorType = descriptor_types.at(b["type"]);
            VkDescriptorImageInfo image{b["filter"] == "linear" ? linear.get() : nearest.get(),
                                        VK_NULL_HANDLE, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
            VkDescriptorBufferInfo buffer{VK_NULL_HANDLE, 0, VK_WHOLE_SIZE};
            VkBufferView texels = VK_NULL_HANDLE;
            const std::string source = b["source"];
            if (source == "resource") {
                const Instance& r = instance(b["index"], b["previous"]);
                const bool one = b["type"] == "storage_image";
                const size_t which = !one || b["level"] == "finest"   ? 0
                                     : b["level"] == "finer" && level ? level - 1
                                                                      : level;
                if (r.image) image.imageView = r.views[one ? 1 + which : 0].get();
                image.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
                buffer.buffer = r.buffer.get();
                texels = r.texels.get();
            } else if (source == "slot") {
                const size_t s = b["index"];
                image.imageView = slot_images[s].view.get();
                buffer.buffer = slot_buffers[s].get();
                texels = slot_texels[s].view.get();
            } else if (source == "table") {
                image.imageView = tables[b["index"]].view.get();
                image.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
            } else if (source == "frame_block") {
                buffer.buffer = block.get();
            } else if (source == "counters") {
                buffer.buffer = counters.get();
            } else {
                buffer.buffer = nothing.get();
                if (b["type"] == "texel_buffer" || b["type"] == "storage_texel_buffer") {
                    Owned<VkBufferView>& view = no_texels[b["format"]];
                    if (!view) view = texels_of(nothing.get(), b["format"]);
                    texels = view.get();
                } else if (!b["format"].is_null()) {
                    image.imageView = no_image_view(b, cmd);
                    image.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
                }
            }
            write.pImageInfo = &image;
            write.pBufferInfo = &buffer;
            write.pTexelBufferView = &texels;
            vkUpdateDescriptorSets(device(), 1, &write, 0, nullptr);
        }
        return handle;
    }

    void record_pass(VkCommandBuffer cmd, const Json& pass, const Pass& objects) {
        record_dependency(cmd, pass["before"][parity]);
        for (const Json& resource : pass["clears"]) record_clear(cmd, instance(resource, false));
        record_dependency(cmd, pass["after_clears"][parity]);
        std::vector<Json> dispatches(pass["level_groups"].begin(), pass["level_groups"].end());
        if (dispatches.empty()) dispatches.push_back(pass["groups"]);
        const VkDescriptorSet host = fill(pass, objects, 1, 0, cmd);
        auto push = pass["push"].get<std::vector<uint32_t>>();
        vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, objects.pipeline.get());
        for (uint32_t level = 0; level < dispatches.size(); ++level) {
            if (level) {  // it reads the level before
                const VkMemoryBarrier2 memory{
                    VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,     nullptr,
                    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT};
                record_barrier(cmd, &memory, {});
            }
            const VkDescriptorSet sets[] = {fill(pass, objects, 0, level, cmd), host};
            vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, objects.layout.get(), 0, 2, sets, 0,
                                    nullptr);
            if (!pass["mip_level"].is_null()) push[pass["mip_level"].get<size_t>() / 4] = level;
            if (!push.empty())
                vkCmdPushConstants(cmd, objects.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                   static_cast<uint32_t>(4 * push.size()), push.data());
            if (!pass["indirect"].is_null())
                vkCmdDispatchIndirect(cmd, instance(pass["indirect"]["resource"], false).buffer.get(),
                                      pass["indirect"]["offset"]);
            else {
                const std::array<uint32_t, 3> groups = groups_of(pass, dispatches[level], level);
                vkCmdDispatch(cmd, groups[0], groups[1], groups[2]);
            }
        }
    }

    void record_reset(VkCommandBuffer cmd) const {
        std::vector<VkImageMemoryBarrier2> images;
        for (const Json& action : plan["reset"])
            if (const Instance& r = instance(action["resource"], true); r.image)
                images.push_back(activation(r.image.get()));
        record_everything(cmd, images);
        for (const Json& action : plan["reset"])
            if (action["clear"]) record_clear(cmd, instance(action["resource"], true));
        record_everything(cmd, {});
    }

    void frame(const std::vector<std::byte>& bytes,
               const std::map<std::string, std::vector<std::byte>>& slots) {
        parity = frames & 1;
        if (bytes.size() != plan["frame_block"]["bytes"]) throw std::runtime_error("another frame block");
        std::memcpy(block.mapped, bytes.data(), bytes.size());
        std::memset(counters.mapped, 0, counters.bytes);
        check(vkResetDescriptorPool(device(), pool.get(), 0), "vkResetDescriptorPool", "");
        uint32_t frame_flags = 0;
        for (const Json& member : plan["frame_block"]["members"]) {
            const std::byte* at = bytes.data() + member["offset"].get<size_t>();
            if (member["name"] == "flags") std::memcpy(&frame_flags, at, sizeof frame_flags);
            if (member["name"] == "size") std::memcpy(size.data(), at, sizeof size);
        }
        bring(slots);
        gpu().run([&](VkCommandBuffer cmd) {
            if (frames == 0 || (frame_flags & 1)) record_reset(cmd);
            for (size_t p = 0; p < passes.size(); ++p) record_pass(cmd, plan["passes"][p], passes[p]);
            record_dependency(cmd, plan["end"][parity]);
        });
        ++frames;
    }

    std::vector<std::byte> output(const std::string& name) const {
        for (const Json& output : plan["outputs"]) {
            if (output["name"] != name) continue;
            const Json& r = plan["resources"][output["resource"].get<size_t>()];
            const std::vector<std::byte> whole_image =
                read_image(gpu(), instance(output["resource"], false).image.get(), formats.at(r["format"]),
                           {r["size"][0], r["size"][1]}, VK_IMAGE_LAYOUT_GENERAL);
            const std::array<uint32_t, 2> part = size_of(r);
            const size_t row = whole_image.size() / r["size"][1].get<size_t>(), width = r["size"][0];
            std::vector<std::byte> bytes;
            for (size_t y = 0; y < part[1]; ++y)
                bytes.insert(bytes.end(), whole_image.begin() + row * y,
                             whole_image.begin() + row * y + row / width * part[0]);
            return bytes;
        }
        throw std::invalid_argument("no output " + name);
    }
};

PlanExecutor::PlanExecutor(const std::filesystem::path& folder) : parts_(std::make_unique<Parts>(folder)) {}
PlanExecutor::~PlanExecutor() = default;

void PlanExecutor::frame(const std::vector<std::byte>& frame_block,
                         const std::map<std::string, std::vector<std::byte>>& slots) {
    parts_->frame(frame_block, slots);
}

std::vector<std::string> PlanExecutor::slots() const {
    std::vector<std::string> names;
    for (const Json& slot : parts_->plan["slots"]) names.push_back(slot["name"]);
    return names;
}

std::vector<std::byte> PlanExecutor::output(const std::string& name) const {
    return parts_->output(name);
}

}  // namespace penumbra::test
