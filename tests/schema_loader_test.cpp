// SPDX-License-Identifier: MIT
// The JSON Schemas against the loader. Two sides: what the loader accepts, a schema accepts (an editor never
// cries wolf), and what is wrong with a value by itself, a schema finds.
#include <functional>
#include <random>

#include "host/shots/shot.h"
#include "tests/schema_file.h"
#include "tests/test_folder.h"
#include "tests/toy_set.h"

namespace penumbra::test {
namespace {

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
    void SetUp() override { std::ofstream(folder_ / "toy.json") << test::toy_pipeline(); }

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

    TestFolder folder_;
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
}  // namespace penumbra::test
