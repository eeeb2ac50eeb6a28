// SPDX-License-Identifier: MIT
// The JSON Schemas against the loader. Two sides: what the loader accepts, a schema accepts (an editor never
// cries wolf), and what is wrong with a value by itself, a schema finds. The validator is valijson's, so that
// neither side judges itself.
#include "app/schema.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "app/plan_json.h"
#include "app/plan_schema.h"
#include "app/reference_pages.h"
#include "app/vocabulary_page.h"
#include "graph/vocabulary.h"
#include "host/shots/shot.h"
#include "penumbra/compile.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/golden_text.h"
#include "tests/toy_nodes.h"
#include "tests/toy_set.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path root = PENUMBRA_SOURCE_DIR;

std::string read(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    EXPECT_TRUE(stream) << path;
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

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

json to_plain(const nlohmann::ordered_json& document) {
    return json::parse(document.dump());
}

const SchemaFile& node_schema() {
    static const SchemaFile schema(json::parse(read(root / "nodes/node.schema.json")));
    return schema;
}
const SchemaFile& shot_schema() {
    static const SchemaFile schema(json::parse(read(root / "scenes/shot.schema.json")));
    return schema;
}
const SchemaFile& shipped_schema() {
    static const SchemaFile schema(json::parse(read(root / "pipelines/pipeline.schema.json")));
    return schema;
}
// The toy nodes have ports and parameters of every kind.
const SchemaFile& toy_schema() {
    static const SchemaFile schema(to_plain(pipeline_schema(test::toy_nodes())));
    return schema;
}

bool is_schema(const fs::path& file) {
    return file.filename().string().ends_with(".schema.json");
}

std::vector<fs::path> files_in(const fs::path& folder, const std::string& suffix,
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

TEST(Schema, CommittedPipelineSchemaIsTheDeclarations) {
    // Not only the test writes it: penumbra nodes --format schema > pipelines/pipeline.schema.json
    test::expect_golden(schema_text(pipeline_schema(shadow_nodes())),
                        root / "pipelines/pipeline.schema.json");
}

TEST(Schema, CommittedNodeSchemaIsTheVocabulary) {
    // penumbra nodes --format node-schema > nodes/node.schema.json
    test::expect_golden(schema_text(declaration_schema(*shadow_domain())), root / "nodes/node.schema.json");
}

TEST(Schema, CommittedPlanSchemaIsTheExecutors) {
    // penumbra nodes --format plan-schema > pipelines/plan.schema.json
    test::expect_golden(schema_text(plan_schema()), root / "pipelines/plan.schema.json");
}

// Every shipped plan is what the schema says, and no key of it may be missing or be another kind of thing.
TEST(Schema, PlansAreWhatTheirSchemaSays) {
    const SchemaFile schema(to_plain(plan_schema()));
    const NodeSet nodes = shadow_nodes();
    for (const fs::path& file : files_in("pipelines", ".json")) {
        Diagnostics errors;
        const auto pipeline = load_pipeline(file, {}, errors);
        const auto checked = pipeline ? check(*pipeline, nodes, errors) : std::nullopt;
        ASSERT_TRUE(checked) << errors.text();
        CompileOptions options;
        options.captures = {checked->output_names().front()};
        options.share_transients = true;
        const auto plan =
            compile(*checked, {.extent = {64, 32}, .device = reference_device()}, options, errors);
        ASSERT_TRUE(plan) << errors.text();
        const json whole = to_plain(to_json(*plan));
        EXPECT_EQ(schema.errors(whole), "") << file;
        if (file.stem() != "shadows") continue;
        for (const auto& [key, value] : whole.items()) {
            json broken = whole;
            broken.erase(key);
            EXPECT_NE(schema.errors(broken), "") << "without " << key;
            broken[key] = "rubbish";
            if (!value.is_string()) {
                EXPECT_NE(schema.errors(broken), "") << key;
            }
            if (!value.is_array() || !value[0].is_object()) continue;
            for (const auto& [inner, unused] : value[0].items()) {
                broken = whole;
                broken[key][0].erase(inner);
                EXPECT_NE(schema.errors(broken), "") << "without " << key << "." << inner;
            }
        }
    }
}

TEST(Schema, CommittedPageIsTheVocabulary) {
    // penumbra nodes --format vocabulary > docs/vocabulary.md
    test::expect_golden(vocabulary_page(*shadow_domain()), root / "docs/vocabulary.md");
}

// Every node type and every shipped pipeline has its section, as they are today.
TEST(Schema, CommittedPagesAreTheDeclarationsAndPipelines) {
    const NodeSet nodes = shadow_nodes();
    test::expect_golden(nodes_page(nodes), root / "docs/nodes.md");
    std::vector<CheckedPipeline> pipelines;
    for (const std::string& name : test::names_in("pipelines", ".json")) {
        if (name.ends_with(".schema")) continue;
        Diagnostics diagnostics;
        const auto pipeline = load_pipeline(root / "pipelines" / (name + ".json"), {}, diagnostics);
        auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
        ASSERT_TRUE(checked) << diagnostics.text();
        pipelines.push_back(std::move(*checked));
    }
    test::expect_golden(pipelines_page(pipelines), root / "docs/pipeline_list.md");
    // A bar within a cell would end it.
    std::istringstream lines(nodes_page(nodes) + pipelines_page(pipelines));
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("|")) continue;
        size_t bars = 0;
        for (size_t i = 0; i < line.size(); ++i) bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
        EXPECT_EQ(bars, 5u) << line;
    }
}

TEST(Schema, ShippedFilesValidate) {
    for (const fs::path& file : files_in("pipelines", ".json"))
        EXPECT_EQ(shipped_schema().errors(read(file)), "") << file;
    for (const fs::path& file : files_in("nodes", ".json"))
        EXPECT_EQ(node_schema().errors(read(file)), "") << file;
    for (const char* folder : {"scenes", "scenes/tuning"})
        for (const fs::path& file : files_in(folder, ".shot.json"))
            EXPECT_EQ(shot_schema().errors(read(file)), "") << file;
}

TEST(Schema, ExamplesAndToysValidate) {
    for (const fs::path& file : files_in("examples/invert/nodes", ".json"))
        EXPECT_EQ(node_schema().errors(read(file)), "") << file;
    NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    ASSERT_TRUE(add_user_nodes(nodes, root / "examples/invert/nodes", diagnostics)) << diagnostics.text();
    const SchemaFile with_invert(to_plain(pipeline_schema(nodes)));
    EXPECT_EQ(with_invert.errors(read(root / "examples/invert/shadow.json")), "");
    EXPECT_NE(shipped_schema().errors(read(root / "examples/invert/shadow.json")), "")
        << "invert is no shipped node";

    const SchemaFile toys(to_plain(pipeline_schema(test::toy_set())));
    EXPECT_EQ(toys.errors(read(root / "tests/toy/toys.json")), "");
    for (const fs::path& file : files_in("tests/toy", ".json", "toy_"))
        EXPECT_EQ(node_schema().errors(read(file)), "") << file;
    EXPECT_EQ(toy_schema().errors(test::toy_pipeline()), "");
    for (const std::string& name : test::toy_nodes().names())
        EXPECT_EQ(node_schema().errors(test::toy_declaration(name)), "") << name;
}

// An editor follows "$schema" from the file's folder.
TEST(Schema, PathsResolve) {
    int found = 0;
    for (const char* folder : {"pipelines", "nodes", "scenes", "examples"})
        for (const fs::path& file : files_in(folder, ".json")) {
            const json document = json::parse(read(file));
            if (!document.contains("$schema")) continue;
            const fs::path target = file.parent_path() / document["$schema"].get<std::string>();
            EXPECT_TRUE(is_schema(target) && fs::is_regular_file(target)) << file << " names " << target;
            ++found;
        }
    EXPECT_GE(found, 15);
}

// Broken inputs that the schemas let pass, by the reason. Everything else in tests/golden must be rejected.
const std::set<std::string> beyond_schemas = {
    // what a node's port takes or gives, in another place of the file
    "element_mismatch.json",
    "exclusive_writers_differ.json",
    "exclusive_writers_formats.json",
    "format_mismatch.json",
    "format_not_offered.json",
    "host_block_format.json",
    "host_elements_differ.json",
    "host_format_not_accepted.json",
    "host_formats_disjoint.json",
    "host_image_as_storage.json",
    "host_kinds_clash.json",
    "host_layers_differ.json",
    "kind_mismatch.json",
    "layers_mismatch.json",
    "levels_mismatch.json",
    "no_such_struct.json",
    // which names exist, who writes them and when
    "cycle.json",
    "cycle_through_update.json",
    "history_inside_a_chain.json",
    "history_missing_under_facts.json",
    "host_input_optional.json",
    "host_input_written.json",
    "host_without_history.json",
    "missing_under_facts.json",
    "resource_nobody_writes.json",
    "two_writers.json",
    "unknown_names.json",
    "updated_twice.json",
    "with_input.json",
    // literals of one condition that exclude each other, and which parameters it may ask for
    "contradictory_condition.json",
    "decl_conditions.node.json",
    "bad_comparisons.json",
    // the file is good; what it extends is not, or does not fit it
    "extends_bad_values.json",
    "extends_broken_base.json",
    "extends_cycle.json",
    "extends_missing.json",
    "extends_removed_node.json",
    // the file is good; the settings are not
    "settings_bad_paths.json",
    "settings_bad_type.json",
    "settings_bad_values.json",
    // sums over all ports or parameters of a node, and ports that depend on others
    "decl_layers.node.json",
    "decl_push_constants.node.json",
    "decl_too_many_variants.node.json",
    // duplicate keys are the parser's business: no schema sees them
    "duplicate_key.shot.json",
    // geometry, and values of several keys together
    "camera_meets_target.shot.json",
    "analytic_polygon.shot.json",
    "analytic_sphere.shot.json",
    "half_plane_sun.shot.json",
    "cuts_fall.shot.json",
    "keys_fall.shot.json",
    "sun_turns_over.shot.json",
    "up_along_view.shot.json",
};

TEST(Schema, BrokenInputsAreRejected) {
    std::set<std::string> accepted;
    for (const fs::path& file : files_in("tests/golden/broken", ".json")) {
        const std::string name = file.filename().string();
        if (name.ends_with(".part.json")) continue;
        const SchemaFile& schema = name.ends_with(".node.json") ? node_schema() : toy_schema();
        if (schema.errors(read(file)).empty()) accepted.insert(name);
    }
    for (const fs::path& file : files_in("tests/golden/broken_shots", ".shot.json"))
        if (shot_schema().errors(read(file)).empty()) accepted.insert(file.filename().string());
    for (const std::string& name : accepted)
        EXPECT_TRUE(beyond_schemas.contains(name)) << name << " is accepted";
    for (const std::string& name : beyond_schemas)
        EXPECT_TRUE(accepted.contains(name)) << name << " is rejected: delist it";
}

// Every place in a document.
std::vector<json::json_pointer> places(const json& document) {
    std::vector<json::json_pointer> list;
    const json flat = document.flatten();
    for (const auto& [pointer, value] : flat.items())
        for (json::json_pointer at(pointer); !at.empty(); at = at.parent_pointer())
            if (std::ranges::find(list, at) == list.end()) list.push_back(at);
    return list;
}

// A key that no reader asks for would take any value; one that does not apply is refused anyway.
TEST(Schema, EveryKeyOfTheVocabularyIsRead) {
    const json wrong = json::array({{{"x", 3}}});
    const NodeSet nodes = test::toy_nodes();
    int tried = 0;
    const auto try_keys = [&](const json& document, const std::string& place, const Object& object,
                              const auto& loads) {
        const json::json_pointer at(place);
        if (!document.contains(at) || !document[at].is_object()) return;
        for (const Key& key : object.keys) {
            json changed = document;
            changed[at][std::string(key.name)] = wrong;
            EXPECT_FALSE(loads(changed)) << place << "/" << key.name;
            ++tried;
        }
    };
    for (const std::string& name : nodes.names()) {
        const json document = json::parse(test::toy_declaration(name));
        const auto loads = [&](const json& changed) {
            Diagnostics d;
            const auto parsed = parse_json(changed.dump(), "n.json", d);
            return parse_node_type(*parsed, name, test::toy_domain(), d).has_value();
        };
        ASSERT_TRUE(loads(document)) << name;
        try_keys(document, "", vocabulary::declaration, loads);
        try_keys(document, "/dispatch", vocabulary::dispatch, loads);
        try_keys(document, "/classes", vocabulary::classes, loads);
        try_keys(document, "/classes/cpu", vocabulary::device_class, loads);
        try_keys(document, "/tables/noise", vocabulary::table, loads);
        for (const json::json_pointer& place : places(document)) {
            const std::string path = place.to_string(), parent = place.parent_pointer().to_string();
            if (parent == "/inputs" || parent == "/outputs") {
                try_keys(document, path, vocabulary::port, loads);
                try_keys(document, path + "/extent", vocabulary::extent, loads);
                try_keys(document, path + "/count", vocabulary::count, loads);
            }
            if (parent == "/params") try_keys(document, path, vocabulary::param, loads);
        }
    }
    EXPECT_GT(tried, 1000);
    json pipeline = json::parse(test::toy_pipeline());
    pipeline["resources"]["half"] = json::object();
    const auto loads = [&](const json& changed) {
        Diagnostics d;
        const auto parsed = parse_pipeline(changed.dump(), "p.json", {}, d);
        return parsed && check(*parsed, nodes, d);
    };
    ASSERT_TRUE(loads(pipeline));
    try_keys(pipeline, "", vocabulary::pipeline, loads);
    try_keys(pipeline, "/inputs/depth", vocabulary::input, loads);
    try_keys(pipeline, "/nodes/filter0", vocabulary::node, loads);
    try_keys(pipeline, "/resources/half", vocabulary::resource, loads);
}

// --- The loader and the schema side by side
// -------------------------------------------------------------------------

struct Subject {
    const char* name;
    const SchemaFile& schema;
    std::vector<json> documents;
    std::function<bool(const json&)> loads;  // the whole of it
    std::function<bool(const json&)>
        well_formed;  // only what one value can get wrong by itself, as far as phases allow
};

json toy_variant() {
    return json::parse(R"({
      "extends": "toy.json", "doc": null, "resources": { "half": { "format": "r16f", "first": null }, "none": null },
      "nodes": {
        "filter0": { "params": { "step": 3, "sharp": null } },
        "filter2": { "type": "filter", "if": null, "in": { "signal": "visibility" }, "out": { "filtered": "last" },
                     "params": { "strength": 0.5, "gone": null } },
        "taa": null
      },
      "outputs": ["last", "lit"]
    })");
}

class SchemaAndLoader : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) / ("penumbra_schema_" + std::to_string(getpid()));
        fs::create_directories(folder_);
        std::ofstream(folder_ / "toy.json") << test::toy_pipeline();
    }
    void TearDown() override { fs::remove_all(folder_); }

    Subject pipelines() {
        const auto parsed = [this](const json& document, Diagnostics& d) {
            return parse_pipeline(document.dump(), (folder_ / "tried.json").string(), {}, d);
        };
        const auto nodes = std::make_shared<NodeSet>(test::toy_nodes());
        return {"pipeline",
                toy_schema(),
                {json::parse(test::toy_pipeline()), toy_variant()},
                [=](const json& document) {
                    Diagnostics d;
                    const auto pipeline = parsed(document, d);
                    return pipeline && check(*pipeline, *nodes, d) && d.empty();
                },
                [=](const json& document) {
                    Diagnostics d;
                    return parsed(document, d).has_value();
                }};
    }

    static Subject declarations() {
        Subject subject{"node", node_schema(), {}, {}, {}};
        for (const std::string& name : test::toy_nodes().names())
            subject.documents.push_back(json::parse(test::toy_declaration(name)));
        subject.loads = subject.well_formed = [](const json& document) {
            Diagnostics d;
            const auto parsed = parse_json(document.dump(), "n.json", d);
            const bool named =
                document.is_object() && document.contains("node") && document["node"].is_string();
            return parsed && parse_node_type(*parsed, named ? document["node"].get<std::string>() : "",
                                             test::toy_domain(), d)
                                 .has_value();
        };
        return subject;
    }

    Subject shots() {
        Subject subject{"shot", shot_schema(), {}, {}, {}};
        for (const fs::path& file : files_in("scenes", ".shot.json"))
            if (fs::file_size(file) < 2000) subject.documents.push_back(json::parse(read(file)));
        for (
            const char* scene :
            {R"({ "analytic": "half_plane", "penumbra_px": 32, "edge_deg": 20, "speed_px": 0.25, "offset_px": 1 })",
             R"({ "analytic": "slit", "penumbra_px": 32, "width_px": 8 })",
             R"({ "analytic": "fence", "penumbra_px": 32, "period_px": 8, "duty": 0.5 })",
             R"({ "analytic": "polygon", "penumbra_px": 32, "points": [[0, 0], [9, 1], [2, 8]] })",
             R"({ "analytic": "sphere", "penumbra_px": 32, "radius_px": 8 })",
             R"({ "analytic": "contact_point", "radius_px": 8 })",
             R"({ "analytic": "contact_wall", "height": 2, "edge_deg": 10 })",
             R"({ "analytic": "terminator", "penumbra_px": 32 })"}) {
            json document = json::parse(R"({ "penumbra_shot": 1, "frames": 2,
                "sun": { "keys": [{ "frame": 0, "to_sun": [0.3, 0.4, 0.8] }] } })");
            document["scene"] = json::parse(scene);
            subject.documents.push_back(std::move(document));
        }
        subject.loads = subject.well_formed = [this](const json& document) {
            const fs::path file = folder_ / "tried.shot.json";
            std::ofstream(file) << document.dump();
            Diagnostics d;
            return read_shot(file, d).has_value();
        };
        return subject;
    }

    std::vector<Subject> subjects() { return {pipelines(), declarations(), shots()}; }

    fs::path folder_;
};

std::string called(const json& document) {
    for (const char* key : {"name", "node", "scene", "extends"})
        if (document.contains(key)) return document[key].dump();
    return "?";
}

TEST_F(SchemaAndLoader, StartFromGoodDocuments) {
    for (const Subject& subject : subjects())
        for (const json& document : subject.documents) {
            EXPECT_TRUE(subject.loads(document)) << subject.name << document.dump(1);
            EXPECT_EQ(subject.schema.errors(document), "") << subject.name << document.dump(1);
        }
}

// What no schema can tell: null in a patch removes, which may leave too little; a class's keys are the node's
// parameters; a shot without a camera is right where its scene is a model that there is.
bool beyond_one_value(const json& document, const json::json_pointer& place, const json& value) {
    const std::string path = place.to_string();
    return (document.contains("extends") && value.is_null()) || path == "/classes/cpu" ||
           path == "/classes/gpu" || (path == "/scene" && value.is_string() && !document.contains("camera"));
}

// Wrong types and unknown keys at every place. Values of the right type are only tried for the schema's being
// content with what the loader takes: numbers and names can be wrong together (frames that fall), which is
// beyond a schema.
TEST_F(SchemaAndLoader, AgreeOnWrongTypesAndUnknownKeys) {
    const std::vector<json> values = {
        nullptr, true, -1, 2.5, 1e12, "", "Not an id!", json::array(), json::object(), json::array({1, "x"})};
    for (const Subject& subject : subjects()) {
        int rejected = 0;
        for (const json& document : subject.documents) {
            const auto compare = [&](const json& changed, bool structural, const std::string& what) {
                const std::string errors = subject.schema.errors(changed);
                if (subject.loads(changed)) {
                    EXPECT_EQ(errors, "") << subject.name << " " << called(document) << ", " << what;
                }
                if (!structural || subject.well_formed(changed)) return;
                EXPECT_NE(errors, "") << subject.name << " " << called(document) << ", " << what;
                ++rejected;
            };
            for (const json::json_pointer& place : places(document)) {
                if (document[place].is_object()) {
                    json changed = document;
                    changed[place]["unheard_of"] = 1;
                    compare(changed, !beyond_one_value(document, place, 1),
                            "an unknown key in " + place.to_string());
                }
                for (const json& value : values) {
                    json changed = document;
                    changed[place] = value;
                    const bool alike = document[place].type() == value.type() ||
                                       (document[place].is_number() && value.is_number());
                    compare(changed, !alike && !beyond_one_value(document, place, value),
                            place.to_string() + " = " + value.dump());
                }
            }
        }
        EXPECT_GT(rejected, 100) << subject.name;
    }
}

// Members missing, moved, doubled under other names, values swapped and scaled: where the loader is content,
// so is the schema.
TEST_F(SchemaAndLoader, TheSchemaAcceptsWhatTheLoaderAccepts) {
    std::mt19937 random(7);
    for (const Subject& subject : subjects()) {
        int accepted = 0, changes = 0;
        for (const json& document : subject.documents) {
            const auto all = places(document);
            const auto any_place = [&] { return all[random() % all.size()]; };
            for (int round = 0; round < 300; ++round) {
                json changed = document;
                for (int edits = 1 + static_cast<int>(random() % 2); edits > 0; --edits) {
                    const auto at = any_place(), other = any_place();
                    if (!changed.contains(at) || !changed.contains(other)) continue;
                    json& parent = changed[at.parent_pointer()];
                    switch (random() % 4) {
                        case 0:
                            if (parent.is_object()) parent.erase(at.back());
                            break;
                        case 1:
                            changed[at] = json(changed[other]);
                            break;
                        case 2:
                            if (changed[at].is_number_integer())
                                changed[at] = changed[at].get<int64_t>() * 3 - 1;
                            else if (changed[at].is_number())
                                changed[at] = changed[at].get<double>() * -1.5;
                            break;
                        default:
                            if (parent.is_object()) parent["x_" + at.back()] = json(changed[at]);
                            break;
                    }
                }
                ++changes;
                if (!subject.loads(changed)) continue;
                ++accepted;
                EXPECT_EQ(subject.schema.errors(changed), "") << subject.name << changed.dump();
            }
        }
        EXPECT_GT(accepted, changes / 50) << subject.name;
    }
}

}  // namespace
}  // namespace penumbra
