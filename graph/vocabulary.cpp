// SPDX-License-Identifier: MIT
#include "graph/vocabulary.h"

#include <algorithm>

#include "penumbra/node_type.h"

namespace penumbra {
namespace vocabulary {
namespace {

constexpr Kinds image = bit(PortKind::image), texels = bit(PortKind::texels), buffer = bit(PortKind::buffer),
                block = bit(PortKind::block);
constexpr Kinds memory = image | texels | buffer;  // what nodes write
constexpr Kinds none = 0;

constexpr Kinds truth = bit(ParamType::boolean), chosen = bit(ParamType::enumeration),
                vectors = bit(ParamType::vec2) | bit(ParamType::vec3) | bit(ParamType::vec4);

constexpr uint32_t max_factor = 1u << 16;  // far beyond any image, and products fit 64 bits
constexpr uint32_t max_count = 1u << 28;

// A row is a key.
// clang-format off
constexpr auto declaration_keys = std::to_array<Key>({
    {"$schema", Holds::text, "nodes/node.schema.json as seen from the file, for editors"},
    {"node", Holds::id, "the type's name, equal to the file's without .json", {.required = true}},
    {"doc", Holds::line, "what the node does", {.required = true}},
    {"shader", Holds::shader, "the compute shader beside the declaration"},
    {"host", Holds::yes, "a program's callback records the node instead of a shader"},
    {"needs", Holds::needs, "what the device must have, and what the host must do"},
    {"jittered", Holds::truths,
     "what a plan with this node takes for true where its host jitters, whatever the host says"},
    {"inputs", Holds::objects,
     "read only; a port's name is its name in GLSL and the resource it binds to by default",
     {.object = &port}},
    {"outputs", Holds::objects, "written; a node without any counts what it reads", {.object = &port}},
    {"tables", Holds::objects, "static data beside the declaration", {.object = &table}},
    {"params", Holds::objects, "what a pipeline may set", {.object = &param}},
    {"dispatch", Holds::object, "how many threads run",
     {.required = true, .object = &dispatch, .beside = "shader"}},
    {"classes", Holds::object, "other constants or group sizes by the device's class", {.object = &classes}},
    {"counters", Holds::ids, "sums that the shader counts by count_NAME(n), reported per pass"},
});

constexpr auto port_keys = std::to_array<Key>({
    {"kind", Holds::kind,
     "image: 2D. texels: a linear buffer with format and extent. buffer: of `element`. block: uniform, the "
     "host's. Others: what the host hands over as several slots",
     {.required = true, .out = memory | unknown_kind}},
    {"format", Holds::formats, "what is accepted, the default first",
     {.required = true, .min_items = 1, .in = image, .out = none}},
    {"format", Holds::storables,
     "the default first; one SPIR-V is compiled for each that the shader must name. Input: what is accepted",
     {.required = true, .min_items = 1, .in = texels, .out = image | texels, .updating = false}},
    {"as", Holds::word, "how the shader sees it; default: sampled",
     {.words = "sampled storage", .in = image, .out = none}},
    {"as", Holds::word, "how the shader sees it", {.words = "storage", .in = none, .out = image}},
    {"filter", Holds::word, "of a sampled image of real numbers; default: nearest",
     {.words = "nearest linear", .in = image, .out = none}},
    {"layers", Holds::flag,
     "a 2D array; an output takes the extent, and their number, of a port with layers",
     {.in = image, .out = image, .updating = false}},
    {"layers_of", Holds::id, "a port of texels: an array of as many layers as that has rows",
     {.in = none, .out = image, .updating = false, .beside = "layers"}},
    {"levels", Holds::flag,
     "a mip chain; an output's is written level by level, a dispatch over it for each",
     {.in = image, .out = image, .updating = false}},
    {"in_rows", Holds::flag,
     "the shader, which stores by store_NAME(), is compiled for an image whose memory is a buffer's, too",
     {.in = none, .out = image, .updating = false}},
    {"element", Holds::structure, "of the array", {.required = true, .words = "u32 uvec2 uvec4 f32 vec4",
     .in = buffer, .out = buffer, .updating = false}},
    {"element", Holds::structure, "that the block holds", {.required = true, .in = block, .out = none}},
    {"extent", Holds::id, "\"frame\" (default), or a port whose extent it has",
     {.object = &extent, .in = none, .out = image | texels, .updating = false}},
    {"count", Holds::whole, "elements", {.required = true, .object = &count, .least = 1,
     .greatest = max_count, .in = none, .out = buffer, .updating = false}},
    {"writes", Holds::word,
     "default: all. tiles: what is not written is never read. some: cleared first. kept: what is not "
     "written stays as in the frame before, 0 after a reset",
     {.words = "all tiles some kept", .in = none, .out = memory, .updating = false}},
    {"memo", Holds::flag,
     "what frames before left in it, kept or read as @-1, spares work and changes nothing that a pipeline "
     "puts out", {.in = none, .out = memory, .updating = false}},
    {"settles", Holds::whole,
     "after how many frames that are alike what it takes from its own @-1 gets no better; default: never",
     {.least = 1, .greatest = max_count, .in = none, .out = memory}},
    {"updates", Holds::id, "input whose memory it takes over, with kind, format and extent",
     {.in = none, .out = memory}},
    {"first", Holds::word, "what a reader of @-1 sees on the first frame; default: any",
     {.words = "any clear", .in = none, .out = memory}},
    {"previous", Holds::flag, "must be bound to NAME@-1", {.in = memory, .out = none}},
    {"indirect", Holds::flag, "holds dispatch arguments", {.in = buffer, .out = buffer}},
    {"row", Holds::whole, "of how many texels each row is that a host brings; default: any",
     {.least = 1, .greatest = max_factor, .in = texels, .out = none}},
    {"range", Holds::ranges, "what its numbers keep to; null: no end. Integers have none",
     {.in = none, .out = memory}},
    {"optional", Holds::flag, "may be unbound; GLSL gets HAS_PORT, a constant for inputs, a macro for outputs", {.in = memory | block, .out = memory}},
    {"with", Holds::ids, "optional, but not beside these inputs of the type where one of them is bound",
     {.min_items = 1, .in = memory | block, .out = none, .beside = "optional"}},
    {"if", Holds::condition, "the port exists only where this holds; GLSL gets HAS_PORT",
     {.in = memory | block, .out = memory}},
    {"doc", Holds::line, "what it holds", {.out = memory}},
});

constexpr auto extent_keys = std::to_array<Key>({
    {"of", Holds::id, "\"frame\" or a port", {.required = true}},
    {"div", Holds::wholes, "default: [1, 1]",
     {.least = 1, .greatest = max_factor, .min_items = 2, .max_items = 2}},
    {"mul", Holds::wholes, "default: [1, 1]",
     {.least = 1, .greatest = max_factor, .min_items = 2, .max_items = 2}},
});

constexpr auto count_keys = std::to_array<Key>({
    {"of", Holds::id, "\"frame\" or a port", {.required = true}},
    {"div", Holds::wholes, "default: [1, 1]",
     {.least = 1, .greatest = max_factor, .min_items = 2, .max_items = 2}},
    {"mul", Holds::whole, "default: 1", {.least = 1, .greatest = max_factor}},
    {"add", Holds::whole, "default: 0", {.least = 0, .greatest = max_count}},
});

constexpr auto table_keys = std::to_array<Key>({
    {"file", Holds::file, "relative to the declaration", {.required = true}},
    {"format", Holds::storable, "of its texels", {.required = true}},
    {"extent", Holds::wholes, "in texels",
     {.required = true, .least = 1, .greatest = 16384, .min_items = 2, .max_items = 2}},
    {"as", Holds::word, "how the shader sees it; default: sampled", {.words = "sampled storage"}},
    {"if", Holds::condition, "the table exists only where this holds; GLSL gets HAS_TABLE"},
});

constexpr auto param_keys = std::to_array<Key>({
    {"type", Holds::word, "of its values",
     {.required = true, .words = "bool int uint float vec2 vec3 vec4 enum"}},
    {"default", Holds::value, "where a pipeline sets none", {.required = true}},
    {"doc", Holds::line, "what it does", {.required = true}},
    {"unit", Holds::line, "of its values"},
    {"range", Holds::range, "of every component, ends included",
     {.in = every_kind & ~(truth | chosen | unknown_kind)}},
    {"values", Holds::ids, "that it may have", {.required = true, .min_items = 1, .in = chosen}},
    {"constant", Holds::flag,
     "a specialisation constant, part of the plan; otherwise it may change per frame",
     {.in = every_kind & ~(vectors | unknown_kind)}},
});

constexpr Key group("group", Holds::wholes, "threads of a workgroup, 1024 at most; default: [8, 8]",
                    {.least = 1, .greatest = max_group_threads, .min_items = 2, .max_items = 3});
constexpr Key per_thread("per_thread", Holds::wholes, "texels of each thread; default: [1, 1]",
                         {.least = 1, .greatest = 1024, .min_items = 2, .max_items = 2});

constexpr Key beside_over(Key key) {
    key.beside = "over";
    return key;
}

constexpr auto dispatch_keys = std::to_array<Key>({
    {"over", Holds::id, "\"frame\" or a port that has an extent: its texels"},
    {"indirect", Holds::id, "an input with `indirect`, whose numbers are the workgroups"},
    {"groups", Holds::wholes, "so many workgroups",
     {.least = 1, .greatest = 65535, .min_items = 3, .max_items = 3}},
    {"offset", Holds::whole, "of the arguments, in bytes",
     {.least = 0, .greatest = 1u << 16, .multiple = 4, .beside = "indirect"}},
    group,
    beside_over(per_thread),
});

constexpr auto classes_keys = std::to_array<Key>({
    {"cpu", Holds::object, "on CPU devices", {.object = &device_class}},
    {"gpu", Holds::object, "on all others", {.object = &device_class}},
    {"compiled", Holds::flag, "the shader is compiled for each class, and CLASS_CPU is 1 or 0 to its preprocessor; default: once for both"},
});

constexpr auto device_class_keys = std::to_array<Key>({group, per_thread});

constexpr auto pipeline_keys = std::to_array<Key>({
    {"$schema", Holds::text, "pipelines/pipeline.schema.json as seen from the file, for editors"},
    {"penumbra", Holds::version, "version of the format", {.required = true}},
    {"name", Holds::id, "of the pipeline", {.required = true}},
    {"doc", Holds::line, "what it is for"},
    {"extends", Holds::file, "a file that this one patches (RFC 7396)"},
    {"inputs", Holds::objects, "what the host hands over each frame", {.object = &input}},
    {"outputs", Holds::ids, "what the host gets", {.required = true, .min_items = 1}},
    {"nodes", Holds::objects, "in any order: the dataflow decides",
     {.required = true, .object = &node, .min_items = 1}},
    {"instances", Holds::objects, "of what there are several: inputs and nodes of a family exist for each of its members, "
     "as NAME_INSTANCE, and so does what these nodes write", {.object = &instance}},
    {"resources", Holds::objects, "settings of what nodes write", {.object = &resource}},
});

constexpr auto instance_keys = std::to_array<Key>({
    {"of", Holds::id, "the family", {.required = true}},
    {"facts", Holds::facts, "what its nodes take for granted, whatever holds for the others"},
});

constexpr auto input_keys = std::to_array<Key>({
    {"kind", Holds::kind, "default: what the readers take"},
    {"format", Holds::format, "default: what the host brings and the readers take", {.in = image | texels}},
    {"extent", Holds::wholes, "default: frame", {.words = "frame any", .least = 1, .greatest = 1u << 16,
     .min_items = 2, .max_items = 2, .in = image | texels}},
    {"history", Holds::word, "the host also brings the value for @-1", {.words = "host"}},
    {"optional", Holds::flag, "the host may leave it out"},
    {"instances", Holds::id, "a family: there is one for each of its members"},
});

constexpr auto node_keys = std::to_array<Key>({
    {"type", Holds::node_type, "a declaration's", {.required = true}},
    {"in", Holds::wires, "port: the resource that it reads, or its value @-1; @before, @last: another member's; null: unbound"},
    {"out", Holds::wires, "port: the name of what it writes; null: unbound"},
    {"params", Holds::values, "parameter: value"},
    {"if", Holds::condition, "the node runs only where this holds"},
    {"with", Holds::id, "an optional input of the pipeline: where the host leaves it out, so is the node"},
    {"doc", Holds::line, "why it is there"},
    {"instances", Holds::id, "a family: there is one for each of its members"},
});

constexpr auto resource_keys = std::to_array<Key>({
    {"format", Holds::format, "one of those that its writer offers"},
    {"first", Holds::word, "what a reader of @-1 sees on the first frame", {.words = "any clear"}},
});
}  // namespace

constexpr Object declaration = {"declaration", "NAME.json, in a folder of nodes. It writes an output, or its shader counts.",
                                declaration_keys, "shader host"};
constexpr Object port = {"port", "A member of `inputs` or `outputs`.", port_keys, "", "kind"};
constexpr Object extent = {"extent", "ceil(of / div) * mul on both axes, at least 1.", extent_keys};
constexpr Object count = {"count", "ceil(x / div[0]) * ceil(y / div[1]) * mul + add.", count_keys};
constexpr Object table = {"table", "A member of `tables`.", table_keys};
constexpr Object param = {"param", "A member of `params`.", param_keys, "", "type"};
constexpr Object dispatch = {"dispatch", "What a shader runs over.", dispatch_keys, "over indirect groups"};
constexpr Object classes = {"classes", "CPU devices, or all others.", classes_keys};
constexpr Object device_class = {
    "class", "Also constant parameters, with other values than their default. No image may change by it beyond "
    "rounding.", device_class_keys};
constexpr Object pipeline = {"pipeline", "pipelines/NAME.json.", pipeline_keys};
constexpr Object input = {"input", "A member of a pipeline's `inputs`.", input_keys, "", "kind"};
constexpr Object node = {"node", "A member of `nodes`.", node_keys};
constexpr Object instance = {"instance", "A member of `instances`.", instance_keys};
constexpr Object resource = {"resource", "A member of `resources`.", resource_keys};
// clang-format on

std::span<const Object* const> objects() {
    static constexpr const Object* all[] = {&declaration, &port,     &extent,   &count,        &table,
                                            &param,       &dispatch, &classes,  &device_class, &pipeline,
                                            &input,       &node,     &instance, &resource};
    return all;
}

}  // namespace vocabulary

const Key* Object::find(std::string_view key, const Scope& scope) const {
    const auto found =
        std::ranges::find_if(keys, [&](const Key& k) { return k.name == key && scope.has(k); });
    return found == keys.end() ? nullptr : &*found;
}

const Key& Object::at(std::string_view key) const {
    return *std::ranges::find(keys, key, &Key::name);
}

bool Object::knows(std::string_view key) const {
    return std::ranges::find(keys, key, &Key::name) != keys.end();
}

std::vector<std::string> Object::names() const {
    std::vector<std::string> names;
    for (const Key& key : keys)
        if (names.empty() || names.back() != key.name) names.emplace_back(key.name);
    return names;
}

std::vector<std::string> split_words(std::string_view words) {
    std::vector<std::string> list;
    while (!words.empty()) {
        const size_t end = std::min(words.find(' '), words.size());
        list.emplace_back(words.substr(0, end));
        words.remove_prefix(std::min(end + 1, words.size()));
    }
    return list;
}

const char* kind_name(PortKind kind) {
    constexpr const char* names[] = {"image", "texels", "buffer",
                                     "block", "bundle", "acceleration structure"};
    return names[static_cast<size_t>(kind)];
}

std::vector<std::string> kind_words(const Domain& domain) {
    std::vector<std::string> words;
    for (const PortKind kind : {PortKind::image, PortKind::texels, PortKind::buffer, PortKind::block})
        words.emplace_back(kind_name(kind));
    for (const Bundle& bundle : domain.bundles) words.push_back(bundle.kind);
    return words;
}

std::vector<std::string> need_words(const Domain& domain) {
    std::vector<std::string> words = domain.features;
    words.emplace_back("jitter");
    words.emplace_back("camera");
    return words;
}

std::vector<std::string> param_type_words() {
    return split_words(vocabulary::param.at("type").words);
}

}  // namespace penumbra
