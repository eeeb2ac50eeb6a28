// SPDX-License-Identifier: MIT
// A scene's triangles in the device's own acceleration structures, for trace's backend `ray_query`. They are
// those of SceneBvh, in the same frame of reference and to the same bit: one bottom level per object, so that
// only what has moved is built anew, with its vertices already in place (the top level's transforms are
// identities and round nothing). Alpha-tested triangles have structures of their own, which are not opaque
// and carry the number of their first record (scene_alpha.h).
#pragma once

#include <optional>

#include "host/device/gpu.h"
#include "host/scene/scene.h"
#include "host/scene/scene_alpha.h"

namespace penumbra {

// An extension's function: asked for by name, which happens once per object.
template <>
inline void destroy<VkAccelerationStructureKHR>(VkDevice device, VkAccelerationStructureKHR handle) {
    reinterpret_cast<PFN_vkDestroyAccelerationStructureKHR>(
        vkGetDeviceProcAddr(device, "vkDestroyAccelerationStructureKHR"))(device, handle, nullptr);
}

class SceneTlas {
  public:
    // Builds for the scene at `frame`. The device has ray queries; `scene` must outlive the structures.
    SceneTlas(Device& device, const Scene& scene, double frame, TexelsAs as = TexelsAs::texels);

    // Moves to another frame; nothing on the device may be reading the structures.
    void update(double frame);
    // Per instance, the number of its first triangle in Scene::triangles().
    std::vector<uint32_t> first_triangles() const;

    VkAccelerationStructureKHR get() const { return tlas_.handle.get(); }
    // None where nothing is alpha-tested. SceneBvh's hold the same records, and serve both.
    const GpuTexels& alpha_uv() const { return alpha_uv_; }
    const GpuTexels& alpha_map() const { return alpha_map_; }

  private:
    struct Functions {
        PFN_vkCreateAccelerationStructureKHR create = nullptr;
        PFN_vkGetAccelerationStructureBuildSizesKHR sizes = nullptr;
        PFN_vkCmdBuildAccelerationStructuresKHR build = nullptr;
        PFN_vkGetAccelerationStructureDeviceAddressKHR address = nullptr;
    };
    struct Structure {
        GpuBuffer memory;
        Owned<VkAccelerationStructureKHR> handle;  // declared after its memory, so destroyed before it
        VkDeviceSize scratch_bytes = 0;
    };
    // A run of an object's triangles, all opaque or all alpha-tested.
    struct Object {
        uint32_t first = 0, count = 0;   // triangles
        std::optional<uint32_t> record;  // of the first; none: opaque
        Structure blas;
    };

    Structure make_structure(VkAccelerationStructureTypeKHR type,
                             const VkAccelerationStructureGeometryKHR& geometry, uint32_t primitives,
                             const char* what);
    void split_objects(const std::vector<uint32_t>& record_of);
    VkAccelerationStructureGeometryKHR triangle_geometry(const Object& object) const;
    VkAccelerationStructureGeometryKHR instance_geometry() const;
    void write_instances();
    void build(const std::vector<size_t>& objects);

    Device& device_;
    const Scene& scene_;
    Functions vk_;
    VkDeviceSize scratch_alignment_ = 1;
    GpuBuffer vertices_, instances_, scratch_;
    GpuTexels alpha_uv_, alpha_map_;
    std::vector<Object> objects_;
    Structure tlas_;
};

}  // namespace penumbra
