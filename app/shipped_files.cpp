// SPDX-License-Identifier: MIT
#include "app/shipped_files.h"

#include <fmt/format.h>

#include <algorithm>

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

std::vector<fs::path> shipped_files(const fs::path& root, const ShippedKind& kind) {
    std::vector<fs::path> files;
    std::error_code failure;
    if (!root.empty())
        for (const auto& entry : fs::directory_iterator(root / kind.folder, failure))
            if (const std::string name = entry.path().filename().string();
                name.ends_with(kind.suffix) && name.find(".schema.") == std::string::npos)
                files.push_back((root == "." ? fs::path(kind.folder) : root / kind.folder) / name);
    std::sort(files.begin(), files.end());
    return files;
}

std::optional<fs::path> shipped_file(const std::string& wanted, const fs::path& root, const ShippedKind& kind,
                                     Diagnostics& diagnostics) {
    std::error_code failure;
    if (fs::exists(wanted, failure)) return fs::path(wanted);  // a folder: whoever reads it says so
    std::vector<std::string> names;
    for (const fs::path& file : shipped_files(root, kind)) {
        std::string name = file.filename().string();
        name.resize(name.size() - std::string_view(kind.suffix).size());
        if (name == wanted) return file;
        names.push_back(name);
    }
    diagnostics.add({wanted}, "",
                    fmt::format("no such file, and no {} of that name is shipped{}", kind.what,
                                did_you_mean(wanted, names)));
    return std::nullopt;
}

}  // namespace penumbra
