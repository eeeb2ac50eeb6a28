// SPDX-License-Identifier: MIT
// The shot that a command makes up for a model and leaves beside its picture.
#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

class MadeUpShot : public Cli {};

// The shot that was made up is written anew as the options or the model change, until somebody changes it.
TEST_F(MadeUpShot, ThatSomebodyChangedIsKept) {
    const std::string model = in("m.glb"), small = " --size 48x32 --out " + in("o");
    fs::copy_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.glb", model);
    const auto shot = [&] { return read_file(in("o/m.shot.json")); };
    ASSERT_EQ(run("render raw " + model + small).code, 0);
    const std::string plain = shot();
    ASSERT_EQ(run("render raw --ground " + model + small).code, 0);
    EXPECT_NE(shot(), plain);
    ASSERT_EQ(run("reference --model " + model + " --rays 16 --frames 0" + small).code, 0);
    EXPECT_EQ(shot(), plain);
    ASSERT_EQ(run("reference --signal specular --rays 16 --frames 0 --ground --model " + model + small).code,
              0);
    EXPECT_NE(shot(), plain);
    ASSERT_EQ(run("render raw --frames 0 --shot " + in("o/m.shot.json") + small).code, 0);
    ASSERT_EQ(run("render raw " + model + small).code, 0);
    EXPECT_EQ(shot(), plain);

    file("o/m.shot.json", shot() + "\n");
    const std::string changed = shot(), report = read_file(in("o/report.json"));
    for (const std::string& command :
         {"render raw " + model, "render raw --ground " + model, "reference --ground --model " + model,
          "reference --signal specular --model " + model})
        expect(run(command + small), 2, in("o/m.shot.json") + ": is there already");
    EXPECT_EQ(shot(), changed);
    EXPECT_EQ(read_file(in("o/report.json")), report) << "nothing else is touched";
    EXPECT_EQ(run("render raw --frames 0 --shot " + in("o/m.shot.json") + small).code, 0);
    EXPECT_EQ(shot(), changed);

    // One that was written as a start, and says the same, is in nobody's way.
    ASSERT_EQ(run("shot " + model + " --out " + in("p/m.shot.json")).code, 0);
    EXPECT_EQ(run("render raw " + model + " --size 48x32 --out " + in("p")).code, 0);
}

// Frames of another model of that name, or of a longer animation, would pass for this run's. What the program
// has not written stays, and so does what somebody has written since.
TEST_F(MadeUpShot, IsRenderedWithoutFramesOfAnEarlierRun) {
    const std::string small = " --size 48x32 --out " + in("o"), render = "render raw scenes/lamp.glb";
    const auto there = [&](const std::string& name) { return fs::exists(folder_ / "o" / name); };
    ASSERT_EQ(run("render raw lamp --frames 0" + small).code, 0);
    ASSERT_EQ(run("render raw lamp --frames 2..4 --capture depth" + small).code, 0);
    EXPECT_TRUE(there("visibility.0000.exr")) << "who asks for some frames may want them beside others";
    file("o/visibility.0099.exr", "mine");
    fs::last_write_time(in("o/visibility.0002.exr"),
                        fs::file_time_type::clock::now() + std::chrono::hours(1));
    const Result second = run(render + small);
    ASSERT_EQ(second.code, 0) << second.err;
    EXPECT_NE(second.out.find(" of an earlier run removed"), std::string::npos) << second.out;
    for (const char* gone :
         {"visibility.0003.exr", "visibility.0003.png", "visibility.0004.exr", "lit.0002.png"})
        EXPECT_FALSE(there(gone)) << gone;
    for (const char* kept : {"visibility.0000.exr", "visibility.0002.exr", "visibility.0099.exr",
                             "depth.0003.exr", "visibility.0015.exr", "visibility.0015.png", "report.json"})
        EXPECT_TRUE(there(kept)) << kept;
    const Result third = run(render + small);
    ASSERT_EQ(third.code, 0) << third.err;
    EXPECT_EQ(third.out.find("removed"), std::string::npos) << "all is written again";
    EXPECT_TRUE(there("visibility.0015.png"));

    ASSERT_EQ(run("render raw lamp --frames 2..4" + small).code, 0);
    ASSERT_EQ(run(render + " --every 2" + small).code, 0);
    EXPECT_TRUE(there("visibility.0003.exr")) << "--every asks for some frames, too";

    // What is read stays, whatever its name in the folder, and is no reason to refuse.
    const std::string model = in("m.glb"), frame = in("o/visibility.0003.exr");
    ASSERT_EQ(run("render raw lamp --frames 2..4" + small).code, 0);
    fs::copy_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.glb", model);
    fs::last_write_time(model, fs::file_time_type::clock::now() - std::chrono::hours(1));
    fs::remove(frame);
    fs::create_hard_link(model, frame);
    const Result linked = run("render raw " + model + small);
    EXPECT_EQ(linked.code, 0) << linked.err;
    EXPECT_TRUE(there("visibility.0003.exr"));
    EXPECT_FALSE(there("visibility.0004.exr"));
}

TEST_F(MadeUpShot, SaysWhereItsPictureIsEmpty) {
    const auto square = [&](const char* name, const std::string& more) {
        return file(name, R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri":
            "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],)" +
                              more + "}");
    };
    const std::string nothing = "warning: the picture shows nothing of the scene; ",
                      small = " --size 48x32 --out " + in("o");
    expect(run("render raw " + small + " " +
               square("glass.gltf", R"("materials": [{"alphaMode": "BLEND", "pbrMetallicRoughness":
                   {"baseColorFactor": [1, 1, 1, 0.5]}}], "nodes": [{"mesh": 0}])")),
           0, nothing + "what lets light through is not drawn");
    expect(run("render raw " + small + " " +
               square("away.gltf", R"("materials": [{}], "nodes": [{"mesh": 0, "children": [1]},
                   {"name": "Eye", "camera": 0, "translation": [0, 0, -3]}],
                   "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}])")),
           0, nothing + "it is seen by the model's own camera, \"Eye\"");
    expect(run("render raw " + small + " " +
               square("back.gltf", R"("materials": [{}], "nodes": [{"mesh": 0, "rotation": [0, 1, 0, 0]}])")),
           0, nothing + "it is too small or too thin");
    const Result front = run("render raw " + small + " " +
                             square("front.gltf", R"("materials": [{}], "nodes": [{"mesh": 0}])"));
    EXPECT_EQ(front.err.find("shows nothing"), std::string::npos) << front.err;
}

// Without --out the shot stands in the current folder: both can be moved together.
TEST_F(MadeUpShot, NamesItsModelAsSeenFromItsFolder) {
    fs::copy_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.glb", in("m.glb"));
    const auto shot = [&](const std::string& arguments, const std::string& written) {
        const std::string command =
            "cd '" + folder_.string() + "' && '" PENUMBRA_PROGRAM "' shot " + arguments + " >out 2>err";
        EXPECT_EQ(std::system(command.c_str()), 0) << read_file(in("err"));
        return read_file(in(written));
    };
    EXPECT_NE(shot("m.glb", "m.shot.json").find("\"scene\": \"m.glb\""), std::string::npos);
    EXPECT_NE(shot("m.glb --out b/s.shot.json", "b/s.shot.json").find("\"scene\": \"../m.glb\""),
              std::string::npos);
    const std::string several = shot("m.glb m.glb --out two.shot.json", "two.shot.json");
    EXPECT_NE(several.find("\"file\": \"m.glb\""), std::string::npos) << several;
}

}  // namespace
}  // namespace penumbra::test
