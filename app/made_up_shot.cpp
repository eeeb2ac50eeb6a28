// SPDX-License-Identifier: MIT
#include "app/made_up_shot.h"

#include "app/digest.h"
#include "app/is_there.h"
#include "app/text_file.h"
#include "graph/read_text.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

fs::path mark_of(const fs::path& file) {
    return file.parent_path() / ("." + file.filename().string() + ".made_up");
}

}  // namespace

bool MadeUpShot::may_be_written(Diagnostics& diagnostics) const {
    const size_t before = diagnostics.size();
    if (text.empty() || !is_there(file, diagnostics)) return diagnostics.size() == before;
    const auto there = read_text(file);
    if (there && (there == text || read_text(mark_of(file)) == digest(*there))) return true;
    diagnostics.add(
        {file.string(), 0, 0}, "",
        "is there already, and not as a command has left it: give it with --shot, or write elsewhere");
    return false;
}

// The mark last: interrupted before it, what is there is still this text.
void MadeUpShot::write() const {
    if (text.empty()) return;
    write_text(file, text);
    write_text(mark_of(file), digest(text));
}

}  // namespace penumbra
