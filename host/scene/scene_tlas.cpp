// SPDX-License-Identifier: MIT
// Every structure keeps its size and place for the scene's lifetime: objects keep their number of triangles,
// so a build after a move overwrites the old one.
#include "host/scene/scene_tlas.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace penumbra {
namespace {

constexpr VkBufferUsageFlags build_input =
    VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
    VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

template <class Function>
void load(VkDevice device, Function& function, const char* name) {
    function = reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
    if (!function) throw DeviceError(std::string("the device has no ") + name);
}

VkDeviceAddress address_of(VkDevice device, VkBuffer buffer) {
    const VkBufferDeviceAddressInfo ask{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr, buffer};
    return vkGetBufferDeviceAddress(device, &ask);
}

VkDeviceSize round_up(VkDeviceSize value, VkDeviceSize to) {
    return (value + to - 1) / to * to;
}

VkAccelerationStructureBuildGeometryInfoKHR build_info(VkAccelerationStructureTypeKHR type,
                                                       const VkAccelerationStructureGeometryKHR& geometry) {
    VkAccelerationStructureBuildGeometryInfoKHR info{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
    info.type = type;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    return info;
}

void built_before(VkCommandBuffer commands, VkPipelineStageFlags2 stages) {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
    barrier.srcAccessMask = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
    barrier.dstStageMask = stages;
    barrier.dstAccessMask = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.memoryBarrierCount = 1;
    dependency.pMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &dependency);
}

}  // namespace

SceneTlas::SceneTlas(Device& device, const Scene& scene, double frame, TexelsAs as)
    : device_(device), scene_(scene) {
    if (!device.caps().ray_query) throw DeviceError(device.info().name + " has no ray queries");
    load(device.get(), vk_.create, "vkCreateAccelerationStructureKHR");
    load(device.get(), vk_.sizes, "vkGetAccelerationStructureBuildSizesKHR");
    load(device.get(), vk_.build, "vkCmdBuildAccelerationStructuresKHR");
    load(device.get(), vk_.address, "vkGetAccelerationStructureDeviceAddressKHR");
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &limits};
    vkGetPhysicalDeviceProperties2(device.physical(), &properties);
    scratch_alignment_ = limits.minAccelerationStructureScratchOffsetAlignment;

    std::vector<uint32_t> record_of;
    if (has_alpha(scene)) {
        SceneAlpha alpha = make_scene_alpha(scene);
        const std::vector<Texel> records = alpha_uv_texels(alpha);
        alpha_uv_ =
            upload_texels_as(as, device, std::as_bytes(std::span(records)), VK_FORMAT_R32G32B32A32_UINT,
                             "the texture coordinates of alpha-tested triangles");
        alpha_map_ = upload_texels_as(as, device, std::as_bytes(std::span(alpha.map)), VK_FORMAT_R32_UINT,
                                      "the alpha masks");
        record_of = std::move(alpha.record_of);
    }
    split_objects(record_of);

    const std::vector<Triangle> triangles = scene.triangles(frame);
    vertices_ = make_host_buffer(device, std::max<VkDeviceSize>(triangles.size() * sizeof(Triangle), 16),
                                 build_input, "triangles of the acceleration structures");
    std::memcpy(vertices_.mapped, triangles.data(), triangles.size() * sizeof(Triangle));
    for (Object& object : objects_)
        object.blas =
            make_structure(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, triangle_geometry(object),
                           object.count, "an object's acceleration structure");
    instances_ = make_host_buffer(
        device, std::max<VkDeviceSize>(objects_.size() * sizeof(VkAccelerationStructureInstanceKHR), 16),
        build_input, "instances of the acceleration structure");
    write_instances();
    tlas_ = make_structure(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, instance_geometry(),
                           static_cast<uint32_t>(objects_.size()), "the scene's acceleration structure");

    VkDeviceSize scratch = scratch_alignment_ + tlas_.scratch_bytes;
    for (const Object& object : objects_) scratch += round_up(object.blas.scratch_bytes, scratch_alignment_);
    scratch_ = make_device_buffer(
        device, scratch, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
        "scratch memory of acceleration structures");
    std::vector<size_t> all(objects_.size());
    std::iota(all.begin(), all.end(), size_t{0});
    build(all);
}

// Triangles come object by object, and in each part by part. Translucent ones are left out.
void SceneTlas::split_objects(const std::vector<uint32_t>& record_of) {
    const std::vector<uint32_t> objects = scene_.triangle_objects();
    std::vector<bool> translucent;
    for (const Instance& instance : scene_.instances())
        for (const Part& part : scene_.model().meshes[static_cast<size_t>(instance.mesh)].parts)
            translucent.insert(translucent.end(), part.indices.size() / 3, scene_.translucent(part));
    const auto tested = [&](size_t t) { return !record_of.empty() && record_of[t] != 0; };
    for (size_t t = 0; t < objects.size(); ++t) {
        if (translucent[t]) continue;
        if (t == 0 || objects[t] != objects[t - 1] || tested(t) != tested(t - 1) || translucent[t - 1]) {
            Object& object = objects_.emplace_back();
            object.first = static_cast<uint32_t>(t);
            if (tested(t)) object.record = record_of[t] - 1;
            if (object.record.value_or(0) >= 1u << 24)
                throw DeviceError(
                    "more than 2^24 alpha-tested triangles do not fit an acceleration structure");
        }
        ++objects_.back().count;
    }
}

std::vector<uint32_t> SceneTlas::first_triangles() const {
    std::vector<uint32_t> first;
    for (const Object& object : objects_) first.push_back(object.first);
    return first;
}

void SceneTlas::update(double frame) {
    const std::vector<Triangle> triangles = scene_.triangles(frame);
    std::vector<size_t> moved;
    for (size_t i = 0; i < objects_.size(); ++i) {
        const Object& object = objects_[i];
        auto* held = static_cast<Triangle*>(vertices_.mapped) + object.first;
        const size_t bytes = object.count * sizeof(Triangle);
        if (std::memcmp(held, &triangles[object.first], bytes) == 0) continue;
        std::memcpy(held, &triangles[object.first], bytes);
        moved.push_back(i);
    }
    if (!moved.empty()) build(moved);
}

SceneTlas::Structure SceneTlas::make_structure(VkAccelerationStructureTypeKHR type,
                                               const VkAccelerationStructureGeometryKHR& geometry,
                                               uint32_t primitives, const char* what) {
    const VkAccelerationStructureBuildGeometryInfoKHR info = build_info(type, geometry);
    VkAccelerationStructureBuildSizesInfoKHR sizes{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    vk_.sizes(device_.get(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, &primitives, &sizes);
    Structure out;
    out.scratch_bytes = sizes.buildScratchSize;
    out.memory = make_device_buffer(
        device_, sizes.accelerationStructureSize,
        VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT,
        what);
    VkAccelerationStructureCreateInfoKHR create{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
    create.buffer = out.memory.get();
    create.size = sizes.accelerationStructureSize;
    create.type = type;
    VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
    check(vk_.create(device_.get(), &create, nullptr, &handle), "vkCreateAccelerationStructureKHR", what);
    out.handle = {device_.get(), handle};
    return out;
}

VkAccelerationStructureGeometryKHR SceneTlas::triangle_geometry(const Object& object) const {
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags = object.record ? 0 : VkGeometryFlagsKHR{VK_GEOMETRY_OPAQUE_BIT_KHR};
    auto& triangles = geometry.geometry.triangles;
    triangles = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR};
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    // Not by a build's primitiveOffset, whose 32 bits end at 4 GiB.
    triangles.vertexData.deviceAddress =
        address_of(device_.get(), vertices_.get()) + object.first * sizeof(Triangle);
    triangles.vertexStride = sizeof(Triangle) / 3;
    triangles.maxVertex = 3 * object.count - 1;
    triangles.indexType = VK_INDEX_TYPE_NONE_KHR;
    return geometry;
}

VkAccelerationStructureGeometryKHR SceneTlas::instance_geometry() const {
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    geometry.flags = VK_GEOMETRY_OPAQUE_BIT_KHR;
    geometry.geometry.instances = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
    geometry.geometry.instances.data.deviceAddress = address_of(device_.get(), instances_.get());
    return geometry;
}

void SceneTlas::write_instances() {
    auto* instance = static_cast<VkAccelerationStructureInstanceKHR*>(instances_.mapped);
    for (const Object& object : objects_) {
        const VkAccelerationStructureDeviceAddressInfoKHR ask{
            VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR, nullptr,
            object.blas.handle.get()};
        *instance = {};
        for (int i = 0; i < 3; ++i) instance->transform.matrix[i][i] = 1;
        instance->mask = 0xFF;
        instance->instanceCustomIndex = object.record.value_or(0) & 0xFFFFFFu;
        instance->flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
        instance->accelerationStructureReference = vk_.address(device_.get(), &ask);
        ++instance;
    }
}

void SceneTlas::build(const std::vector<size_t>& objects) {
    VkDeviceAddress scratch = round_up(address_of(device_.get(), scratch_.get()), scratch_alignment_);
    const VkAccelerationStructureGeometryKHR instances = instance_geometry();
    std::vector<VkAccelerationStructureGeometryKHR> geometries;
    geometries.reserve(objects.size());  // the build's description points into it
    std::vector<VkAccelerationStructureBuildGeometryInfoKHR> infos;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
    for (const size_t i : objects) {
        const Object& object = objects_[i];
        auto& info = infos.emplace_back(build_info(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                                   geometries.emplace_back(triangle_geometry(object))));
        info.dstAccelerationStructure = object.blas.handle.get();
        info.scratchData.deviceAddress = scratch;
        scratch += round_up(object.blas.scratch_bytes, scratch_alignment_);
        ranges.push_back({object.count, 0, 0, 0});
    }
    auto top = build_info(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, instances);
    top.dstAccelerationStructure = tlas_.handle.get();
    top.scratchData.deviceAddress = scratch;
    const VkAccelerationStructureBuildRangeInfoKHR top_range{static_cast<uint32_t>(objects_.size()), 0, 0, 0};
    const VkAccelerationStructureBuildRangeInfoKHR* top_ranges = &top_range;
    std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> range_pointers;
    for (const auto& range : ranges) range_pointers.push_back(&range);
    device_.run([&](VkCommandBuffer commands) {
        if (!infos.empty())
            vk_.build(commands, static_cast<uint32_t>(infos.size()), infos.data(), range_pointers.data());
        built_before(commands, VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR);
        vk_.build(commands, 1, &top, &top_ranges);
        built_before(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT);
    });
}

}  // namespace penumbra
