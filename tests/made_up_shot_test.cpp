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
