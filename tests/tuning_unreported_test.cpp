// SPDX-License-Identifier: MIT
// Constants are tuned on the shots of scenes/tuning/, so none of them may be among those that reports show.
#include <gtest/gtest.h>

#include <filesystem>

#include "app/report/contenders.h"
#include "host/generated/tuning/families.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

TEST(TuningShots, AreNotAmongTheShippedOnes) {
    const std::vector<fs::path> shipped = shipped_files(PENUMBRA_SOURCE_DIR, shipped_shots);
    EXPECT_EQ(shipped.size(), 8u);  // seven shots and the walk
    for (const tuning::Family& family : tuning::all_families)
        for (const uint32_t seed : tuning::committed_seeds) {
            const std::string name = std::string(family.name) + "_" + std::to_string(seed);
            const fs::path file = fs::path(PENUMBRA_SOURCE_DIR) / "scenes/tuning" / (name + ".shot.json");
            EXPECT_TRUE(fs::exists(file)) << file;
            for (const fs::path& other : shipped)
                EXPECT_FALSE(fs::equivalent(file, other) || other.filename() == file.filename()) << other;
            Diagnostics diagnostics;
            EXPECT_FALSE(shipped_file(name, PENUMBRA_SOURCE_DIR, shipped_shots, diagnostics)) << name;
        }
}

}  // namespace
}  // namespace penumbra::report
