// SPDX-License-Identifier: MIT
// Whether files that something was made of have changed since: by their times and sizes, which is asked now
// and then; an editor that writes beside a file and renames is noticed as well.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace penumbra::viewer {

class FileWatch {
  public:
    // From now on these files, and all files of these folders, those that come later included.
    void watch(std::set<std::filesystem::path> files, std::vector<std::filesystem::path> folders);
    // Since the last call, or watch().
    bool changed();

  private:
    using State =
        std::map<std::filesystem::path, std::optional<std::pair<std::filesystem::file_time_type, uintmax_t>>>;
    State look() const;

    std::set<std::filesystem::path> files_;
    std::vector<std::filesystem::path> folders_;
    State seen_;
};

}  // namespace penumbra::viewer
