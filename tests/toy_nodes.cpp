// SPDX-License-Identifier: MIT
// The declarations as text. They borrow the shadow nodes' names but keep only what a rule of the front end
// needs.
#include "tests/toy_nodes.h"

#include <map>
#include <stdexcept>

#include "penumbra/shadow_nodes.h"

namespace penumbra::test {

namespace {

const std::map<std::string, std::string>& declarations() {
    static const std::map<std::string, std::string> texts = {
        {"guides", R"({
  "node": "guides", "doc": "Small copies of the host's depth and normal.", "shader": "guides.comp",
  "inputs": {
    "depth":  { "kind": "image", "format": ["d32", "r32f"] },
    "normal": { "kind": "image", "format": ["rgba16f", "rgb10a2"] }
  },
  "outputs": {
    "view_depth":   { "kind": "image", "format": "r32f" },
    "guide_normal": { "kind": "image", "format": "rgb10a2" }
  },
  "dispatch": { "over": "frame", "group": [8, 8] }
})"},
        {"pyramid", R"({
  "node": "pyramid", "doc": "Mip chain of lower bounds.", "shader": "pyramid.comp",
  "inputs":  { "cascade_maps": { "kind": "image", "format": ["d32", "d16"], "layers": true } },
  "outputs": { "bounds": { "kind": "image", "format": "r32f", "layers": true, "levels": true, "extent": "cascade_maps" } },
  "dispatch": { "over": "bounds" }
})"},
        {"classify", R"({
  "node": "classify", "doc": "Decides what is traced.", "shader": "classify.comp",
  "inputs": {
    "view_depth": { "kind": "image", "format": "r32f", "as": "storage" },
    "sun":        { "kind": "block", "element": "Sun" },
    "bounds":     { "kind": "image", "format": "r32f", "layers": true, "levels": true, "if": "mode=cascades" }
  },
  "outputs": {
    "tile_list": { "kind": "buffer", "element": "uvec4", "count": { "of": "frame", "div": [8, 4] }, "writes": "some" },
    "args":      { "kind": "buffer", "element": "u32", "count": 4, "indirect": true },
    "hits":      { "kind": "buffer", "element": "u32", "count": { "of": "view_depth", "div": [8, 4], "mul": 1, "add": 1 } },
    "debug":     { "kind": "image", "format": "rgba8", "optional": true }
  },
  "params": {
    "mode": { "type": "enum", "values": ["normals", "cascades"], "default": "normals", "constant": true, "doc": "what decides" },
    "bias": { "type": "float", "default": 0.5, "range": [0, 1], "unit": "m", "doc": "added to depth" }
  },
  "dispatch": { "over": "frame", "group": [8, 4], "per_thread": [1, 2] },
  "classes": { "cpu": { "group": [64, 1], "per_thread": [8, 1] } },
  "counters": ["receivers", "listed"]
})"},
        {"trace", R"({
  "node": "trace", "doc": "One ray per undecided pixel.", "shader": "trace.comp", "needs": ["ray_query"],
  "inputs": {
    "args":      { "kind": "buffer", "element": "u32", "indirect": true },
    "tile_list": { "kind": "buffer", "element": "uvec4" },
    "hits":      { "kind": "buffer", "element": "u32" },
    "scene":     { "kind": "scene" }
  },
  "outputs": { "traced": { "kind": "buffer", "updates": "hits" } },
  "tables": { "noise": { "file": "noise.bin", "format": "rg8", "extent": [128, 128] } },
  "params": { "cone": { "type": "vec3", "default": [0, 1, 0], "doc": "axis" } },
  "dispatch": { "indirect": "args", "offset": 0, "group": [32, 1] }
})"},
        {"denoise", R"({
  "node": "denoise", "doc": "Words to a signal.", "shader": "denoise.comp", "needs": ["jitter"],
  "inputs": {
    "words":      { "kind": "buffer", "element": "u32" },
    "view_depth": { "kind": "image", "format": "r32f" },
    "motion":     { "kind": "image", "format": ["rgba16f", "rg16f"], "optional": true },
    "history":    { "kind": "image", "format": ["r16f", "r8"], "filter": "linear", "previous": true, "optional": true }
  },
  "outputs": {
    "signal": { "kind": "image", "format": ["rg16f", "r16f"], "writes": "tiles" },
    "meta":   { "kind": "texels", "format": "r32ui", "extent": { "of": "frame", "div": [8, 8] }, "first": "clear" }
  },
  "dispatch": { "over": "signal", "group": [8, 8] }
})"},
        {"filter", R"({
  "node": "filter", "doc": "One a-trous pass.", "shader": "filter.comp",
  "inputs": {
    "signal": { "kind": "image", "format": ["rg16f", "r16f"] },
    "meta":   { "kind": "texels", "format": "r32ui", "optional": true }
  },
  "outputs": { "filtered": { "kind": "image", "format": ["r16f", "r8", "rg16f"], "range": [[0, 1], [0, 8]] } },
  "params": {
    "step": { "type": "int", "default": 1, "range": [1, 16], "unit": "px", "constant": true, "doc": "between taps" },
    "strength": { "type": "float", "default": 1, "range": [0, 4], "doc": "of the filter" },
    "sharp": { "type": "bool", "default": false, "doc": "keep edges" }
  },
  "dispatch": { "over": "frame", "group": [8, 8] }
})"},
        {"accumulate", R"({
  "node": "accumulate", "doc": "Adds in place.", "shader": "accumulate.comp",
  "inputs": {
    "sum":    { "kind": "image", "format": ["r16f", "r32f"], "as": "storage" },
    "addend": { "kind": "image", "format": ["r16f", "r8"], "optional": true }
  },
  "outputs": { "total": { "kind": "image", "updates": "sum", "range": [0, 8] } },
  "dispatch": { "over": "sum", "group": [8, 8] }
})"},
        {"shade", R"({
  "node": "shade", "doc": "Light.", "shader": "shade.comp",
  "inputs": {
    "albedo":     { "kind": "image", "format": ["rgba8", "rgba16f"] },
    "visibility": { "kind": "image", "format": ["r16f", "r8"], "optional": true }
  },
  "outputs": { "lit": { "kind": "image", "format": "rgba16f" } },
  "dispatch": { "over": "frame", "group": [8, 8] }
})"},
        {"taa", R"({
  "node": "taa", "doc": "Anti-aliasing over time.", "shader": "taa.comp",
  "inputs": {
    "lit":     { "kind": "image", "format": "rgba16f" },
    "history": { "kind": "image", "format": "rgba16f", "filter": "linear", "previous": true }
  },
  "outputs": { "color": { "kind": "image", "format": "rgba16f" } },
  "dispatch": { "over": "frame", "group": [8, 8] }
})"},
        {"fill", R"({
  "node": "fill", "doc": "A constant image.", "shader": "fill.comp",
  "outputs": { "value": { "kind": "image", "format": ["r16f", "r8"] } },
  "params": {
    "level": { "type": "float", "default": 1, "doc": "what it holds" },
    "weight": { "type": "float", "default": 0.5, "range": [0, 1], "constant": true, "doc": "of what it holds" },
    "flat": { "type": "bool", "default": false, "constant": true, "doc": "the same everywhere" }
  },
  "dispatch": { "over": "value", "group": [8, 8] }
})"},
        {"stats", R"({
  "node": "stats", "doc": "Writes a struct that the set lacks.", "shader": "stats.comp",
  "outputs": { "histogram": { "kind": "buffer", "element": "Histogram", "count": { "of": "frame", "div": [16, 16] } } },
  "dispatch": { "groups": [1, 1, 1], "group": [64, 1, 1] }
})"},
        {"flat_layers", R"({
  "node": "flat_layers", "doc": "Layers without a mip chain.", "shader": "flat_layers.comp",
  "inputs":  { "cascade_maps": { "kind": "image", "format": ["d32", "d16"], "layers": true } },
  "outputs": { "bounds": { "kind": "image", "format": "r32f", "layers": true, "extent": "cascade_maps" } },
  "dispatch": { "over": "cascade_maps" }
})"},
        {"tint", R"({
  "node": "tint", "doc": "A port that a fact decides.", "shader": "tint.comp",
  "inputs": {
    "lit":  { "kind": "image", "format": "rgba16f" },
    "mask": { "kind": "image", "format": ["r16f", "r8"], "if": "alpha" }
  },
  "outputs": { "tinted": { "kind": "image", "format": "rgba16f" } },
  "dispatch": { "over": "frame", "group": [8, 8] }
})"},
        {"probe", R"({
  "node": "probe", "doc": "Recorded by the host.", "host": true,
  "inputs":  { "image": { "kind": "image", "format": ["r16f", "r32f"] } },
  "outputs": { "report": { "kind": "buffer", "element": "Report", "count": 1 } }
})"},
    };
    return texts;
}

}  // namespace

std::string toy_declaration(const std::string& name) {
    return declarations().at(name);
}

std::string toy_pipeline() {
    return R"({
  "penumbra": 1,
  "name": "toy",
  "doc": "Classify, trace, denoise, anti-alias.",
  "inputs": { "depth": { "history": "host" }, "normal": {}, "motion": { "optional": true }, "albedo": {}, "sun": {}, "scene": {} },
  "outputs": ["color"],
  "nodes": {
    "guides":   { "type": "guides" },
    "classify": { "type": "classify", "if": "casters" },
    "trace":    { "type": "trace", "if": "casters" },
    "denoise":  { "type": "denoise", "if": "casters", "in": { "words": "traced", "history": "half@-1" } },
    "filter0":  { "type": "filter", "if": "casters", "out": { "filtered": "half" } },
    "filter1":  { "type": "filter", "if": "casters", "in": { "signal": "half" }, "out": { "filtered": "visibility" }, "params": { "step": 2 } },
    "lit":      { "type": "fill", "if": "!casters", "out": { "value": "visibility" } },
    "shade":    { "type": "shade" },
    "taa":      { "type": "taa", "in": { "history": "color@-1" } }
  }
}
)";
}

NodeType parse_toy(const std::string& text, const std::string& name) {
    Diagnostics diagnostics;
    const std::optional<Json> json = parse_json(text, name + ".json", diagnostics);
    std::optional<NodeType> type;
    if (json) type = parse_node_type(*json, name, toy_domain(), diagnostics);
    if (!type) throw std::runtime_error(diagnostics.text());
    return *type;
}

std::shared_ptr<const Domain> toy_domain() {
    static const auto domain = [] {
        Domain toys = *shadow_domain();
        std::erase_if(toys.facts, [](const Fact& fact) { return fact.name == "glossy"; });  // for room
        toys.facts.push_back({"hdr", "colours may exceed 1"});
        toys.structs = {{"Sun", 16}, {"Scene", 16}, {"Report", 64}};
        return std::make_shared<const Domain>(std::move(toys));
    }();
    return domain;
}

NodeSet toy_nodes() {
    NodeSet set(toy_domain());
    for (const auto& [name, text] : declarations()) set.add({.type = parse_toy(text, name)});
    return set;
}

}  // namespace penumbra::test
