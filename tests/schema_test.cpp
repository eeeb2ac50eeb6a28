// SPDX-License-Identifier: MIT
// The JSON Schemas and the pages that are generated with them: what is committed is what the declarations
// say, what ships validates, and every key of the vocabulary is read.
#include "app/schema.h"

#include <set>
#include <sstream>

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
#include "tests/schema_file.h"
#include "tests/shipped.h"
#include "tests/toy_set.h"

namespace penumbra::test {
namespace {

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
        const auto plan = compile(
            *checked, {.extent = {64, 32}, .inputs = told_inputs(*checked), .device = reference_device()},
            options, errors);
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
            if (!value.is_array() || value.empty() || !value[0].is_object()) continue;
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
    for (const fs::path& file : files_in("scenes", ".shot.json"))
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
    // which names the generated GLSL has already
    "decl_generated_names.node.json",
    "decl_store_names.node.json",
    // sums over all ports or parameters of a node, and ports that depend on others
    "decl_layers.node.json",
    "decl_push_constants.node.json",
    "decl_push_constants_levels.node.json",
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

}  // namespace
}  // namespace penumbra::test
