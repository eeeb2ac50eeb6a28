// SPDX-License-Identifier: MIT
#include "app/shipped_files.h"

#include <dirent.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <memory>

#include "penumbra/json_text.h"

namespace penumbra {

namespace fs = std::filesystem;

fs::path shipped_root() {
    std::error_code none;
    const auto holds_both = [&](const fs::path& folder) {
        return fs::is_directory(folder / "pipelines", none) && fs::is_directory(folder / "scenes", none);
    };
    if (holds_both(".")) return ".";
    fs::path folder = fs::read_symlink("/proc/self/exe", none).parent_path();
    for (; !folder.empty() && folder != folder.root_path(); folder = folder.parent_path())
        if (holds_both(folder)) return fs::proximate(folder, none);
    return {};
}

namespace {

// In their order; none of a folder that is not there. libstdc++'s directory_iterator ends the program where
// memory does.
std::vector<fs::path> entries_of(const fs::path& folder) {
    std::vector<fs::path> entries;
    const auto close = [](DIR* open) { ::closedir(open); };
    const std::unique_ptr<DIR, decltype(close)> open(::opendir(folder.c_str()), close);
    while (const dirent* entry = open ? ::readdir(open.get()) : nullptr)
        if (const std::string name = entry->d_name; name != "." && name != "..")
            entries.push_back(folder / name);
    std::sort(entries.begin(), entries.end());
    return entries;
}

std::vector<fs::path> with_suffix(const fs::path& folder, const ShippedKind& kind) {
    std::vector<fs::path> files = entries_of(folder);
    std::erase_if(files, [&](const fs::path& file) {
        const std::string name = file.filename().string();
        return !name.ends_with(kind.suffix) || name.find(".schema.") != std::string::npos;
    });
    return files;
}

// By name: `lamp`, and of a folder inside `lights/interior`.
std::vector<std::pair<std::string, fs::path>> named_files(const fs::path& root, const ShippedKind& kind) {
    std::vector<std::pair<std::string, fs::path>> named;
    const auto add = [&](const fs::path& folder, const std::string& before) {
        for (const fs::path& file : with_suffix(folder, kind)) {
            std::string name = file.filename().string();
            name.resize(name.size() - std::string_view(kind.suffix).size());
            named.emplace_back(before + name, file);
        }
    };
    if (root.empty()) return named;
    const fs::path folder = root == "." ? fs::path(kind.folder) : root / kind.folder;
    add(folder, "");
    std::error_code failure;
    for (const fs::path& one : entries_of(folder))
        if (fs::is_directory(one, failure)) add(one, one.filename().string() + "/");
    return named;
}

// What else may be wrong with the file, whoever reads it says.
bool is_of_another_kind(const fs::path& file, const ShippedKind& kind, Diagnostics& diagnostics) {
    std::error_code failure;
    if (!fs::is_regular_file(file, failure)) return false;
    Diagnostics unheard;
    const auto json = read_json(file, unheard);
    if (!json || json->find(kind.version)) return false;
    // Reports have the version of a pipeline, too.
    const bool is_either = json->find("nodes") || json->find("extends") || json->find("scene");
    for (const ShippedKind& other : {shipped_pipelines, shipped_shots})
        if (const Json* version = json->find(other.version); version && is_either) {
            diagnostics.add(version->place, other.version,
                            fmt::format("this is a {}, not a {}", other.what, kind.what));
            return true;
        }
    return false;
}

}  // namespace

std::vector<fs::path> shipped_files(const fs::path& root, const ShippedKind& kind) {
    if (root.empty()) return {};
    return with_suffix(root == "." ? fs::path(kind.folder) : root / kind.folder, kind);
}

std::vector<std::string> shipped_names(const fs::path& root, const ShippedKind& kind) {
    std::vector<std::string> names;
    for (const auto& [name, file] : named_files(root, kind)) names.push_back(name);
    return names;
}

bool is_shipped(const std::string& name, const fs::path& root, const ShippedKind& kind) {
    return std::ranges::count(shipped_names(root, kind), name) > 0;
}

std::optional<fs::path> shipped_file(const std::string& wanted, const fs::path& root, const ShippedKind& kind,
                                     Diagnostics& diagnostics) {
    std::error_code failure;
    const auto named = named_files(root, kind);
    const auto shipped = std::ranges::find(named, wanted, &std::pair<std::string, fs::path>::first);
    const bool there = fs::exists(wanted, failure);
    // Of a folder whoever reads it says so, but for one that happens to have the name of what ships.
    if (there && !(shipped != named.end() && fs::is_directory(wanted, failure))) {
        if (is_of_another_kind(wanted, kind, diagnostics)) return std::nullopt;
        return fs::path(wanted);
    }
    if (failure) {
        diagnostics.add({wanted}, "", "cannot be read: " + failure.message());
        return std::nullopt;
    }
    if (shipped != named.end()) return shipped->second;
    std::vector<std::string> names = shipped_names(root, kind);
    std::string hint = did_you_mean(wanted, names);
    const auto holds = [&](const std::string& name) { return name.find(wanted) != std::string::npos; };
    if (hint.empty() && std::ranges::any_of(names, holds)) std::erase_if(names, std::not_fn(holds));
    if (hint.empty() && !names.empty() && !fs::path(wanted).has_extension())
        hint = fmt::format("; there are {}", fmt::join(names, ", "));
    diagnostics.add({wanted}, "",
                    fmt::format("no such file, and no {} of that name is shipped{}", kind.what, hint));
    return std::nullopt;
}

}  // namespace penumbra
