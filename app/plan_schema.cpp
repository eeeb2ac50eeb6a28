// SPDX-License-Identifier: MIT
#include "app/plan_schema.h"

#include <nlohmann/json.hpp>

#include "app/plan_json.h"
#include "graph/vocabulary.h"
#include "penumbra/format.h"

namespace penumbra {
namespace {

using Schema = nlohmann::ordered_json;

Schema use(const char* definition) {
    return {{"$ref", std::string("#/definitions/") + definition}};
}
Schema words(const std::vector<std::string>& list) {
    return {{"enum", list}};
}
Schema list_of(Schema item) {
    return {{"type", "array"}, {"items", std::move(item)}};
}
Schema list_of(Schema item, size_t count) {
    return {{"type", "array"}, {"items", std::move(item)}, {"minItems", count}, {"maxItems", count}};
}
Schema or_null(Schema schema) {
    return {{"anyOf", Schema::array({std::move(schema), Schema{{"type", "null"}}})}};
}
Schema doc(Schema schema, const char* text) {
    if (schema.contains("$ref"))
        schema = {{"allOf", Schema::array({schema})}};  // a $ref hides what is beside it
    schema["description"] = text;
    return schema;
}
// All of the members, and no others.
Schema object(std::initializer_list<std::pair<const char*, Schema>> members) {
    Schema properties = Schema::object(), required = Schema::array();
    for (const auto& [key, schema] : members) {
        properties[key] = schema;
        required.push_back(key);
    }
    return {{"type", "object"},
            {"properties", properties},
            {"required", required},
            {"additionalProperties", false}};
}

const Schema text = {{"type", "string"}}, flag = {{"type", "boolean"}},
             number = {{"type", "integer"}, {"minimum", 0}},
             word32 = {{"type", "integer"}, {"minimum", 0}, {"maximum", 4294967295}};

Schema definitions() {
    Schema d = Schema::object();
    d["format"] = {{"enum", format_names()}};
    d["size"] = list_of(Schema{{"type", "integer"}, {"minimum", 1}}, 2);
    d["groups"] = list_of(number, 3);
    d["follows"] =
        doc(or_null(list_of(list_of(number, 4))),
            "how its size follows the frame's: through [div x, div y, mul x, mul y], one after another, each "
            "max(ceil(size / div) * mul, 1); null: it does not");
    d["kind"] = words({"image", "texels", "buffer", "block", "structure"});
    d["stages"] = list_of(words({"compute", "indirect", "transfer", "copy", "top", "all"}));
    d["access"] = list_of(words({"write", "read", "sample", "uniform", "structure", "arguments", "copy_read",
                                 "copy_write", "any_read", "any_write"}));
    d["usage"] = list_of(
        words({"storage", "sampled", "texels", "arguments", "copy_source", "copy_target", "attachment"}));
    d["activation"] = doc(object({{"resource", number},
                                  {"from_stages", use("stages")},
                                  {"from_access", use("access")},
                                  {"to_stages", use("stages")},
                                  {"to_access", use("access")}}),
                          "an image begins to use its memory: from an undefined layout to the general one");
    d["dependency"] =
        doc(object({{"from_stages", use("stages")},
                    {"from_access", use("access")},
                    {"to_stages", use("stages")},
                    {"to_access", use("access")},
                    {"activations", list_of(use("activation"))}}),
            "a barrier over all memory, and activations with it; no stages: the activations alone");
    d["by_parity"] = doc(list_of(use("dependency"), 2), "of frames 0, 2, 4, ... and of frames 1, 3, 5, ...");
    d["binding"] = object(
        {{"set", number},
         {"binding", number},
         {"type", words({"sampled_image", "storage_image", "texel_buffer", "storage_texel_buffer",
                         "uniform_buffer", "storage_buffer", "acceleration_structure"})},
         {"source", doc(words({"resource", "slot", "table", "frame_block", "counters", "nothing"}),
                        "what fills it; nothing: anything of its type and format, which is never read")},
         {"index", or_null(doc(number, "of resources, slots or tables"))},
         {"previous", doc(flag, "the resource's instance of the frame before")},
         {"level",
          doc(words({"finest", "written", "finer"}),
              "of a storage image with mip levels: the first, the dispatch's, or the one before that")},
         {"filter", or_null(words({"nearest", "linear"}))},
         {"array", flag},
         {"format", or_null(use("format"))},
         {"port", or_null(text)}});
    return d;
}

Schema slot() {
    return object({{"name", text},
                   {"input", or_null(doc(text, "of the pipeline; null: an image of the host for an output"))},
                   {"kind", use("kind")},
                   {"previous", doc(flag, "the value of the last recorded frame")},
                   {"output", flag},
                   {"required", doc(flag, "false: a plan can be made without it")},
                   {"format", or_null(use("format"))},
                   {"accepted", doc(list_of(use("format")), "a plan can be made for any of them")},
                   {"size", or_null(doc(use("size"), "of the largest frame"))},
                   {"follows", use("follows")},
                   {"array", flag},
                   {"layers", or_null(number)},
                   {"element", or_null(text)},
                   {"bytes", or_null(number)},
                   {"layout", or_null(doc(words({"read_only", "general"}),
                                          "while the frame uses it: SHADER_READ_ONLY_OPTIMAL or GENERAL"))},
                   {"stages", use("stages")},
                   {"access", use("access")},
                   {"nodes", list_of(text)}});
}

Schema resource() {
    return object(
        {{"names", list_of(text)},
         {"kind", use("kind")},
         {"format", or_null(use("format"))},
         {"size", or_null(doc(use("size"), "of the largest frame"))},
         {"follows", use("follows")},
         {"array", flag},
         {"layers", number},
         {"levels", number},
         {"element", or_null(text)},
         {"buffer_bytes", or_null(doc(number, "of the buffer, be it the one of an image's memory"))},
         {"row_bytes", or_null(doc(number,
                                   "from row to row of an image in linear tiling, whose memory a "
                                   "storage buffer has, too: bindings of that type mean it"))},
         {"usage", use("usage")},
         {"history", flag},
         {"kept", doc(flag, "one instance for all frames, not one for each parity")},
         {"output", flag},
         {"slot", or_null(doc(number, "the host's image, in no heap"))},
         {"first_pass", number},
         {"last_pass", doc(number, "of this frame or, of history, the next")},
         {"length", doc(number, "in passes, from the first one on, into the next frame where it is history")},
         {"heap", or_null(number)},
         {"memory_bytes", number},
         {"alignment", number},
         {"offset", doc(list_of(number, 2), "in the heap, by the frame's parity")}});
}

Schema pass() {
    return object(
        {{"node", text},
         {"type", text},
         {"groups", doc(Schema{{"anyOf", Schema::array({use("groups"), words({"indirect"}),
                                                        Schema{{"type", "null"}}})}},
                        "to dispatch")},
         {"backend", or_null(text)},
         {"reads", list_of(text)},
         {"writes", list_of(text)},
         {"kind", words({"compute", "host", "capture"})},
         {"module", or_null(number)},
         {"entry", or_null(text)},
         {"workgroup", or_null(use("groups"))},
         {"constants",
          doc(list_of(word32),
              "specialisation constants 0, 1, 2, ..., as bits: three of the workgroup, two of pixels per "
              "thread, whether the device is a processor, lanes in step, then the node's own")},
         {"push", doc(list_of(word32), "push constants, as bits, with the parameters' first values")},
         {"params", list_of(object({{"name", text},
                                    {"type", words(param_type_words())},
                                    {"offset", doc(number, "bytes in the push constants")}}))},
         {"mip_level", or_null(doc(number, "offset in the push constants: the level of the dispatch"))},
         {"level_groups", doc(list_of(use("groups")), "one dispatch for each, or none: `groups`")},
         {"follows", doc(use("follows"), "what the dispatch is over")},
         {"group_pixels", or_null(doc(list_of(number, 2), "that a group covers of it"))},
         {"indirect", or_null(object({{"resource", number}, {"offset", number}}))},
         {"bindings", list_of(use("binding"))},
         {"resource", or_null(doc(number, "that a capture copies out"))},
         {"before", use("by_parity")},
         {"clears", doc(list_of(number), "resources that become 0, behind `before`")},
         {"after_clears", use("by_parity")},
         {"member", doc(or_null(number), "of `members`: whose pass it is")},
         {"rests", doc(flag, "is left out while its member is asleep")},
         {"zero_at_rest",
          doc(list_of(number), "resources that become 0 in its place, behind `after_clears`")},
         {"counters", list_of(text)},
         {"counter_base", number}});
}

}  // namespace

nlohmann::ordered_json plan_schema() {
    const Schema requirement =
        object({{"kind", words({"version", "extension", "feature", "subgroup", "limit", "format"})},
                {"name", text},
                {"value", number},
                {"why", text}});
    const Schema member = object({{"name", text}, {"type", text}, {"offset", number}});
    Schema schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                     {"title", "A plan of penumbra"},
                     {"definitions", definitions()}};
    schema.update(object(
        {{"penumbra_plan", Schema{{"const", plan_json_version}}},
         {"pipeline", text},
         {"size", use("size")},
         {"device", text},
         {"facts", Schema{{"type", "object"}, {"additionalProperties", flag}}},
         {"jitter", flag},
         {"camera", flag},
         {"settles",
          doc(or_null(number), "frames that are alike, after which no output gets better; null: never")},
         {"requirements", list_of(requirement)},
         {"frame_block", object({{"bytes", number}, {"members", list_of(member)}})},
         {"slots", list_of(slot())},
         {"modules", doc(list_of(text), "files of SPIR-V beside this one")},
         {"tables", list_of(object({{"name", text},
                                    {"format", use("format")},
                                    {"size", use("size")},
                                    {"storage", doc(flag, "as a storage image, else as a sampled one")},
                                    {"file", doc(text, "its texels, beside this file")}}))},
         {"heaps", list_of(object({{"kind", words({"images", "buffers"})},
                                   {"bytes", number},
                                   {"alignment", number},
                                   {"memory_type_bits", word32},
                                   {"shared", flag}}))},
         {"resources", list_of(resource())},
         {"reset",
          doc(list_of(object({{"resource", number}, {"clear", flag}})),
              "on a frame without history, before the first pass: the other parity's instance, and what is "
              "kept, is activated, and cleared where it says so")},
         {"members", doc(list_of(text), "of families of instances that have nodes")},
         {"passes", list_of(pass())},
         {"end", doc(use("by_parity"), "behind the last pass: the outputs become visible")},
         {"outputs",
          list_of(object(
              {{"name", text}, {"resource", number}, {"stages", use("stages")}, {"access", use("access")}}))},
         {"counters", doc(list_of(text), "of the counter buffer, 32 bits each, 0 when the frame begins")},
         {"culled", list_of(object({{"node", text}, {"why", text}, {"cond", or_null(text)}}))},
         {"memory", Schema{{"type", "object"}}}}));
    return schema;
}

}  // namespace penumbra
