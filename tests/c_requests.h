// SPDX-License-Identifier: MIT
// What tests hand to penumbra.h: structs that say their size, the tests' device, a pipeline of one node.
#pragma once

#include "penumbra/penumbra.h"
#include "tests/gpu_test.h"

namespace penumbra::test {

template <class T>
T sized() {
    T t{};
    t.struct_size = sizeof t;
    return t;
}

inline const char* const c_pipeline =
    R"({ "penumbra": 1, "name": "c", "inputs": { "depth": {}, "normal": {} },
    "outputs": ["view_depth"], "nodes": { "guides": { "type": "guides" } } })";

inline penumbra_plan_request request_of(const char* pipeline) {
    auto request = sized<penumbra_plan_request>();
    request.width = 29;
    request.height = 13;
    request.file = "c.json";
    request.text = pipeline;
    return request;
}

inline penumbra_device c_device() {
    auto device = sized<penumbra_device>();
    device.queue_family = gpu().queue_family();
    device.instance = gpu().instance();
    device.physical = gpu().physical();
    device.device = gpu().get();
    device.get_instance_proc_addr = vkGetInstanceProcAddr;
    return device;
}

// By some camera, in both frames.
inline void look(penumbra_frame& frame) {
    for (penumbra_camera* camera : {&frame.camera, &frame.previous}) {
        for (const int k : {0, 5, 14}) camera->clip_from_view[k] = 1;
        camera->clip_from_view[11] = -1;
        for (int k = 0; k < 9; k += 4) camera->world_from_view[k] = 1;
    }
}

// A plan of C's, and what went wrong with it.
class CGpuTest : public GpuTest {
  protected:
    penumbra_error error_ = sized<penumbra_error>();
    penumbra_plan* plan_ = nullptr;
    ~CGpuTest() override { penumbra_plan_destroy(plan_); }
};

}  // namespace penumbra::test
