// SPDX-License-Identifier: MIT
// The program as a shell sees it: exit codes (0 good, 1 the work failed, 2 the command or a file is wrong),
// what goes to which stream, and the documents it prints.
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

std::string render(const std::string& more) {
    return "render pipelines/raw.json --shot scenes/colonnade.shot.json " + more;
}

TEST_F(Cli, CheckPrintsEveryErrorOfAFile) {
    const Result good = run("check pipelines/raw.json pipelines/fidelityfx.json");
    EXPECT_EQ(good.code, 0) << good.err;
    EXPECT_EQ(good.err, "");
    const std::string broken = file("broken.json", R"({
  "penumbra": 1,
  "name": "broken",
  "inputs": { "depth": {}, "normal": {} },
  "outputs": ["view_dpeth"],
  "nodes": {
    "guides": { "type": "guids" },
    "g": { "type": "guides", "in": { "depht": "depth" } }
  }
})");
    const Result bad = run("check pipelines/raw.json " + broken);
    EXPECT_EQ(bad.code, 2);
    EXPECT_EQ(bad.out, "");
    EXPECT_EQ(bad.err, broken +
                           ":7:25: nodes.guides.type: no node type \"guids\"; did you mean \"guides\"?\n" +
                           broken +
                           ":8:38: nodes.g.in.depht: node type \"guides\" has no input \"depht\"; did you "
                           "mean \"depth\"?\n");
    for (const std::string& command :
         {"plan " + broken + " --size 64x64",
          "render " + broken + " --shot scenes/colonnade.shot.json --out " + (folder_ / "o").string()}) {
        expect(run(command), 2, "did you mean \"guides\"?");
        EXPECT_FALSE(fs::exists(folder_ / "o")) << "nothing is made for a command that is wrong";
    }
}

TEST_F(Cli, FilesThatCannotBeReadAreTheCommandsMistake) {
    expect(run("check nosuch.json"), 2, "nosuch.json: no such file");
    expect(run("check " + folder_.string()), 2, "cannot be read");
    expect(run("check"), 2, "pipelines");
    expect(run("render pipelines/raw.json --shot nosuch.shot.json --out " + (folder_ / "o").string()), 2,
           "nosuch.shot.json");
    expect(run("render pipelines/raw.json --out " + (folder_ / "o").string()), 2, "--shot");
    const std::string shot =
        file("s.shot.json", R"({ "penumbra_shot": 1, "scene": "nosuch.glb", "size": [8, 8], "frames": 1,
        "fps": 60, "camera": { "vertical_fov_deg": 60, "near": 0.05, "keys": [ { "frame": 0, "position": [0, 2, 8],
        "target": [0, 1, 0], "up": [0, 1, 0] } ] }, "sun": { "angular_radius_deg": 0.27,
        "keys": [ { "frame": 0, "to_sun": [0, 1, 0] } ] } })");
    expect(run("render pipelines/raw.json --shot " + shot + " --out " + (folder_ / "o").string()), 2,
           "nosuch.glb: no such file\n");

    // The models of the shots that ship are made by a script, which a fresh clone has not run.
    for (const char* folder : {"scenes", "scripts"}) fs::create_directories(folder_ / "clone" / folder);
    file("clone/scripts/scenes.sh", "");
    const std::string shipped = file("clone/scenes/s.shot.json", read_file(shot));
    expect(run("render pipelines/raw.json --shot " + shipped + " --out " + (folder_ / "o").string()), 2,
           "nosuch.glb: no such file; `scripts/scenes.sh release` puts the models");
}

TEST_F(Cli, ArgumentsThatMakeNoSenseAreTheCommandsMistake) {
    expect(run(""), 2, "");
    expect(run("frobnicate"), 2, "");
    for (const char* size : {"0x5", "5", "5x", "x5", "-5x5", "5x5x5", "5 x5k", "99999999999x1", "wxh"})
        expect(run("plan pipelines/raw.json --size '" + std::string(size) + "'"), 2, "is not WIDTHxHEIGHT");
    expect(run("plan pipelines/raw.json --size 100000x8"), 2, "exceeds the device's largest image");
    expect(run("plan pipelines/raw.json --size 8x8 --facts moves,!alhpa"), 2, "did you mean \"alpha\"?");
    for (const char* both : {"'!sun_up,sun_up'", "'sun_up,moves,!sun_up'"})
        expect(run("plan raw --size 8x8 --facts " + std::string(both)), 2, "\"sun_up\" is said to be true");
    EXPECT_EQ(run("plan raw --size 8x8 --facts sun_up,sun_up").code, 0);
    expect(run("plan pipelines/raw.json --size 8x8 --format xml"), 2, "xml");
    expect(run("plan raw --size 8x8 --format json --out " + (folder_ / "o").string()), 2, "--format");
    expect(run("plan pipelines/raw.json --size 8x8 --set nodes.trace"), 2, "expected PATH=VALUE");
    expect(run("nodes filtre"), 2, "did you mean \"filter\"?");
    for (const char* frames : {"5..2", "-1..2", "a..b", "1..", "..1", "1...2", "0..99999999999", "1-2"})
        expect(run(render("--out " + (folder_ / "o").string() + " --frames '" + frames + "'")), 2,
               "is not A..B with A <= B");
    expect(run(render("--out " + (folder_ / "o").string() + " --every 0")), 2, "every");
    expect(run(render("--out " + (folder_ / "o").string() + " --seed x")), 2, "seed");
    expect(run(render("--out " + (folder_ / "o").string() + " --facts '!mvoes'")), 2,
           "did you mean \"moves\"?");
}

TEST_F(Cli, PlanIsTextOrDotOrJsonWithTheKeysOfTheReport) {
    EXPECT_EQ(run("plan pipelines/raw.json --size 64x64").out.substr(0, 14), "plan raw 64x64");
    EXPECT_EQ(run("plan pipelines/raw.json --size 64x64 --format dot").out.substr(0, 13), "digraph raw {");
    const Json plan =
        Json::parse(run("plan pipelines/fidelityfx.json --size 64x64 --facts '!moves' --format json").out);
    EXPECT_EQ(plan["facts"]["moves"], false);
    EXPECT_EQ(plan["facts"]["casters"], true);
    EXPECT_TRUE(plan["culled"].is_array());
    for (const Json& pass : plan["passes"])
        for (const char* key : {"node", "type", "groups", "reads", "writes"})
            EXPECT_TRUE(pass.contains(key)) << key;
    for (const char* key :
         {"heap_bytes", "live_bound_bytes", "optimum_bytes", "unaliased_bytes", "dedicated_history_bytes",
          "persistent_bytes", "bytes_per_pixel", "heaps", "resources"})
        EXPECT_TRUE(plan["memory"].contains(key)) << key;
    const Json apart =
        Json::parse(run("plan pipelines/fidelityfx.json --size 64x64 --no-alias --format json").out);
    EXPECT_GT(apart["memory"]["heap_bytes"], plan["memory"]["heap_bytes"]);

    // With its files, for a device: what docs/embedding.md tells to do.
    const std::string out = (folder_ / "plan").string();
    EXPECT_EQ(run("plan pipelines/shadows.json --size 64x64 --device '' --out " + out).code, 0);
    const Json whole = Json::parse(read_file(folder_ / "plan/plan.json"));
    EXPECT_NE(whole["device"], plan["device"]);
    ASSERT_FALSE(whole["modules"].empty());
    for (const Json& module : whole["modules"])
        EXPECT_GT(read_file(folder_ / "plan" / module.get<std::string>()).size(), 100u);
    for (const Json& table : whole["tables"])
        EXPECT_FALSE(read_file(folder_ / "plan" / table["file"].get<std::string>()).empty());
    expect(run("plan pipelines/shadows.json --size 64x64 --device nosuch"), 2, "nosuch");
    expect(run("plan pipelines/shadows.json --size 64x64 --out /proc/nothing"), 1, "cannot be written");
}

TEST_F(Cli, NodesAreListedDescribedAndMadeASchema) {
    EXPECT_NE(run("nodes").out.find("\ntrace "), std::string::npos);
    EXPECT_EQ(run("nodes trace").out.substr(0, 7), "trace: ");
    EXPECT_EQ(run("nodes filter --format md").out.substr(0, 11), "### filter\n");
    const Result glsl = run("nodes trace --format glsl");
    EXPECT_NE(glsl.out.find("layout(constant_id = "), std::string::npos);
    EXPECT_NE(glsl.out.find("#define HAS_FRACTION 1\n"), std::string::npos) << "with all that it may write";
    EXPECT_EQ(run("nodes --format glsl").code, 2);
    const Json nodes = Json::parse(run("nodes --format json").out);
    for (const Json& node : nodes)
        for (const auto& [name, param] : node["params"].items()) {
            if (param["range"].is_null() || (param["type"] != "uint" && param["type"] != "int")) continue;
            EXPECT_TRUE(param["range"][0].is_number_integer() && param["range"][1].is_number_integer())
                << node["node"] << "." << name << ": " << param["range"];
        }
    const Json schema = Json::parse(run("nodes --format schema").out);
    for (const Json& node : nodes) {
        const std::string name = node["node"];
        ASSERT_TRUE(schema["definitions"].contains("type_" + name));
        const Json& properties = schema["definitions"]["type_" + name]["properties"];
        const auto described = [&](const char* part) {
            return properties.value(part, Json::object())["properties"].size();
        };
        EXPECT_EQ(described("params"), node["params"].size()) << name;
        EXPECT_EQ(described("in"), node["inputs"].size()) << name;
        EXPECT_EQ(described("out"), node["outputs"].size()) << name;
    }
    EXPECT_EQ(run("nodes --format node-schema").out,
              read_file(fs::path(PENUMBRA_SOURCE_DIR) / "nodes/node.schema.json"));
    EXPECT_EQ(run("nodes --format vocabulary").out,
              read_file(fs::path(PENUMBRA_SOURCE_DIR) / "docs/vocabulary.md"));
    EXPECT_EQ(run("nodes trace --format vocabulary").code, 2);
}

TEST_F(Cli, HelpSaysHowManyValuesAnOptionTakes) {
    const std::string compare = run("compare --help").out, bench = run("bench --help").out;
    EXPECT_NE(compare.find("--also TEXT (may be repeated)"), std::string::npos) << compare;
    EXPECT_NE(bench.find("--shots TEXT,... "), std::string::npos) << bench;
    EXPECT_NE(bench.find("--sizes TEXT,... "), std::string::npos) << bench;
    EXPECT_NE(bench.find("--set TEXT ..."), std::string::npos) << "which takes all that follow";
}

class CliRender : public Cli {};

TEST_F(CliRender, WritesFilesAndAReportWithEveryKey) {
    const fs::path out = folder_ / "a/b";
    const Result result = run(
        render("--out " + out.string() + " --size 48x32 --frames 1..3 --every 2 --capture depth,view_depth"));
    ASSERT_EQ(result.code, 0) << result.err;
    const Json report = Json::parse(read_file(out / "report.json"));
    for (const char* key :
         {"penumbra", "version",  "pipeline", "shot",     "seed",    "size",   "frames", "settings",
          "captures", "device",   "facts",    "frame_ms", "cpu_ms",  "passes", "culled", "memory",
          "counts",   "by_frame", "validate", "warnings", "outputs", "light"})
        EXPECT_TRUE(report.contains(key)) << key;
    EXPECT_EQ(report["frames"], (Json{1, 3}));
    EXPECT_EQ(report["size"], (Json{48, 32}));
    EXPECT_TRUE(report["validate"].is_null());
    for (const char* key : {"pixels", "receivers", "lit", "shadowed", "unknown", "tiles", "tiles_listed",
                            "rays", "penumbra_pixels"}) {
        ASSERT_TRUE(report["counts"].contains(key)) << key;
        const Json& count = report["counts"][key];
        EXPECT_TRUE(count.is_null() || count.is_number_integer()) << key << " " << count;
    }
    EXPECT_EQ(report["counts"]["pixels"], 48 * 32);
    for (const Json& pass : report["passes"])
        for (const auto& [name, value] : pass["counters"].items())
            EXPECT_TRUE(value.is_number_integer()) << name;
    std::set<int> frames;
    for (const Json& output : report["outputs"]) {
        EXPECT_TRUE(fs::exists(out / output["file"].get<std::string>()));
        frames.insert(output["frame"].get<int>());
    }
    EXPECT_EQ(frames, (std::set<int>{1, 3}));
}

// A cut is a cold start, to the bit; and without one the past is seen.
TEST_F(CliRender, AFrameAfterACutHasNoHistory) {
    Json shot = Json::parse(read_file(fs::path(PENUMBRA_SOURCE_DIR) / "scenes/colonnade.shot.json"));
    shot["scene"] = PENUMBRA_SOURCE_DIR "/scenes/colonnade.glb";
    shot.erase("$schema");
    const std::string whole = file("whole.shot.json", shot.dump());
    shot["cuts"] = {3, 5};
    const std::string cut = file("cut.shot.json", shot.dump());
    const auto report = [&](const std::string& of, const std::string& more) {
        const Result result = run("render pipelines/shadows.json --size 64x36 --no-jitter --shot " + of +
                                  " --out " + (folder_ / "o").string() + " --frames " + more);
        EXPECT_EQ(result.code, 0) << result.err;
        return Json::parse(read_file(folder_ / "o/report.json"));
    };
    const auto hash = [](const Json& of, const std::string& name, int frame) {
        for (const Json& output : of["outputs"])
            if (output["resource"] == name && output["frame"] == frame)
                return output["hash"].get<std::string>();
        ADD_FAILURE() << name;
        return std::string();
    };
    const Json cuts = report(cut, "0..5"), cold = report(whole, "5..5 --cold"), warm = report(whole, "0..5");
    for (const char* name : {"visibility", "color"}) {
        EXPECT_EQ(hash(cuts, name, 5), hash(cold, name, 5)) << name;
        EXPECT_NE(hash(cuts, name, 5), hash(warm, name, 5)) << name;
        EXPECT_EQ(hash(cuts, name, 2), hash(warm, name, 2)) << name;
        EXPECT_NE(hash(cuts, name, 4), hash(warm, name, 4)) << name;
    }
    ASSERT_EQ(cuts["by_frame"].size(), 6u);
    for (uint32_t frame = 0; frame < 6; ++frame) {
        const Json& one = cuts["by_frame"][frame];
        EXPECT_EQ(one["frame"], frame);
        EXPECT_EQ(one["reset"], frame == 0 || frame == 3 || frame == 5);
        EXPECT_EQ(warm["by_frame"][frame]["reset"], frame == 0);
        EXPECT_GT(one["rays"], 0);
        EXPECT_LE(one["rays"], 2 * one["receivers"].get<int>());  // two per pixel
        EXPECT_LT(one["mask_cpu_ms"], one["cpu_ms"]);
    }
    ASSERT_EQ(cold["by_frame"].size(), 1u);
    EXPECT_EQ(cold["by_frame"][0]["frame"], 5);
    for (const Json& pass : cuts["passes"]) {
        const std::string type = pass["type"];
        EXPECT_EQ(pass["mask"], type != "shade" && type != "taa" && type != "capture") << type;
        EXPECT_EQ(pass["params"].is_null(), type == "capture") << type;
        if (type == "trace") {
            EXPECT_EQ(pass["params"]["rays_per_pixel"], 1);
        }
    }
}

TEST_F(CliRender, ValidateReportsEveryResource) {
    const fs::path out = folder_ / "o";
    const Result result = run(render("--validate --size 48x32 --frames 0..2 --out " + out.string()));
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const Json validate = Json::parse(read_file(out / "report.json"))["validate"];
    for (const char* name : {"depth", "view_depth", "guide_normal", "visibility", "lit"}) {
        ASSERT_TRUE(validate.contains(name)) << name;
        EXPECT_EQ(validate[name]["checked"], 3 * 48 * 32) << name;
        for (const char* key : {"nan", "inf", "out_of_range"}) EXPECT_EQ(validate[name][key], 0) << name;
        EXPECT_TRUE(validate[name]["first_frame"].is_null()) << name;
    }
    ASSERT_TRUE(validate.contains("receiver_words"));
    EXPECT_TRUE(validate["receiver_words"].is_null()) << "words are neither finite nor not";
}

// The culprit comes before what it has spoilt, and the work has failed.
TEST_F(CliRender, ValidateNamesNodePortFrameAndCount) {
    fs::create_directories(folder_ / "nodes");
    file("nodes/spoil.json", R"({ "node": "spoil", "doc": "Wrong from frame 2 on.", "shader": "spoil.comp",
        "inputs": { "visibility": { "kind": "image", "format": "r16f" } },
        "outputs": { "spoiled": { "kind": "image", "format": "r16f", "range": [0, 1] } },
        "dispatch": { "over": "frame", "group": [8, 8] } })");
    file("nodes/spoil.comp", R"(#include "node.glsl"
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(spoiled)))) return;
    float v = texelFetch(visibility, p, 0).x;
    if (frame.frame_index >= 2u) {
        if (p == ivec2(3, 5)) v = uintBitsToFloat(0x7fc00000u);
        if (p.y == 31) v = 1.5;
    }
    imageStore(spoiled, p, vec4(v));
})");
    const std::string pipeline = file("spoilt.json", R"({ "extends": ")" PENUMBRA_SOURCE_DIR
                                                     R"(/pipelines/raw.json", "name": "spoilt",
        "resources": { "visibility": { "format": "r16f" } },
        "nodes": { "spoil": { "type": "spoil" }, "shade": { "in": { "visibility": "spoiled" } } } })");
    const std::string command = "render " + pipeline + " --nodes " + (folder_ / "nodes").string() +
                                " --shot scenes/colonnade.shot.json --size 48x32 --frames 0..3 --out " +
                                (folder_ / "o").string();
    const Result result = run(command + " --validate");
    EXPECT_EQ(result.code, 1);
    EXPECT_EQ(
        result.err.substr(0, result.err.find('\n')),
        "nodes.spoil.out.spoiled: frame 2: of 1536 texels 1 NaN, 0 infinite, 48 out of range (2, 0, 96 in "
        "all frames)");
    const Json report = Json::parse(read_file(folder_ / "o/report.json"));
    EXPECT_EQ(report["validate"]["spoiled"]["nan"], 2);
    EXPECT_EQ(report["validate"]["spoiled"]["out_of_range"], 96);
    EXPECT_EQ(report["validate"]["spoiled"]["first_frame"], 2);
    EXPECT_EQ(report["validate"]["visibility"]["nan"], 0);
    EXPECT_EQ(run(command).code, 0) << "without --validate nobody looks";
}

// What a shader declares is enabled where a device has it, and told where penumbra knows of no feature for
// it.
TEST_F(CliRender, ANodesShaderMayNeedWhatTheDeviceHas) {
    fs::create_directories(folder_ / "nodes");
    file("nodes/mine.json", R"({ "node": "mine", "doc": "A test.", "shader": "mine.comp",
        "outputs": { "mark": { "kind": "image", "format": "r16f" } },
        "dispatch": { "over": "frame", "group": [8, 8] } })");
    const std::string pipeline = file("mine.json", R"({ "penumbra": 1, "name": "mine", "outputs": ["mark"],
        "nodes": { "mine": { "type": "mine" } } })");
    const auto rendered = [&](const std::string& extension, const std::string& value) {
        file("nodes/mine.comp", "#include \"node.glsl\"\n#extension " + extension +
                                    " : require\nvoid main() { imageStore(mark, "
                                    "ivec2(gl_GlobalInvocationID.xy), vec4(" +
                                    value + ")); }\n");
        return run("render " + pipeline + " --nodes " + (folder_ / "nodes").string() +
                   " --shot scenes/lamp.shot.json --size 16x16 --frames 0 --validate --out " +
                   (folder_ / "o").string());
    };
    const Result doubles = rendered("GL_EXT_shader_explicit_arithmetic_types_float64",
                                    "float(double(gl_GlobalInvocationID.x) / 3.0)");
    if (doubles.code != 0) expect(doubles, 2, "lacks what this needs: feature shaderFloat64");
    fs::remove_all(folder_ / "o");
    expect(rendered("GL_ARB_shader_clock", "float(clockARB() & 1)"), 2,
           "lacks what this needs: feature SPIR-V capability 5055");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

// Names of files are bytes: frames that are rendered and rays that are counted are not lost for one.
TEST_F(CliRender, ANameThatIsNoUtf8IsReported) {
    Json shot = Json::parse(read_file(fs::path(PENUMBRA_SOURCE_DIR) / "scenes/lamp.shot.json"));
    shot["scene"] = PENUMBRA_SOURCE_DIR "/scenes/lamp.glb";
    shot.erase("$schema");
    const std::string small = " --size 16x16 --out ", model = (folder_ / "m\xff.glb").string(),
                      named = file("l\xff.shot.json", shot.dump());
    fs::copy_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.glb", model);
    const auto report_of = [&](const std::string& command, const char* report) {
        const Result result = run(command + small + (folder_ / "o").string());
        EXPECT_EQ(result.code, 0) << result.err;
        return Json::parse(read_file(folder_ / "o" / report));
    };
    EXPECT_EQ(report_of("render raw --frames 0 --shot " + named, "report.json")["shot"], "l\xef\xbf\xbd");
    EXPECT_EQ(report_of("reference --frames 0 --rays 16 --shot " + named, "reference.json")["frames"].size(),
              1u);
    EXPECT_EQ(report_of("render raw " + model, "report.json")["shot"], "m\xef\xbf\xbd");
    EXPECT_TRUE(fs::exists(folder_ / "o/m\xff.shot.json"));
}

// Nodes that are gone for a wrong letter are missed.
TEST_F(CliRender, AnOptionalInputThatNobodyKnowsIsNotLeftOutInSilence) {
    const std::string pipeline = file("mine.json", R"({ "name": "mine",
        "extends": ")" PENUMBRA_SOURCE_DIR R"(/pipelines/hybrid_shadows.json",
        "inputs": { "moved_boxes": null, "moved_boxs": { "optional": true } },
        "nodes": { "reuse": { "with": "moved_boxs", "in": { "moved_boxes": "moved_boxs" } },
                   "retain": { "with": "moved_boxs" } } })");
    const Result result = run("render " + pipeline + " --shot lamp --size 16x16 --frames 0 --out " + in("o"));
    expect(result, 0, "warning: " + pipeline + ":");
    expect(result, 0,
           "inputs.moved_boxs: the standalone host has no such input, and leaves it out; did you mean "
           "\"moved_boxes\"?\n");
    const Json warnings = Json::parse(read_file(folder_ / "o/report.json"))["warnings"];
    ASSERT_EQ(warnings.size(), 1u) << warnings;
    EXPECT_NE(warnings[0].get<std::string>().find("moved_boxs"), std::string::npos);
}

TEST_F(CliRender, AFactThatTheSceneCannotBearOutIsTheCommandsMistake) {
    for (const char* pipeline : {"raw", "shadows"})
        expect(run("render " + std::string(pipeline) +
                   " --shot colonnade --size 16x16 --frames 0 --facts alpha "
                   "--out " +
                   in("o")),
               2, "facts.alpha: taken as true, and no triangle of the scene has a texture with holes");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
    EXPECT_EQ(run("render raw --shot cards --size 16x16 --frames 0 --facts alpha --out " + in("o")).code, 0);
}

TEST_F(CliRender, AFolderThatCannotBeWrittenIsFailedWork) {
    const std::string plain = file("plain", "a file where the folder should be");
    expect(run(render("--size 16x16 --frames 0 --out " + plain + "/inside")), 1, plain);
    EXPECT_EQ(read_file(plain), "a file where the folder should be");
}

TEST_F(CliRender, WishesThatCannotBeMetAreExplained) {
    const std::string out = " --out " + (folder_ / "o").string();
    const Result device = run(render("--device nosuch" + out));
    expect(device, 2, "no usable Vulkan device is named \"nosuch\" among:\n");
    const std::string first = run("devices").out;
    EXPECT_NE(device.err.find(first.substr(0, first.find("  ["))), std::string::npos)
        << "it says which exist";
    for (const std::string& command :
         std::initializer_list<std::string>{"gates shadows", "report --out " + (folder_ / "r").string(),
                                            "report --signal specular --out " + (folder_ / "r").string(),
                                            "reference --shot scenes/lamp.shot.json" + out, "bench shadows",
                                            "explain --shot scenes/lamp.shot.json" + out + ".svg"})
        expect(run(command + " --device nosuch"), 2, "no usable Vulkan device is named \"nosuch\" among:\n");
    expect(run(render("--capture visibilty --size 16x16 --frames 0" + out)), 2,
           "did you mean \"visibility\"?");
    expect(run(render("--size 1000000x8 --frames 0" + out)), 2, "exceeds the device's largest image");
    expect(run("check scenes/lamp.shot.json"), 2, "penumbra_shot: this is a shot, not a pipeline");
    expect(run("render raw --shot pipelines/raw.json" + out), 2, "penumbra: this is a pipeline, not a shot");
    const std::string shot = file("plain.json", read_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.shot.json"));
    expect(run("render " + shot + out), 2, "this is a shot, not a pipeline");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

}  // namespace
}  // namespace penumbra::test
