// SPDX-License-Identifier: MIT
#include "app/view/file_watch.h"

namespace penumbra::viewer {

namespace fs = std::filesystem;

void FileWatch::watch(std::set<fs::path> files, std::vector<fs::path> folders) {
    files_ = std::move(files);
    folders_ = std::move(folders);
    seen_ = look();
}

FileWatch::State FileWatch::look() const {
    State state;
    const auto note = [&](const fs::path& file) {
        std::error_code failure;
        const auto time = fs::last_write_time(file, failure);
        const auto size = failure ? 0 : fs::file_size(file, failure);
        if (failure)
            state[file] = std::nullopt;  // it is gone, which is a change, too
        else
            state[file] = std::pair(time, size);
    };
    for (const fs::path& file : files_) note(file);
    for (const fs::path& folder : folders_) {
        std::error_code failure;
        constexpr auto links = fs::directory_options::follow_directory_symlink;  // to shaders' shared folders
        for (auto entry = fs::recursive_directory_iterator(folder, links, failure);
             !failure && entry != fs::recursive_directory_iterator(); entry.increment(failure))
            if (std::error_code none; entry->is_regular_file(none)) note(entry->path());
    }
    return state;
}

bool FileWatch::changed() {
    State now = look();
    if (now == seen_) return false;
    seen_ = std::move(now);
    return true;
}

}  // namespace penumbra::viewer
