// SPDX-License-Identifier: MIT
// Pipelines and shots that come with the program, by name: whoever types `hybrid_shadows` means
// pipelines/hybrid_shadows.json, wherever the shell is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "penumbra/diagnostic.h"

namespace penumbra {

struct ShippedKind {
    const char *folder, *suffix, *what;
    const char* version;  // the key that says which version of the format a file has
};
inline constexpr ShippedKind shipped_pipelines{"pipelines", ".json", "pipeline", "penumbra"};
inline constexpr ShippedKind shipped_shots{"scenes", ".shot.json", "shot", "penumbra_shot"};

// The folder that holds `pipelines/` and `scenes/`: the current one, or one above the program's. Empty where
// there is none.
std::filesystem::path shipped_root();

// The file that `wanted` names: itself where it is one, else the shipped one of that name below `root`; an
// error with what it may have meant, or where the file says that it is of another kind.
std::optional<std::filesystem::path> shipped_file(const std::string& wanted,
                                                  const std::filesystem::path& root, const ShippedKind& kind,
                                                  Diagnostics& diagnostics);
// All files of a kind, by name; without those of folders inside, which no list has by itself.
std::vector<std::filesystem::path> shipped_files(const std::filesystem::path& root, const ShippedKind& kind);
// The names that shipped_file() knows, those of folders inside (`lights/interior`) among them.
std::vector<std::string> shipped_names(const std::filesystem::path& root, const ShippedKind& kind);
bool is_shipped(const std::string& name, const std::filesystem::path& root, const ShippedKind& kind);

}  // namespace penumbra
