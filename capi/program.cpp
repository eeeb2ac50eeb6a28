// SPDX-License-Identifier: MIT
// The caller's device and memory; programs, and the memory that views share.
#include "capi/shared.h"

using namespace penumbra;
using namespace penumbra::c;

namespace penumbra::c {

DeviceHandles handles_of(const penumbra_device* from) {
    const penumbra_device d = read(from, "device");
    DeviceHandles handles{d.instance, d.physical,        d.device, d.queue_family, d.get_instance_proc_addr,
                          {},         d.debug_utils != 0};
    if (d.allocate)
        handles.memory.allocate = [d](const MemoryRequest& r, MemoryBlock& block) {
            const penumbra_memory_request request{sizeof request, r.properties, r.need,    r.mapped,
                                                  r.linear,       r.what,       r.readback};
            penumbra_memory_block given{sizeof given, VK_NULL_HANDLE, 0, nullptr, nullptr};
            const VkResult result = d.allocate(d.memory_user, &request, &given);
            block = {given.memory, given.offset, given.mapped, given.user};
            return result;
        };
    if (d.release)
        handles.memory.release = [d](const MemoryBlock& b) {
            const penumbra_memory_block block{sizeof block, b.memory, b.offset, b.mapped, b.user};
            d.release(d.memory_user, &block);
        };
    return handles;
}

}  // namespace penumbra::c

penumbra_code penumbra_program_create(const penumbra_device* device, const penumbra_plan* plan,
                                      const penumbra_program_options* options, penumbra_program** program,
                                      penumbra_error* error) {
    return guarded(error, [&] {
        given(program, "program") = nullptr;
        const penumbra_program_options o =
            options ? read(options, "options") : penumbra_program_options{sizeof o, 0, nullptr};
        if (o.pipeline_cache_size && !o.pipeline_cache)
            misuse("options.pipeline_cache", "is null, and has a size");
        *program = new penumbra_program{std::make_shared<const Program>(
            handles_of(device), given(plan, "plan").plan,
            ProgramOptions{{static_cast<const std::byte*>(o.pipeline_cache), o.pipeline_cache_size}})};
    });
}

void penumbra_program_destroy(penumbra_program* program) {
    delete program;
}

penumbra_code penumbra_program_pipeline_cache(const penumbra_program* program, size_t* size, void* data,
                                              penumbra_error* error) {
    return guarded(error, [&] {
        const std::vector<std::byte> cache = given(program, "program").program->pipeline_cache();
        size_t& room = given(size, "size");
        if (data && room < cache.size())
            misuse("size", "the cache has " + std::to_string(cache.size()) + " bytes");
        room = cache.size();
        if (data) std::memcpy(data, cache.data(), cache.size());
    });
}

penumbra_code penumbra_program_record_uploads(const penumbra_program* program, VkCommandBuffer cmd) {
    return guarded(nullptr, [&] {
        const penumbra_program& p = given(program, "program");
        if (!cmd) misuse("cmd", "is null");
        p.program->record_uploads(cmd);
    });
}

penumbra_code penumbra_transients_create(const penumbra_program* program, penumbra_transients** transients,
                                         penumbra_error* error) {
    return guarded(error, [&] {
        given(transients, "transients") = nullptr;
        *transients = new penumbra_transients{given(program, "program").program->make_transients()};
    });
}

penumbra_code penumbra_transients_create_for(const penumbra_program* const* programs, uint32_t count,
                                             penumbra_transients** transients, penumbra_error* error) {
    return guarded(error, [&] {
        given(transients, "transients") = nullptr;
        if (count) given(programs, "programs");
        std::vector<const Program*> all;
        for (uint32_t i = 0; i < count; ++i) all.push_back(given(programs[i], "programs").program.get());
        *transients = new penumbra_transients{make_transients(all)};
    });
}

void penumbra_transients_destroy(penumbra_transients* transients) {
    delete transients;
}

uint64_t penumbra_transients_bytes(const penumbra_transients* transients) {
    return transients ? bytes_of(*transients->memory) : 0;
}
