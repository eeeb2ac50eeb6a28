// SPDX-License-Identifier: MIT
// The shot that was made up for a model, as a file beside what was rendered of it. Who has changed that file
// wants to keep it: it is written over only where a mark beside it, a hidden file, says that it is as a
// command has left it.
#pragma once

#include <filesystem>
#include <string>

#include "penumbra/diagnostic.h"

namespace penumbra {

struct MadeUpShot {
    std::filesystem::path file;
    std::string text;  // empty: somebody wrote the shot, and nothing is to be done

    // Before any work; else an error.
    bool may_be_written(Diagnostics& diagnostics) const;
    void write() const;
};

}  // namespace penumbra
