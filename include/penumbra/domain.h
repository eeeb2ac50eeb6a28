// SPDX-License-Identifier: MIT
// What a node set is about, as data: the words that its declarations and pipelines may use beside the graph's
// own. Everything in graph/ works for any domain; a host's or a library's is its own.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/format.h"

namespace penumbra PENUMBRA_API {

// Elements that texel buffers hold on desktop devices and lavapipe; Vulkan promises 65 536.
inline constexpr uint32_t large_texel_buffer = 1u << 27;

// What a host may promise for a plan's lifetime; true where it says nothing.
struct Fact {
    std::string name, doc;
};
inline constexpr size_t max_facts = 11;

// Kinds of what a shader binds. The first four are words of declarations; `bundle` stands for a domain's own
// words, and `structure` (an acceleration structure) is a kind of host slot alone.
enum class PortKind : uint8_t { image, texels, buffer, block, bundle, structure };
const char* kind_name(PortKind kind);

// A port kind of the domain's own: the host fills several slots in place of one. Which ones depends on the
// backend, a constant enum parameter that node types with such a port may have; each backend is compiled on
// its own.
struct Bundle {
    struct Backend {
        std::string name;
        std::string feature;    // of the device, which it takes; empty: none
        std::string fact;       // that must hold for it; empty: none
        bool gpu_only = false;  // `auto` leaves it on a CPU device that has another
        std::string glsl;       // what its shaders begin with
    };
    // Which devices a part exists on, by the size of their texel buffers (large_texel_buffer): where these
    // are small (few) it comes as a buffer. Elsewhere a shader reads texels by texelFetch (fetched) or, if
    // faster (DeviceTable::loads_texels), by imageLoad (loaded): two parts of one slot.
    enum class Texels : uint8_t { any, few, fetched, loaded };
    struct Part {
        std::string name;  // the slot is PORT.name, PORT_name in GLSL; empty: PORT itself
        std::string slot;  // where it is not that of `name`
        PortKind kind = PortKind::texels;
        Format format = Format::r8;  // texels
        std::string element;         // block: the struct's name; buffer: as in declarations
        std::string backend;         // exists with this one alone; empty: with every one
        // Both of no structure, of which there is none to bind where it is absent.
        std::string fact;         // exists where it holds; empty: always. HAS_PORT_NAME in GLSL
        Texels on = Texels::any;  // exists on these devices alone. HAS_PORT_NAME in GLSL

        bool always() const { return fact.empty() && on == Texels::any; }
        const std::string& slot_name() const { return slot.empty() ? name : slot; }
    };
    std::string kind, doc;  // kind: the word in declarations
    std::string param;      // of this name, with values of the backends' and "auto"
    std::vector<Backend>
        backends;  // `auto` takes the first that the device has; types without the parameter the last
    std::vector<Part> parts;  // in the order of their bindings
};

// What a capability that a shader declares takes of a device, where it is none of Vulkan 1.3's own.
struct CapabilityNeed {
    std::vector<std::string> extensions, features;
};

struct Domain {
    std::vector<Fact> facts;                  // at most max_facts
    std::vector<std::string> features;        // what "needs" may ask of a device; the host says what it has
    std::map<std::string, uint32_t> structs;  // of blocks and buffers: bytes
    std::string structs_file;                 // what shaders include for them; empty: none
    std::vector<Bundle> bundles;
    std::map<uint32_t, CapabilityNeed> capabilities;  // by SPIR-V's number

    std::vector<std::string> fact_list() const;
};

}  // namespace penumbra
