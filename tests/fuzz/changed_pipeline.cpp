// SPDX-License-Identifier: MIT
#include "tests/fuzz/changed_pipeline.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace penumbra::test {
namespace {

using Json = nlohmann::ordered_json;

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
    explicit Mutator(std::span<const std::byte> bytes) : bytes_(bytes) {}

    std::string run(size_t most) {
        static const std::vector<Json> bases = shipped();
        Json json = bases[below(bases.size())];
        for (size_t changes = 1 + below(most); changes > 0; --changes) change(json);
        return json.dump();
    }

  private:
    size_t below(size_t bound) {
        size_t value = 0;
        for (int i = 0; i < 2; ++i)
            if (next_ < bytes_.size()) value = value << 8 | std::to_integer<size_t>(bytes_[next_++]);
        return value % bound;
    }

    // Texts by what they belong to ("in", "out", "outputs", "if", "type", ...): those of one kind stand for
    // each other.
    using Texts = std::map<std::string, std::vector<Json*>>;
    static void collect(Json& json, const std::string& kind, std::vector<Json*>& containers, Texts& texts) {
        if (json.is_string()) texts[kind].push_back(&json);
        if (!json.is_structured() || json.empty()) return;
        containers.push_back(&json);
        const bool named = json.is_object() && kind != "in" && kind != "out";
        for (const auto& [key, child] : json.items()) collect(child, named ? key : kind, containers, texts);
    }

    void change(Json& json) {
        std::vector<Json*> containers;
        Texts kinds;
        collect(json, "", containers, kinds);
        Json& in = *containers[below(containers.size())];
        const auto at = std::next(in.begin(), static_cast<std::ptrdiff_t>(below(in.size())));
        const auto& texts =
            std::next(kinds.begin(), static_cast<std::ptrdiff_t>(below(kinds.size())))->second;
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
                if (json["outputs"].is_array() && !kinds["in"].empty())
                    json["outputs"].push_back(*kinds["in"][below(kinds["in"].size())]);
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

    std::span<const std::byte> bytes_;
    size_t next_ = 0;
};

}  // namespace

std::string changed_pipeline(std::span<const std::byte> bytes, size_t most) {
    return Mutator(bytes).run(most);
}

}  // namespace penumbra::test
