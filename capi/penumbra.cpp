// SPDX-License-Identifier: MIT
// The C header over the C++ interface: structs are read by their sizes, exceptions end here.
#include "penumbra/penumbra.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/version.h"

using namespace penumbra;

struct penumbra_plan {
    std::shared_ptr<const Plan> plan;
    std::vector<Requirement> needs;
};
struct penumbra_program {
    std::shared_ptr<const Program> program;
};
struct penumbra_transients {
    std::shared_ptr<const TransientMemory> memory;
};
struct penumbra_view {
    std::unique_ptr<View> view;
    Externals externals;
};

namespace {

static_assert(PENUMBRA_IMAGE == static_cast<int>(PortKind::image) && PENUMBRA_TEXELS == static_cast<int>(PortKind::texels) &&
              PENUMBRA_BUFFER == static_cast<int>(PortKind::buffer) && PENUMBRA_BLOCK == static_cast<int>(PortKind::block) &&
              PENUMBRA_STRUCTURE == static_cast<int>(PortKind::structure));

[[noreturn]] void misuse(std::string place, std::string text) {
    throw Failure({ErrorCode::usage, std::move(place), std::move(text), VK_SUCCESS});
}

// The sizes of the header's first version: what every caller has at least.
template <class T>
constexpr uint32_t first_size = sizeof(T);

// The caller's struct as this library knows it: what an older one does not have is 0.
template <class T>
T read(const T* from, const char* what) {
    if (!from) misuse(what, "is null");
    if (from->struct_size < first_size<T>) misuse(std::string(what) + ".struct_size", "is too small; is it set?");
    T own{};
    std::memcpy(&own, from, std::min<size_t>(from->struct_size, sizeof own));
    return own;
}

// Into the caller's struct, as much of it as that has; its size stays.
template <class T>
void write(T* to, T own, const char* what) {
    own.struct_size = read(to, what).struct_size;
    std::memcpy(static_cast<void*>(to), &own, std::min<size_t>(own.struct_size, sizeof own));
}

// Elements lie as far apart as the first says.
template <class T, class F>
void for_each(const T* list, uint32_t count, const char* what, F&& function) {
    if (count == 0) return;
    const uint32_t stride = read(list, what).struct_size;
    for (uint32_t i = 0; i < count; ++i)
        function(read(reinterpret_cast<const T*>(reinterpret_cast<const char*>(list) + size_t{i} * stride), what));
}

std::vector<std::string> texts(const char* const* list, uint32_t count, const char* what) {
    if (count && !list) misuse(what, "is null");
    std::vector<std::string> out;
    for (uint32_t i = 0; i < count; ++i) {
        if (!list[i]) misuse(what, "holds a null");
        out.emplace_back(list[i]);
    }
    return out;
}

const char* named(const char* text, const char* what) {
    if (!text) misuse(what, "is null");
    return text;
}

template <class T>
T& given(T* pointer, const char* what) {
    if (!pointer) misuse(what, "is null");
    return *pointer;
}

template <size_t n>
void copy_text(char (&to)[n], const std::string& from) {
    const size_t length = std::min(from.size(), n - 1);
    std::memcpy(to, from.data(), length);
    to[length] = '\0';
}

// A pipeline's mistakes, on their way out.
struct Mistakes {
    Diagnostics diagnostics;
};

penumbra_code report(penumbra_error* error, penumbra_code code, VkResult result, const std::string& place,
                     const std::string& text) {
    if (error && error->struct_size >= first_size<penumbra_error>) {
        error->code = code;
        error->result = result;
        copy_text(error->place, place);
        copy_text(error->text, text);
    }
    return code;
}

// Nothing passes this.
template <class F>
penumbra_code guarded(penumbra_error* error, F&& function) noexcept {
    try {
        function();
        return report(error, PENUMBRA_OK, VK_SUCCESS, "", "");
    } catch (const Failure& failure) {
        const Error& e = failure.error();
        return report(error, static_cast<penumbra_code>(e.code), e.result, e.place, e.text);
    } catch (const Mistakes& mistakes) {
        const Diagnostic& first = mistakes.diagnostics.list().front();
        Diagnostic place = first;
        place.message.clear();
        return report(error, PENUMBRA_PIPELINE, VK_SUCCESS,
                      first.place.file + ":" + std::to_string(first.place.line) + ":" +
                          std::to_string(first.place.column),
                      mistakes.diagnostics.text());
    } catch (const std::bad_alloc&) {
        if (error && error->struct_size >= first_size<penumbra_error>) {
            error->code = PENUMBRA_OUT_OF_MEMORY;
            error->result = VK_ERROR_OUT_OF_HOST_MEMORY;
            error->place[0] = '\0';
            std::strcpy(error->text, "no memory");
        }
        return PENUMBRA_OUT_OF_MEMORY;
    } catch (const std::exception& e) {
        return report(error, PENUMBRA_INTERNAL, VK_SUCCESS, "", e.what());
    } catch (...) {
        return report(error, PENUMBRA_INTERNAL, VK_SUCCESS, "", "something that is no exception was thrown");
    }
}

DeviceHandles handles_of(const penumbra_device* from) {
    const penumbra_device d = read(from, "device");
    DeviceHandles handles{d.instance, d.physical, d.device, d.queue_family, d.get_instance_proc_addr, {}};
    if (d.allocate)
        handles.memory.allocate = [d](const MemoryRequest& r, MemoryBlock& block) {
            const penumbra_memory_request request{sizeof request, r.properties, r.need, r.mapped, r.linear, r.what};
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

Plan make_plan(const penumbra_plan_request& r) {
    Mistakes mistakes;
    Diagnostics& errors = mistakes.diagnostics;
    const std::vector<std::string> settings = texts(r.settings, r.setting_count, "request.settings");
    const char* file = named(r.file, "request.file");
    const auto pipeline =
        r.text ? parse_pipeline(r.text, file, settings, errors) : load_pipeline(file, settings, errors);
    const auto checked = pipeline ? check(*pipeline, shadow_nodes(), errors) : std::nullopt;
    if (!checked) throw mistakes;
    Target target;
    target.extent = {r.width, r.height};
    target.device = r.device ? device_table(handles_of(r.device)) : reference_device();
    for (std::string& feature : texts(r.features, r.feature_count, "request.features"))
        target.device.features.insert(std::move(feature));
    for_each(r.facts, r.fact_count, "request.facts", [&](const penumbra_fact& fact) {
        target.facts[named(fact.name, "request.facts.name")] = fact.holds;
    });
    for_each(r.inputs, r.input_count, "request.inputs", [&](const penumbra_input& input) {
        const char* name = named(input.name, "request.inputs.name");
        if (input.left_out) {
            target.left_out.insert(name);
            return;
        }
        const auto format = format_named(named(input.format, "request.inputs.format"));
        if (!format) {
            const std::vector<std::string> names = format_names();
            misuse(std::string("request.inputs of \"") + name + "\"",
                   std::string("there is no format \"") + input.format + "\"" + did_you_mean(input.format, names));
        }
        target.inputs[name] = {*format, {input.width, input.height}, std::max(input.layers, 1u)};
    });
    CompileOptions options;
    options.captures = texts(r.captures, r.capture_count, "request.captures");
    options.share_transients = r.share_transients;
    options.hand_on_history = r.hand_on_history;
    for (const std::string& name : texts(r.host_images, r.host_image_count, "request.host_images"))
        options.outputs[name].host_image = true;
    auto plan = compile(*checked, target, options, errors);
    if (!plan) throw mistakes;
    return std::move(*plan);
}

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
    b.handover = Handover{h.image,        h.stages_before, h.stages_after, h.access_before, h.access_after,
                          h.layout_before, h.layout_after,  h.family_before, h.family_after, h.aspects};
    return b;
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
    return frame;
}

ParamValue param_of(const Param& param, const double* values, uint32_t count) {
    const uint32_t wanted = param.type == ParamType::vec2   ? 2
                            : param.type == ParamType::vec3 ? 3
                            : param.type == ParamType::vec4 ? 4
                                                            : 1;
    if (count != wanted || !values) misuse(param.name, "takes " + std::to_string(wanted) + " numbers");
    switch (param.type) {
        case ParamType::boolean:
            return values[0] != 0;
        case ParamType::integer:
            return static_cast<int32_t>(values[0]);
        case ParamType::uint:
            return static_cast<uint32_t>(values[0]);
        case ParamType::real:
            return static_cast<float>(values[0]);
        case ParamType::enumeration:
            if (values[0] < 0 || values[0] >= static_cast<double>(param.values.size()))
                misuse(param.name, "has no value of this index");
            return param.values[static_cast<size_t>(values[0])];
        default:
            return std::vector<float>(values, values + count);
    }
}

}  // namespace

const char* penumbra_version(void) {
    return PENUMBRA_VERSION_TEXT;
}

penumbra_code penumbra_plan_create(const penumbra_plan_request* request, penumbra_plan** plan,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        given(plan, "plan") = nullptr;
        auto made = std::make_unique<penumbra_plan>();
        made->plan = std::make_shared<const Plan>(make_plan(read(request, "request")));
        made->needs = requirements(*made->plan);
        *plan = made.release();
    });
}

void penumbra_plan_destroy(penumbra_plan* plan) {
    delete plan;
}

uint32_t penumbra_plan_slot_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->plan->slots.size()) : 0;
}

penumbra_code penumbra_plan_slot(const penumbra_plan* plan, uint32_t index, penumbra_slot* slot,
                                 penumbra_error* error) {
    return guarded(error, [&] {
        const std::vector<HostSlot>& slots = given(plan, "plan").plan->slots;
        if (index >= slots.size()) misuse("index", "the plan has " + std::to_string(slots.size()) + " slots");
        const HostSlot& s = slots[index];
        const bool texels = s.kind == PortKind::image || s.kind == PortKind::texels;
        write(slot,
              {0, static_cast<penumbra_slot_kind>(s.kind), s.name.c_str(),
               texels ? info(s.format).vk : VK_FORMAT_UNDEFINED, s.extent.width, s.extent.height, s.layers, s.bytes,
               s.output, s.required, s.use.stages, s.use.access},
              "slot");
    });
}

uint32_t penumbra_plan_requirement_count(const penumbra_plan* plan) {
    return plan ? static_cast<uint32_t>(plan->needs.size()) : 0;
}

penumbra_code penumbra_plan_requirement(const penumbra_plan* plan, uint32_t index,
                                        penumbra_requirement* requirement, penumbra_error* error) {
    return guarded(error, [&] {
        const std::vector<Requirement>& needs = given(plan, "plan").needs;
        if (index >= needs.size()) misuse("index", "the plan has " + std::to_string(needs.size()) + " requirements");
        const Requirement& r = needs[index];
        write(requirement, {0, kind_name(r.kind), r.name.c_str(), r.why.c_str(), r.value}, "requirement");
    });
}

penumbra_code penumbra_plan_memory(const penumbra_plan* plan, penumbra_memory* memory, penumbra_error* error) {
    return guarded(error, [&] {
        const MemoryReport& m = given(plan, "plan").plan->memory;
        write(memory, {0, m.heap_bytes, m.shared_bytes, m.persistent_bytes}, "memory");
    });
}

penumbra_code penumbra_program_create(const penumbra_device* device, const penumbra_plan* plan,
                                      const penumbra_program_options* options, penumbra_program** program,
                                      penumbra_error* error) {
    return guarded(error, [&] {
        given(program, "program") = nullptr;
        const penumbra_program_options o =
            options ? read(options, "options") : penumbra_program_options{sizeof o, 0, nullptr};
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

void penumbra_program_record_uploads(const penumbra_program* program, VkCommandBuffer cmd) {
    if (program && cmd) program->program->record_uploads(cmd);
}

penumbra_code penumbra_transients_create(const penumbra_program* program, penumbra_transients** transients,
                                         penumbra_error* error) {
    return guarded(error, [&] {
        given(transients, "transients") = nullptr;
        *transients = new penumbra_transients{given(program, "program").program->make_transients()};
    });
}

void penumbra_transients_destroy(penumbra_transients* transients) {
    delete transients;
}

uint64_t penumbra_transients_bytes(const penumbra_transients* transients) {
    return transients ? bytes_of(*transients->memory) : 0;
}

penumbra_code penumbra_view_create(const penumbra_program* program, const penumbra_view_options* options,
                                   penumbra_view** view, penumbra_error* error) {
    return guarded(error, [&] {
        given(view, "view") = nullptr;
        const penumbra_view_options o =
            options ? read(options, "options") : penumbra_view_options{sizeof o, 0, 0, 0, nullptr, nullptr};
        ViewOptions own;
        if (o.frames_in_flight) own.frames_in_flight = o.frames_in_flight;
        own.timestamps = !o.no_timestamps;
        own.tables_uploaded = o.tables_uploaded;
        if (o.transients) own.transients = o.transients->memory;
        if (o.heir_of) own.heir_of = o.heir_of->view.get();
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
        penumbra_view& v = given(view, "view");
        v.externals = Externals(v.view->plan());  // what the last frame had is not this frame's
        for_each(externals, external_count, "externals", [&](const penumbra_external& e) {
            v.externals[named(e.name, "externals.name")] = binding_of(e);
        });
        v.view->record(cmd, frame_of(read(frame, "frame")), v.externals);
    });
}

penumbra_code penumbra_view_set_param(penumbra_view* view, const char* node, const char* param,
                                      const double* values, uint32_t count, penumbra_error* error) {
    return guarded(error, [&] {
        View& v = *given(view, "view").view;
        const PlanPass* pass = v.plan().pass(named(node, "node"));
        if (!pass) misuse("node", std::string("no node \"") + node + "\" runs in this plan");
        for (size_t i = 0; i < pass->params.size(); ++i) {
            const Param& p = pass->params[i].param;
            if (p.name != named(param, "param")) continue;
            if (!v.set_param(static_cast<size_t>(pass - v.plan().passes.data()), i, param_of(p, values, count)))
                misuse(std::string(node) + "." + param, "the value is out of range");
            return;
        }
        misuse("param", std::string(node) + " has no dynamic parameter \"" + param + "\"");
    });
}

penumbra_code penumbra_view_output(const penumbra_view* view, const char* name, penumbra_output* output,
                                   penumbra_error* error) {
    return guarded(error, [&] {
        const ResourceHandles& r = given(view, "view").view->output(named(name, "name"));
        write(output, {0, r.image, r.view, r.buffer, r.texels, r.bytes}, "output");
    });
}

penumbra_code penumbra_view_captured(const penumbra_view* view, const char* name, const void** data, size_t* size,
                                     penumbra_error* error) {
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
        given(frame, "frame") = completed ? completed->frame : UINT64_MAX;
        const auto all = static_cast<uint32_t>(v.plan().passes.size());
        uint32_t& room = given(count, "count");
        if (passes && room < all) misuse("count", "the plan has " + std::to_string(all) + " passes");
        room = all;
        if (!passes || !completed) return;
        const uint32_t stride = read(passes, "passes").struct_size;
        for (uint32_t p = 0; p < all; ++p) {
            const PassStatistics& s = completed->passes[p];
            auto* to = reinterpret_cast<penumbra_pass_statistics*>(reinterpret_cast<char*>(passes) + size_t{p} * stride);
            write(to,
                  {0, v.plan().passes[p].node.c_str(), s.ms.value_or(-1), s.counters.data(),
                   static_cast<uint32_t>(s.counters.size())},
                  "passes");
        }
    });
}

const char* penumbra_view_reset_reason(const penumbra_view* view, const char** resource) {
    constexpr const char* names[] = {"none", "first_frame", "asked", "not_handed_on"};
    if (!view) return names[0];
    const Reset& reset = view->view->reset();
    if (resource) *resource = reset.resource.c_str();
    return names[static_cast<size_t>(reset.reason)];
}

uint64_t penumbra_view_bytes(const penumbra_view* view) {
    return view ? view->view->bytes() : 0;
}
