// SPDX-License-Identifier: MIT
// Views: frames in, outputs and statistics out.
#include "capi/shared.h"

using namespace penumbra;
using namespace penumbra::c;

namespace {

SlotBinding binding_of(const penumbra_external& e) {
    SlotBinding b;
    b.image = e.image;
    if (e.layout) b.layout = e.layout;
    b.texels = e.texels;
    b.buffer = e.buffer;
    b.offset = e.offset;
    b.range = e.range ? e.range : VK_WHOLE_SIZE;
    b.structure = e.structure;
    if (!e.handover) return b;
    const penumbra_handover h = read(e.handover, "externals.handover");
    Handover& own = b.handover.emplace();
    own.image = h.image;
    own.stages_before = h.stages_before;
    own.stages_after = h.stages_after;
    own.access_before = h.access_before;
    own.access_after = h.access_after;
    if (h.layout_before) own.layout_before = h.layout_before;
    if (h.layout_after) own.layout_after = h.layout_after;
    own.family_before = h.family_before;
    own.family_after = h.family_after;
    own.aspects = h.aspects;
    return b;
}

// With this frame's externals; what the last frame had is not this frame's.
View& bound(penumbra_view* view, const penumbra_external* externals, uint32_t count) {
    penumbra_view& v = given(view, "view");
    v.externals.clear();
    for_each(externals, count, "externals", [&](const penumbra_external& e) {
        const char* name = named(e.name, "externals.name");
        SlotBinding& slot = v.externals[name];
        if (slot.image || slot.texels || slot.buffer || slot.structure)
            misuse(std::string("externals of \"") + name + "\"", "stands there twice");
        slot = binding_of(e);
    });
    return *v.view;
}

Camera camera_of(const penumbra_camera& c) {
    Camera camera;
    std::ranges::copy(c.position, camera.position.begin());
    std::ranges::copy(c.world_from_view, camera.world_from_view.begin());
    std::ranges::copy(c.clip_from_view, camera.clip_from_view.begin());
    camera.near_m = c.near_m;
    return camera;
}

FrameDescription frame_of(const penumbra_frame& f) {
    FrameDescription frame;
    frame.camera = camera_of(f.camera);
    frame.previous = camera_of(f.previous);
    std::ranges::copy(f.jitter, frame.jitter.begin());
    std::ranges::copy(f.prev_jitter, frame.prev_jitter.begin());
    std::ranges::copy(f.size, frame.size.begin());
    frame.index = f.index;
    frame.dt_s = f.dt_s;
    frame.flags = f.flags;
    frame.sub_pixel_bits = f.sub_pixel_bits;
    return frame;
}

}  // namespace

penumbra_code penumbra_view_create(const penumbra_program* program, const penumbra_view_options* options,
                                   penumbra_view** view, penumbra_error* error) {
    return guarded(error, [&] {
        given(view, "view") = nullptr;
        const penumbra_view_options o =
            options ? read(options, "options")
                    : penumbra_view_options{sizeof o, 0, 0, 0, nullptr, nullptr, nullptr};
        ViewOptions own;
        if (o.frames_in_flight) own.frames_in_flight = o.frames_in_flight;
        own.timestamps = !o.no_timestamps;
        own.tables_uploaded = o.tables_uploaded;
        if (o.transients) own.transients = o.transients->memory;
        if (o.heir_of) own.heir_of = o.heir_of->view.get();
        own.user = o.user;
        const std::shared_ptr<const Program>& of = given(program, "program").program;
        *view = new penumbra_view{std::make_unique<View>(of, own), Externals(of->plan())};
    });
}

void penumbra_view_destroy(penumbra_view* view) {
    delete view;
}

penumbra_code penumbra_view_record(penumbra_view* view, VkCommandBuffer cmd, const penumbra_frame* frame,
                                   const penumbra_external* externals, uint32_t external_count,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        View& v = bound(view, externals, external_count);
        v.record(cmd, frame_of(read(frame, "frame")), view->externals);
    });
}

penumbra_code penumbra_view_begin(penumbra_view* view, VkCommandBuffer cmd, const penumbra_frame* frame,
                                  const penumbra_external* externals, uint32_t external_count,
                                  penumbra_error* error) {
    return guarded(error, [&] {
        View& v = bound(view, externals, external_count);
        v.begin(cmd, frame_of(read(frame, "frame")), view->externals);
    });
}

penumbra_code penumbra_view_record_pass(penumbra_view* view, VkCommandBuffer cmd, uint32_t pass,
                                        penumbra_error* error) {
    return guarded(error, [&] { given(view, "view").view->record_pass(cmd, pass); });
}

penumbra_code penumbra_view_end(penumbra_view* view, VkCommandBuffer cmd, penumbra_error* error) {
    return guarded(error, [&] { given(view, "view").view->end(cmd); });
}

penumbra_code penumbra_view_set_awake(penumbra_view* view, const char* member, VkBool32 awake,
                                      penumbra_error* error) {
    return guarded(error, [&] {
        View& v = *given(view, "view").view;
        if (!v.set_awake(named(member, "member"), awake))
            misuse(std::string("\"") + member + "\"", "the plan has no member of a family of this name" +
                                                          did_you_mean(member, v.plan().members));
    });
}

penumbra_code penumbra_view_output(const penumbra_view* view, const char* name, penumbra_output* output,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        const ResourceHandles& r = given(view, "view").view->output(named(name, "name"));
        write(output, {0, r.image, r.view, r.buffer, r.texels, r.bytes, 0, r.layout}, "output");
    });
}

penumbra_code penumbra_view_captured(const penumbra_view* view, const char* name, const void** data,
                                     size_t* size, penumbra_error* error) {
    return guarded(error, [&] {
        const auto bytes = given(view, "view").view->captured(named(name, "name"));
        given(data, "data") = bytes.data();
        given(size, "size") = bytes.size();
    });
}

penumbra_code penumbra_view_completed(const penumbra_view* view, uint64_t* frame, uint32_t* count,
                                      penumbra_pass_statistics* passes, penumbra_error* error) {
    return guarded(error, [&] {
        const View& v = *given(view, "view").view;
        const FrameStatistics* completed = v.completed();
        uint64_t& number = given(frame, "frame");
        const auto all = static_cast<uint32_t>(v.plan().passes.size());
        uint32_t& room = given(count, "count");
        if (passes && room < all) misuse("count", "the plan has " + std::to_string(all) + " passes");
        const uint32_t written = passes && completed ? all : 0;
        const uint32_t size = written ? size_of(passes, "passes") : 0;
        number = completed ? completed->frame : UINT64_MAX;
        room = all;
        for (uint32_t p = 0; p < written; ++p) {
            const PassStatistics& s = completed->passes[p];
            write<penumbra_pass_statistics>(at(passes, size, p),
                                            {size, v.plan().passes[p].node.c_str(), s.ms.value_or(-1),
                                             s.counters.data(), static_cast<uint32_t>(s.counters.size())});
        }
    });
}

const char* penumbra_view_reset_reason(const penumbra_view* view, const char** resource) {
    constexpr const char* names[] = {"none", "first_frame", "asked", "not_handed_on", "woken"};
    if (resource) *resource = "";
    if (!view) return names[0];
    const Reset& reset = view->view->reset();
    if (resource) *resource = reset.resource.c_str();
    return names[static_cast<size_t>(reset.reason)];
}

VkBool32 penumbra_view_settled(const penumbra_view* view) {
    return view && view->view->settled();
}

uint64_t penumbra_view_bytes(const penumbra_view* view) {
    return view ? view->view->bytes() : 0;
}
