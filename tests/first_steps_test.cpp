// SPDX-License-Identifier: MIT
// The page that leads from nothing to a node of one's own does so as it stands.
#include <nlohmann/json.hpp>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

// docs/first_steps.md from its first block to its last: files are written under their names, commands are
// run.
class FirstSteps : public Cli {};

TEST_F(FirstSteps, EveryStepWorks) {
    std::istringstream page(read_file(fs::path(PENUMBRA_SOURCE_DIR) / "docs/first_steps.md"));
    std::string line, name, text;
    bool inside = false, shell = false;
    int files = 0, commands = 0;
    while (std::getline(page, line)) {
        if (line.starts_with("```") && !inside) {
            inside = true;
            shell = line == "```sh";
            name = shell ? "" : line.substr(line.find(' ') + 1);
            text.clear();
        } else if (line.starts_with("```")) {
            inside = false;
            if (shell) continue;
            fs::create_directories((folder_ / name).parent_path());
            std::ofstream(folder_ / name) << text;
            ++files;
        } else if (inside && shell) {
            ASSERT_TRUE(line.starts_with("penumbra ")) << line;
            const std::string command = "cd '" + folder_.string() + "' && '" PENUMBRA_PROGRAM "'" +
                                        line.substr(8) + " >said 2>errors";
            EXPECT_EQ(std::system(command.c_str()), 0) << line << "\n" << read_file(folder_ / "errors");
            ++commands;
        } else if (inside) {
            text += line + "\n";
        }
    }
    EXPECT_EQ(files, 4);
    EXPECT_GE(commands, 6);
    const Json report = Json::parse(read_file(folder_ / "out/darker/report.json"));
    const Json& outputs = report["outputs"];
    ASSERT_EQ(outputs.size(), 2u);
    EXPECT_EQ(outputs[0]["min"], 0) << "there is full shadow";
    EXPECT_EQ(outputs[1]["min"], 0.25) << "of which the node lets a quarter through";
}

}  // namespace
}  // namespace penumbra::test
