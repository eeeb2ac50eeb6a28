// SPDX-License-Identifier: MIT
// A pipeline as written: which nodes, wired how. load_pipeline resolves `extends` and settings; check()
// (check.h) resolves names against a node set and finds every error a pipeline can have.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/node_type.h"

namespace penumbra PENUMBRA_API {

struct HostInput {
    enum class Extent : uint8_t { frame, fixed, any };

    std::string name;
    std::string kind_word;         // as written, if it is; a domain may have kinds of its own
    std::optional<PortKind> kind;  // what check() makes of it, or of the readers
    const Bundle* bundle = nullptr;
    std::optional<Format> format;  // else whatever the readers accept and the host brings
    Extent extent = Extent::frame;
    std::array<uint32_t, 2> size{0, 0};  // Extent::fixed
    bool history = false;                // the host also brings the last recorded frame's value, for @-1
    bool optional = false;
    Place place, kind_place;
    std::optional<Place> format_place, extent_place;
    std::string instances;  // a family: the host brings one to each of its members
    Place instances_place;
};

// `port: "name"`, `port: "name@-1"` or `port: null` (explicitly unbound). `port: "name@before"` is what the
// member before this node's own has of that name, nothing for a family's first; `port: "name@last"` what the
// last one has.
struct Wire {
    enum class Member : uint8_t { own, before, last };

    std::string port;
    std::string resource;  // empty: null
    bool previous = false;
    Member member = Member::own;
    Place port_place, place;
};

struct PipelineNode {
    std::string id;
    std::string type;
    std::vector<Wire> in, out;
    std::vector<JsonMember> params;
    std::optional<Json> condition;  // which check() parses: facts are the node set's
    std::string with;               // an input without which the node does not run, or empty
    std::string doc;
    Place place, type_place, with_place;
    std::string instances;  // a family: the node exists once for each of its members
    Place instances_place;
};

// One of a family, as one of several lights: nodes and inputs of the family exist for it, under names that
// end in its own.
struct PipelineInstance {
    struct Fact {
        bool holds = false;
        Place place;
    };
    std::string name;
    std::string family;
    std::map<std::string, Fact> facts;  // of its nodes, whatever they are of the target
    Place place;
};

struct ResourceSetting {
    std::string name;
    std::optional<Format> format;
    std::optional<First> first;
    Place place, format_place;
};

struct OutputName {
    std::string name;
    Place place;
};

struct Pipeline {
    std::string name;
    std::string doc;
    std::string file;
    std::vector<HostInput> inputs;
    std::vector<PipelineNode> nodes;
    std::vector<PipelineInstance> instances;
    std::vector<ResourceSetting> resources;
    std::vector<OutputName> outputs;
};

// "nodes.filter0.params.step=2", as --set gives it.
std::optional<Pipeline> load_pipeline(const std::filesystem::path& file,
                                      std::span<const std::string> settings, Diagnostics& diagnostics);

// A file's text; nothing: there is none of this name.
using ReadFile = std::function<std::optional<std::string>(const std::string& file)>;

// The same from text, for hosts that keep pipelines in memory. `extends` is relative to `file`'s folder, and
// is read from the disk, or by `read`, which gets that folder and the name as one path without dots.
std::optional<Pipeline> parse_pipeline(std::string_view text, const std::string& file,
                                       std::span<const std::string> settings, Diagnostics& diagnostics,
                                       const ReadFile& read = {});

}  // namespace penumbra
