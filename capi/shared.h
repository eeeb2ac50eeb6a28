// SPDX-License-Identifier: MIT
// What the parts of the C interface share: what its handles hold, structs that are read and written by their
// sizes, and the end of every exception.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/graph.h"
#include "penumbra/penumbra.h"

struct penumbra_nodes {
    penumbra::NodeSet set;
};
struct penumbra_plan {
    std::shared_ptr<const penumbra::Plan> plan;
    std::vector<penumbra::Requirement> needs;
    std::vector<std::vector<const char*>> accepted;                    // slot by slot
    std::vector<std::vector<const char*>> counters;                    // pass by pass
    std::map<const penumbra::Param*, std::vector<const char*>> enums;  // names of the plan's values
};
struct penumbra_program {
    std::shared_ptr<const penumbra::Program> program;
};
struct penumbra_transients {
    std::shared_ptr<const penumbra::TransientMemory> memory;
};
struct penumbra_view {
    std::unique_ptr<penumbra::View> view;
    penumbra::Externals externals;
};
struct penumbra_call {
    const penumbra::HostPassContext& context;
};

namespace penumbra::c {

[[noreturn]] void misuse(std::string place, std::string text);

// What every caller has of a struct at least: to the last member of the header's first version, which stays
// here whatever is added behind it. A struct without a line here is refused in any size.
template <class T>
constexpr size_t first_size = ~size_t{0};
#define PENUMBRA_FIRST(type, last) \
    template <>                    \
    inline constexpr size_t first_size<type> = offsetof(type, last) + sizeof(type::last)
PENUMBRA_FIRST(penumbra_error, text);
PENUMBRA_FIRST(penumbra_device, memory_user);
PENUMBRA_FIRST(penumbra_call_info, size);
PENUMBRA_FIRST(penumbra_fact, name);
PENUMBRA_FIRST(penumbra_input, layers);
PENUMBRA_FIRST(penumbra_output_use, access);
PENUMBRA_FIRST(penumbra_plan_request, hand_on_history);
PENUMBRA_FIRST(penumbra_slot, access);
PENUMBRA_FIRST(penumbra_plan_info, settles);
PENUMBRA_FIRST(penumbra_pass, type);
PENUMBRA_FIRST(penumbra_param, range);
PENUMBRA_FIRST(penumbra_requirement, value);
PENUMBRA_FIRST(penumbra_memory, persistent_bytes);
PENUMBRA_FIRST(penumbra_program_options, pipeline_cache);
PENUMBRA_FIRST(penumbra_view_options, user);
PENUMBRA_FIRST(penumbra_frame, flags);
PENUMBRA_FIRST(penumbra_handover, family_after);
PENUMBRA_FIRST(penumbra_external, handover);
PENUMBRA_FIRST(penumbra_output, bytes);
PENUMBRA_FIRST(penumbra_pass_statistics, counter_count);
#undef PENUMBRA_FIRST

// The size that the caller's struct says of itself, or of all elements of the array that begins with it: one
// that a struct can have, so that elements which lie as far apart are aligned.
template <class T>
uint32_t size_of(const T* from, const char* what) {
    if (!from) misuse(what, "is null");
    if (from->struct_size < first_size<T> || from->struct_size % alignof(T) != 0)
        misuse(std::string(what) + ".struct_size", "is no size of this struct; is it set?");
    return from->struct_size;
}

// The caller's struct as this library knows it: what an older one does not have is 0.
template <class T>
T read(const T* from, uint32_t size) {
    T own{};
    std::memcpy(&own, from, std::min<size_t>(size, sizeof own));
    return own;
}
template <class T>
T read(const T* from, const char* what) {
    return read(from, size_of(from, what));
}

// Into the caller's struct, as much of it as that has, which is `own.struct_size`.
template <class T>
void write(T* to, const T& own) {
    std::memcpy(static_cast<void*>(to), &own, std::min<size_t>(own.struct_size, sizeof own));
}
template <class T>
void write(T* to, T own, const char* what) {
    own.struct_size = size_of(to, what);
    write(to, own);
}

// An array's element.
template <class T>
T* at(T* list, uint32_t size, uint32_t index) {
    return reinterpret_cast<T*>(reinterpret_cast<uintptr_t>(list) + size_t{index} * size);
}

template <class T, class F>
void for_each(const T* list, uint32_t count, const char* what, F&& function) {
    const uint32_t size = count ? size_of(list, what) : 0;
    for (uint32_t i = 0; i < count; ++i) function(read(at(list, size, i), size));
}

inline std::vector<std::string> texts(const char* const* list, uint32_t count, const char* what) {
    if (count && !list) misuse(what, "is null");
    std::vector<std::string> out;
    for (uint32_t i = 0; i < count; ++i) {
        if (!list[i]) misuse(what, "holds a null");
        out.emplace_back(list[i]);
    }
    return out;
}

inline const char* named(const char* text, const char* what) {
    if (!text) misuse(what, "is null");
    return text;
}

template <class T>
T& given(T* pointer, const char* what) {
    if (!pointer) misuse(what, "is null");
    return *pointer;
}

// What a host asks for by its index, called `place`: one of the `things` that `owner` has.
template <class T>
const T& one_of(const std::vector<T>& list, uint32_t index, const char* place, std::string_view owner,
                const char* things) {
    if (index >= list.size())
        misuse(place, std::string(owner) + " has " + std::to_string(list.size()) + " " + things);
    return list[index];
}

// A pipeline's mistakes, on their way out.
struct Mistakes {
    Diagnostics diagnostics;
};

// The code of the exception that is being handled, which is described to the caller.
penumbra_code describe(penumbra_error* error) noexcept;
penumbra_code succeeded(penumbra_error* error) noexcept;

// Nothing passes this.
template <class F>
penumbra_code guarded(penumbra_error* error, F&& function) noexcept {
    try {
        function();
        return succeeded(error);
    } catch (...) {
        return describe(error);
    }
}

DeviceHandles handles_of(const penumbra_device* from);

}  // namespace penumbra::c
