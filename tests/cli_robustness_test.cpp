// SPDX-License-Identifier: MIT
// The program where the system lets it down: streams that cannot be written, memory that is not there. No
// device.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <map>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

class CliRobustness : public Cli {
  protected:
    // As run(), with the streams as the shell line says.
    Result raw(const std::string& before, const std::string& arguments, const std::string& streams) const {
        const std::string err = (folder_ / "err").string();
        const std::string command = "cd '" PENUMBRA_SOURCE_DIR "' && " + before + " '" PENUMBRA_PROGRAM "' " +
                                    arguments + " " + streams + " 2>'" + err + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", read_file(err)};
    }
};

const char* const printing[] = {"nodes",
                                "nodes --format json",
                                "nodes filter",
                                "plan pipelines/raw.json --size 64x64",
                                "plan pipelines/raw.json --size 64x64 --format json",
                                "--help",
                                "--version"};

TEST_F(CliRobustness, AnOutputThatIsFullOrClosedIsAFailure) {
    for (const char* command : printing) {
        for (const char* stream : {">/dev/full", ">&-"}) {
            const Result result = raw("", command, stream);
            EXPECT_EQ(result.code, 1) << command << " " << stream;
            EXPECT_NE(result.err.find("standard output cannot be written"), std::string::npos)
                << command << " " << stream << ": " << result.err;
        }
        EXPECT_EQ(raw("", command, ">/dev/null").code, 0) << command;
    }
    EXPECT_EQ(raw("", "check pipelines/raw.json", ">&-").code, 0) << "nothing was to be said";
}

// With the streams closed, the first file that is opened would take the place of one.
TEST_F(CliRobustness, AClosedStreamIsNotWrittenIntoAFile) {
    const fs::path out = folder_ / "plan";
    EXPECT_EQ(raw("", "plan pipelines/raw.json --size 64x64 --out " + out.string(), "<&- >&-").code, 0);
    const std::string text = read_file(out / "plan.json");
    EXPECT_TRUE(text.starts_with("{") && text.ends_with("}\n")) << text.substr(0, 80);
    for (const auto& entry : fs::directory_iterator(out))
        EXPECT_NE(entry.path().extension(), ".part") << "nothing half done is left";
}

// A plan that cannot be written whole is not there, and one that is smaller than what was there leaves
// nothing of that.
TEST_F(CliRobustness, AFolderHoldsOnePlanOrNone) {
    const fs::path out = folder_ / "plan";
    const auto files = [&] { return std::distance(fs::directory_iterator(out), fs::directory_iterator()); };
    const auto plan = [&](const char* pipeline) {
        return run(fmt::format("plan pipelines/{}.json --size 64x64 --out {}", pipeline, out.string()));
    };
    expect(plan("raw"), 0, "");
    const auto of_raw = files();
    expect(plan("hybrid_shadows"), 0, "");
    EXPECT_GT(files(), of_raw);
    expect(plan("raw"), 0, "");
    EXPECT_EQ(files(), of_raw);
    fs::remove(out / "plan.json");
    fs::create_directory(out / "plan.json");
    expect(plan("raw"), 1, "plan.json");
    EXPECT_EQ(files(), 1) << "the folder of that name alone";
}

TEST_F(CliRobustness, ABaseThatShipsElsewhereIsNamed) {
    const std::string mine = file("mine.json", R"({ "extends": "raw.json", "name": "mine" })");
    expect(run("check " + mine), 2, mine + ":1:14: extends: no file");
    expect(run("check " + mine), 2, mine + ":1:14: extends: the one that ships is ");
}

// Of 20 000 nodes in the shapes whose plans once took memory and time with their square, which would be 2 GB
// and minutes: a program that does so again ends at a limit far above what it takes.
TEST_F(CliRobustness, APlanTakesMemoryAndTimeInProportion) {
    fs::create_directories(folder_ / "types");
    file("types/pass_on.comp",
         "#include \"node.glsl\"\n"
         "void main() { imageStore(passed, ivec2(gl_GlobalInvocationID.xy), vec4(0.0)); }\n");
    file("types/pass_on.json", R"({"node": "pass_on", "doc": "d", "shader": "pass_on.comp",
        "inputs": {"given": {"kind": "image", "format": "r16f", "optional": true}},
        "outputs": {"passed": {"kind": "image", "format": "r16f"}},
        "dispatch": {"over": "passed", "group": [8, 8]}})");
    for (const std::string shape : {"chain", "outputs", "pasts"}) {
        std::string nodes, outputs;
        for (int i = 0; i < 20'000; ++i) {
            const std::string id = std::to_string(i), before = std::to_string(i - 1), comma = i ? "," : "";
            nodes += comma + "\n\"n" + id + R"(": {"type": "pass_on", "out": {"passed": "v)" + id + "\"}";
            if (shape == "chain" && i) nodes += R"(, "in": {"given": "v)" + before + "\"}";
            if (shape == "pasts" && i % 2) nodes += R"(, "in": {"given": "v)" + before + "@-1\"}";
            nodes += "}";
            if (shape != "chain" || i == 19'999) outputs += (outputs.empty() ? "\"v" : ",\"v") + id + "\"";
        }
        const std::string name = file(shape + ".json", R"({"penumbra": 1, "name": "p", "outputs": [)" +
                                                           outputs + "], \"nodes\": {" + nodes + "}}");
        const Result result =
            raw("ulimit -v 1000000; ulimit -t 30;",
                "plan " + name + " --size 64x64 --nodes " + (folder_ / "types").string(), ">/dev/null");
        EXPECT_EQ(result.code, 0) << shape << ": " << result.err;
    }
}

TEST_F(CliRobustness, ValuesThatAreNearlyRightAreRefused) {
    for (const char* size :
         {"'16 x16'", "+5x5", "16x16x16", "16x", "x16", "0x16", "16x-1", "16x16 ", "99999999999x1"})
        expect(run(std::string("plan pipelines/raw.json --size ") +
                   (std::string(size).ends_with(' ') ? "'16x16 '" : size)),
               2, "is not WIDTHxHEIGHT");
    expect(run("plan pipelines/raw.json --size 64x64 --out ''"), 2, "--out: the text is empty");
    expect(run("compare '' pipelines"), 2, "the text is empty");
    const std::string folders = "compare " + folder_.string() + " " + folder_.string();
    expect(run(folders + " --frames 0..4294967295"), 2, "--frames");
    expect(run(folders + " --frames 2..1"), 2, "--frames");
}

// What would have no say, or no answer, and which option it was.
TEST_F(CliRobustness, WhatCannotBeAnsweredIsRefused) {
    const std::string out = " --out " + (folder_ / "o").string();
    for (const char* option : {"--samples 64", "--pixel 3,4"})
        expect(run("explain --shot colonnade --budget " + std::string(option) + out), 2, "excludes");
    expect(run("explain --shot colonnade --gather --samples 64" + out), 2, "excludes");
    expect(run("report --shots scenes/walk.shot.json" + out), 2, "frames: is 48: 64 are measured");
    expect(run("bench raw --sizes 640"), 2, "--sizes: ");
    expect(run("bench raw --frames 3 --rounds 1"), 2, "--rounds 2");
    expect(run("view --window 1280 --shot engine"), 2, "--window: ");
    expect(run("gates raw --parts still --edge-deg 0 --widths 0.5 --seeds 1"), 2, "no pixel's centre");
    expect(run("gates raw --widths 8,128 --seeds 1"), 2, "--widths: a penumbra of 128 px is too wide");
    expect(run("view --frames 0 --shot engine"), 2, "--frames: ");
    for (const char* option : {"--budget", "--beams", "--gather", "--no-jitter", "--ground", "--device x"})
        expect(run("explain --out c.svg --costs x.json " + std::string(option)), 2, "excludes");
    expect(run("explain --shot lights/interior --out c.svg"), 2, "has no sun");
    expect(run("render raw --shot lamp --cascade-size 64" + out), 2, "--cascade-size: ");
    expect(run("render raw --shot lamp --cascade-size 017" + out), 2, "reads no shadow maps");  // 15 in octal
    const std::string view = "view raw --shot lamp --headless ";
    expect(run(view + "v.png --rays 16"), 2, "--rays: ");
    expect(run(view + "v.png" + out), 2, "excludes");
    expect(run(view + "v.jpg"), 2, "end its name in .png");
}

// Names that no JSON holds, that would be a folder above, or that another model's number has taken.
TEST_F(CliRobustness, ModelsOfOddNamesHaveShots) {
    const auto triangle = [&](const char* name, const char* nodes = R"([{"mesh": 0}])") {
        return file(name, std::string(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": )") +
                              nodes + R"(,
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri":
            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    };
    const std::string model = triangle("box.gltf"), second = triangle("box 2.gltf");
    expect(run("shot " + model + " " + model + " '" + second + "' --out " + in("boxes.shot.json")), 0, "");
    expect(run("shot '" + triangle("b\xff.gltf") + "' --out " + in("b.shot.json")), 2, "is no UTF-8");
    EXPECT_FALSE(fs::exists(in("b.shot.json")));
    expect(run("shot " + triangle("no.gltf", "[{}]") + " --out " + in("no.shot.json")), 2,
           "no node of its scene shows any");
    triangle("...gltf");
    EXPECT_EQ(raw("cd '" + folder_.string() + "' &&", "shot ...gltf", ">/dev/null").code, 0);
    EXPECT_TRUE(fs::exists(in("unnamed.shot.json")));
}

// A folder opens as a file does, and a device need not end.
TEST_F(CliRobustness, WhatIsNoFileOfTextIsRefused) {
    for (const std::string command :
         {"render raw --shot ", "view --headless v.png --shot ", "bench raw --shots "}) {
        expect(run(command + folder_.string()), 2, "cannot be read");
        expect(run(command + "/dev/zero"), 2, "has more than");
    }
    expect(run("explain --out c.svg --costs " + folder_.string()), 2, "is a folder");
    expect(run("gates raw --edge-deg nan"), 2, "is no number");
    expect(run("gates raw --widths 8,nan"), 2, "is no number");
}

// A name that no file can have is a mistake like any other.
TEST_F(CliRobustness, NamesThatAreTooLongAreRefused) {
    const std::string name(300, 'a'), out = " --out " + (folder_ / "o").string();
    for (const std::string& command :
         {"render raw " + name + ".glb" + out, "reference --model " + name + ".glb" + out,
          "explain --model " + name + ".glb --out " + (folder_ / "o.svg").string(),
          "render raw --shot " +
              file("far.shot.json", R"({ "penumbra_shot": 1, "scene": ")" + name + ".glb\" }") + out})
        expect(run(command), 2, name + ".glb: cannot be read: ");
    expect(run("render raw --shot " + name + ".shot.json" + out), 2, name + ".shot.json: cannot be read: ");
    expect(run("explain --out " + (folder_ / "o.svg").string() + " --costs " + name), 2, "no such file");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

// What a command reads it does not write over, whatever the name is that leads there.
TEST_F(CliRobustness, AnInputIsNotWrittenOver) {
    const std::string pipeline =
        R"({ "extends": ")" PENUMBRA_SOURCE_DIR R"(/pipelines/raw.json", "name": "mine" })";
    const std::string edge =
        R"({ "penumbra_shot": 1, "scene": { "analytic": "half_plane", "penumbra_px": 16 },
             "sun": { "keys": [{ "frame": 0, "to_sun": [0.3, 0.2, 1] }] } })";
    for (const char* inside : {"nodes", "shots", "rendered"}) fs::create_directories(folder_ / inside);
    fs::create_directory_symlink(".", folder_ / "link");
    for (const char* name : {"mine.json", "plan.json", "results.json", "report.json"}) file(name, pipeline);
    for (const char* name : {"reference.json", "shots/edge_8px_+0.shot.json"}) file(name, edge);
    file("nodes/mine.json", "{}");
    file("wall.png", "a texture");
    file("costs.svg", pipeline);
    file("wall.gltf", R"({ "asset": { "version": "2.0" }, "images": [{ "uri": "wall.png" }] })");
    file("wall.shot.json", R"({ "penumbra_shot": 1, "scene": "wall.gltf",
        "camera": { "keys": [{ "frame": 0, "position": [0, 1, 5], "target": [0, 0, 0] }] },
        "sun": { "keys": [{ "frame": 0, "to_sun": [0, 1, 0] }] } })");
    file("rendered/report.json", R"({ "shot_file": "../reference.json", "size": [8, 8], "by_frame": [] })");
    file("rendered/visibility.0000.exr", "a picture");
    const std::string here = " --out " + folder_.string();
    const auto refused = [&](const std::string& command, const std::string& name,
                             const std::string& because = "is read, and would be written over") {
        const std::string before = read_file(in(name));
        expect(run(command), 2, in(name) + ": " + because);
        EXPECT_EQ(read_file(in(name)), before) << command;
    };
    const std::string view = "view raw --shot lamp --headless ",
                      mine = "view " + in("mine.json") + " --shot lamp --headless ";
    refused(mine + in("mine.png"), "mine.json");
    refused(mine + in("link/mine.png"), "link/mine.json");
    refused(view + in("nodes/mine.png") + " --nodes " + in("nodes"), "nodes/mine.json");
    refused("view raw --shot " + in("wall.shot.json") + " --headless " + in("wall.png"), "wall.png");
    refused("plan " + in("plan.json") + " --size 64x64" + here, "plan.json");
    refused("render " + in("report.json") + " --shot lamp" + here, "report.json");
    refused("reference --shot " + in("reference.json") + here, "reference.json");
    refused("reference --like " + in("rendered") + " --out " + in("rendered"), "rendered");
    refused("explain --budget --shot " + in("wall.shot.json") + " --out " + in("wall.png"), "wall.png");
    refused("explain --costs " + in("costs.svg") + " --out " + in("costs.svg"), "costs.svg");
    const std::string report = "report --quick --size 64x48 --pipelines ";
    refused(report + in("results.json") + " --shots lamp" + here, "results.json");
    refused(report + "raw --shots " + in("shots/edge_8px_+0.shot.json") + here,
            "shots/edge_8px_+0.shot.json");
    for (const char* name : {"mine.png", "parts", "rendered/depth.0000.exr"})
        EXPECT_FALSE(fs::exists(in(name))) << name << ": nothing is written in part";
}

// What a report writes of a shot is called as the shot is.
TEST_F(CliRobustness, ShotsOfOneNameAreNotMixedUp) {
    for (const char* report : {"report --signal specular --quick", "report --quick --pipelines raw"})
        expect(run(report + std::string(" --shots radiance/street,lights/street --out ") +
                   (folder_ / "o").string()),
               2, "\"street\" is the name of scenes/radiance/street.shot.json too");
    EXPECT_FALSE(fs::exists(folder_ / "o"));
}

// operator new fails at the call of one number (tests/failing_new.cpp): whatever was under way ends with a
// word.
TEST_F(CliRobustness, AnAllocationThatFailsEndsWithAWord) {
    for (const char* command :
         {"check pipelines/hybrid_shadows.json", "plan pipelines/raw.json --size 64x64", "nodes"}) {
        size_t failed = 0;
        // Each third of the first hundred, where nothing but the program's own start is; then fewer and
        // fewer.
        for (size_t n = 1; n < 200'000; n += n < 100 ? 3 : 1 + n / 6) {
            const Result result =
                raw(preload(PENUMBRA_FAILING_NEW) + " PENUMBRA_FAIL_NEW_AT=" + std::to_string(n), command,
                    ">/dev/null");
            if (result.code == 0) continue;  // it was past the last one, or somebody could do without
            ++failed;
            EXPECT_TRUE(result.code == 1 || result.code == 2)
                << command << ", allocation " << n << ": exit code " << result.code;
            EXPECT_FALSE(result.err.empty()) << command << ", allocation " << n;
        }
        EXPECT_GT(failed, 20u) << command;
    }
}

using Files = std::map<std::string, std::string>;

Files files_in(const fs::path& folder) {
    Files files;
    for (const auto& entry : fs::directory_iterator(folder))
        files[entry.path().filename().string()] = read_file(entry.path());
    return files;
}

// Every call that puts a file on the disk goes wrong in turn (tests/failing_files.cpp), over a folder of
// older files: whatever stands there under its own name afterwards is one that was there or one that was to
// come, whole.
TEST_F(CliRobustness, AFileThatCannotBeWrittenEndsWithAWord) {
    const fs::path out = folder_ / "out_files";
    const auto plan = [&](const char* size, const std::string& before) {
        return raw(before, std::string("plan pipelines/raw.json --out ") + out.string() + " --size " + size,
                   ">/dev/null");
    };
    ASSERT_EQ(plan("640x64", "").code, 0);
    const Files older = files_in(out);
    ASSERT_EQ(plan("64x640", "").code, 0);
    const Files newer = files_in(out);
    ASSERT_NE(older, newer);
    std::map<std::string, size_t> faults;  // by the call
    for (const std::string& how : {std::to_string(ENOSPC), std::to_string(EROFS), std::to_string(EIO),
                                   std::to_string(EINTR), std::string("short"), std::string("kill")}) {
        const bool survives = how == "short" || how == std::to_string(EINTR), killed = how == "kill";
        for (size_t n = 1;; n += how == std::to_string(ENOSPC) || killed ? 1 : 3) {
            const std::string what = how + " at call " + std::to_string(n);
            fs::remove_all(out);
            fs::create_directories(out);
            for (const auto& [name, text] : older) std::ofstream(out / name) << text;
            const Result result =
                plan("64x640", preload(PENUMBRA_FAILING_FILES) + " PENUMBRA_FAIL_FILE_HOW=" + how +
                                   " PENUMBRA_FAIL_FILE_AT=" + std::to_string(n));
            const size_t at = result.err.find("[fault in ");
            if (at == std::string::npos) break;  // it was past the last one
            const std::string call = result.err.substr(at + 10, result.err.find(']') - at - 10);
            ++faults[call];
            Files left = files_in(out);
            if (killed) {
                EXPECT_EQ(result.code, 128 + SIGKILL) << what << result.err;
                std::erase_if(left, [](const auto& file) { return file.first.ends_with(".part"); });
            } else if (survives || result.code == 0) {
                EXPECT_EQ(result.code, 0) << what << ": " << result.err;
                EXPECT_TRUE(left == newer) << what;
                EXPECT_TRUE(survives || call == "fsync" || call == "flock")
                    << what << " was missed in " << call;
            } else {
                EXPECT_TRUE(result.code == 1 || result.code == 2) << what << ": " << result.code;
                EXPECT_NE(result.err.find(out.string()), std::string::npos) << what << ": " << result.err;
                EXPECT_NE(result.err.find(std::strerror(std::atoi(how.c_str()))), std::string::npos)
                    << what << ": " << result.err;
            }
            for (const auto& [name, text] : left) {
                const auto before = older.find(name), after = newer.find(name);
                EXPECT_TRUE((before != older.end() && before->second == text) ||
                            (after != newer.end() && after->second == text))
                    << what << ": " << name << " is neither the old nor the new one, or is left over";
            }
            if (killed) {
                EXPECT_EQ(plan("64x640", "").code, 0) << what;
                EXPECT_TRUE(files_in(out) == newer) << what << ": a killed run is not repeated";
            }
        }
    }
    size_t count = 0;
    for (const auto& [call, times] : faults) {
        EXPECT_GT(times, 5u) << call;
        count += times;
    }
    EXPECT_EQ(faults.size(), 6u) << "open, flock, ftruncate, write, fsync, rename";
    std::printf("%zu faults of %zu calls\n", count, faults.size());
}

}  // namespace
}  // namespace penumbra::test
