// SPDX-License-Identifier: MIT
// The shot that was made up for a model, as a file beside what was rendered of it. Who has changed that file
// wants to keep it: it is written over only where a report beside it says that it is as a command has left
// it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "penumbra/diagnostic.h"

namespace penumbra {

struct MadeUpShot {
    std::filesystem::path file;
    std::string text;  // empty: somebody wrote the shot, and nothing is to be done

    // Before any work; else an error.
    bool may_be_written(Diagnostics& diagnostics) const;
    // Takes an older one away together with its report: an interrupted command leaves none that nobody knows.
    void make_way() const;
    void write() const;
    // What reports have as `made_up_shot`.
    std::optional<std::string> mark() const;
};

}  // namespace penumbra
