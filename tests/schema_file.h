// SPDX-License-Identifier: MIT
// A JSON Schema as valijson reads it, so that neither the schema nor the loader judges itself, and the files
// that are held to one.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>
#include <vector>

#include "app/schema.h"
#include "tests/project_files.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {

using nlohmann::json;

class SchemaFile {
  public:
    explicit SchemaFile(const json& document) {
        valijson::SchemaParser parser;
        parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(document), schema_);
    }

    // "" where it validates, else the errors. Text that is no JSON does not validate: editors say so without
    // a schema.
    std::string errors(const std::string& text) const {
        const json document = json::parse(text, nullptr, false);
        return document.is_discarded() ? "no JSON\n" : errors(document);
    }
    std::string errors(const json& document) const {
        valijson::Validator validator(valijson::Validator::kStrongTypes);
        valijson::ValidationResults results;
        if (validator.validate(schema_, valijson::adapters::NlohmannJsonAdapter(document), &results))
            return "";
        std::string text;
        for (valijson::ValidationResults::Error error; results.popError(error);) {
            for (const std::string& part : error.context) text += part;
            text += ": " + error.description + "\n";
        }
        return text.empty() ? "invalid\n" : text;
    }

  private:
    valijson::Schema schema_;
};

inline json to_plain(const nlohmann::ordered_json& document) {
    return json::parse(document.dump());
}

inline const SchemaFile& node_schema() {
    static const SchemaFile schema(json::parse(read(root / "nodes/node.schema.json")));
    return schema;
}
inline const SchemaFile& shot_schema() {
    static const SchemaFile schema(json::parse(read(root / "scenes/shot.schema.json")));
    return schema;
}
inline const SchemaFile& shipped_schema() {
    static const SchemaFile schema(json::parse(read(root / "pipelines/pipeline.schema.json")));
    return schema;
}
// The toy nodes have ports and parameters of every kind.
inline const SchemaFile& toy_schema() {
    static const SchemaFile schema(to_plain(pipeline_schema(toy_nodes())));
    return schema;
}

inline bool is_schema(const fs::path& file) {
    return file.filename().string().ends_with(".schema.json");
}

inline std::vector<fs::path> files_in(const fs::path& folder, const std::string& suffix,
                                      const std::string& prefix = "") {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with(prefix) && name.ends_with(suffix) && !is_schema(name))
            files.push_back(entry.path());
    }
    std::ranges::sort(files);
    EXPECT_FALSE(files.empty()) << folder;
    return files;
}

// Every place in a document.
inline std::vector<json::json_pointer> places(const json& document) {
    std::vector<json::json_pointer> list;
    const json flat = document.flatten();
    for (const auto& [pointer, value] : flat.items())
        for (json::json_pointer at(pointer); !at.empty(); at = at.parent_pointer())
            if (std::ranges::find(list, at) == list.end()) list.push_back(at);
    return list;
}

}  // namespace penumbra::test
