// SPDX-License-Identifier: MIT
#include "app/made_up_shot.h"

#include "app/digest.h"
#include "app/is_there.h"
#include "app/text_file.h"
#include "graph/read_text.h"
#include "penumbra/json_text.h"

namespace penumbra {

namespace fs = std::filesystem;

bool MadeUpShot::may_be_written(Diagnostics& diagnostics) const {
    const size_t before = diagnostics.size();
    if (text.empty() || !is_there(file, diagnostics)) return diagnostics.size() == before;
    const auto there = read_text(file);
    if (there == text) return true;
    for (const char* report : {"report.json", "reference.json"}) {
        Diagnostics unheard;
        const auto json = read_json(file.parent_path() / report, unheard);
        const Json* known = json ? json->find("made_up_shot") : nullptr;
        if (there && known && known->string == digest(*there)) return true;
    }
    diagnostics.add(
        {file.string(), 0, 0}, "",
        "is there already, and not as a command has left it: give it with --shot, or write elsewhere");
    return false;
}

void MadeUpShot::make_way() const {
    if (!text.empty() && read_text(file) != text) fs::remove(file);
}

void MadeUpShot::write() const {
    if (!text.empty()) write_text(file, text);
}

std::optional<std::string> MadeUpShot::mark() const {
    return text.empty() ? std::nullopt : std::optional(digest(text));
}

}  // namespace penumbra
