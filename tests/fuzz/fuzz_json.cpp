// SPDX-License-Identifier: MIT
// Pipelines and declarations; and pipelines that ship, changed by what is in them already: most of such
// changes get past the reader, as noise never does.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/fuzz/targets.h"
#include "tests/plan_checks.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::ordered_json;

const NodeSet& nodes() {
    static const NodeSet set = shadow_nodes();
    return set;
}

std::string_view text_of(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void promise(bool kept, const std::string& broken) {
    if (!kept) throw std::logic_error(broken);
}

// Every phase either succeeds or says why not, and a plan is sound.
void run_pipeline(std::string_view text) {
    Diagnostics diagnostics;
    const auto pipeline = parse_pipeline(text, "p.json", {}, diagnostics);
    promise(pipeline.has_value() == diagnostics.empty(), "the reader: " + diagnostics.text());
    if (!pipeline) return;
    const auto checked = check(*pipeline, nodes(), diagnostics);
    promise(checked.has_value() == diagnostics.empty(), "check: " + diagnostics.text());
    if (!checked) return;
    Target target;
    target.extent = {64, 36};
    target.device = reference_device();
    const auto plan = compile(*checked, target, {}, diagnostics);
    promise(plan.has_value() == diagnostics.empty(), "compile: " + diagnostics.text());
    if (!plan || plan->passes.size() > 40) return;  // the checks below are quadratic, and plain
    for (const auto& errors : {overlap_errors(*plan), hazard_errors(*plan, 1)})
        promise(errors.empty(), "the plan: " + (errors.empty() ? "" : errors.front()));
}

std::vector<Json> shipped() {
    std::vector<Json> all;
    for (const auto& entry : std::filesystem::directory_iterator(PENUMBRA_SOURCE_DIR "/pipelines")) {
        std::ifstream stream(entry.path());
        Json json = Json::parse(stream, nullptr, false);
        if (json.is_object() && json.contains("nodes") && !json.contains("extends"))
            all.push_back(std::move(json));
    }
    std::sort(all.begin(), all.end(), [](const Json& a, const Json& b) { return a.dump() < b.dump(); });
    if (all.empty()) throw std::runtime_error("no shipped pipelines to change");
    return all;
}

class Mutator {
  public:
    explicit Mutator(Bytes bytes) : bytes_(bytes) {}

    std::string run() {
        static const std::vector<Json> bases = shipped();
        Json json = bases[below(bases.size())];
        for (size_t changes = 1 + below(6); changes > 0; --changes) change(json);
        return json.dump();
    }

  private:
    size_t below(size_t bound) {
        size_t value = 0;
        for (int i = 0; i < 2; ++i)
            if (next_ < bytes_.size()) value = value << 8 | std::to_integer<size_t>(bytes_[next_++]);
        return value % bound;
    }

    static void collect(Json& json, std::vector<Json*>& containers, std::vector<Json*>& texts) {
        if (json.is_string()) texts.push_back(&json);
        if (!json.is_structured() || json.empty()) return;
        containers.push_back(&json);
        for (Json& child : json) collect(child, containers, texts);
    }

    void change(Json& json) {
        std::vector<Json*> containers, texts;
        collect(json, containers, texts);
        Json& in = *containers[below(containers.size())];
        const auto at = std::next(in.begin(), static_cast<std::ptrdiff_t>(below(in.size())));
        std::string& text = texts[below(texts.size())]->get_ref<std::string&>();
        const std::string other = texts[below(texts.size())]->get<std::string>();
        switch (below(9)) {
            case 0:
                in.erase(at);
                break;
            case 1:
                *at = nullptr;
                break;
            case 2:
                text = other;
                break;
            case 3:
                text = text.ends_with("@-1") ? text.substr(0, text.size() - 3) : text + "@-1";
                break;
            case 4:
                add_to(in, *at);
                break;
            case 5: {
                constexpr double numbers[] = {0, 1, -1, 2, 0.5, 7, 64, 1e9, 1e300};
                *at = numbers[below(std::size(numbers))];
                break;
            }
            case 6:
                std::swap(*at, *in.begin());
                break;
            case 7:
                if (json["outputs"].is_array()) json["outputs"].push_back(other);
                break;
            default: {
                constexpr const char* conditions[] = {"moves", "!moves", "alpha & moves", "moves | !alpha",
                                                      "soft"};
                Json& all = json["nodes"];
                if (!all.is_object() || all.empty()) break;
                Json& node = *std::next(all.begin(), static_cast<std::ptrdiff_t>(below(all.size())));
                if (node.is_object()) node["if"] = conditions[below(std::size(conditions))];
            }
        }
    }

    void add_to(Json& in, const Json& value) {
        if (in.is_array())
            in.push_back(value);
        else
            in["more" + std::to_string(below(3))] = value;
    }

    Bytes bytes_;
    size_t next_ = 0;
};

}  // namespace

void fuzz_pipeline(Bytes bytes) {
    run_pipeline(text_of(bytes));
}

void fuzz_mutant(Bytes bytes) {
    run_pipeline(Mutator(bytes).run());
}

void fuzz_declaration(Bytes bytes) {
    Diagnostics diagnostics;
    const auto json = parse_json(text_of(bytes), "n.json", diagnostics);
    promise(json.has_value() == diagnostics.empty(), "the reader: " + diagnostics.text());
    if (!json) return;
    const auto type = parse_node_type(*json, "n", nodes().domain(), diagnostics);
    promise(type.has_value() == diagnostics.empty(), "the declaration: " + diagnostics.text());
}

}  // namespace penumbra::test
