// SPDX-License-Identifier: MIT
// penumbra shot: writes the shot that `render MODEL` would make up, as a start for one's own.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/text_file.h"
#include "app/view_source.h"
#include "app/wrong.h"
#include "host/json_dump.h"
#include "host/shots/model_shot.h"

namespace penumbra {
namespace {

// Whether a text comes back from JSON as it was.
bool fits_json(const std::string& text) {
    return nlohmann::json::parse(json_dump(nlohmann::json(text))) == text;
}

}  // namespace

int run_shot(const ShotArguments& arguments) {
    namespace fs = std::filesystem;
    const fs::path out =
        arguments.out.empty() ? fs::path(view_name(arguments.view) + ".shot.json") : fs::path(arguments.out);
    Diagnostics diagnostics;
    for (const std::string& model : arguments.view.models)
        if (!fits_json(seen_from(model, out.parent_path())))
            diagnostics.add({model, 0, 0}, "", "its name is no UTF-8, as which a shot would name it");
    if (!diagnostics.empty()) return wrong(diagnostics);
    const auto view = open_view(arguments.view, out.parent_path(), diagnostics);
    if (view && fs::exists(out)) diagnostics.add({out.string(), 0, 0}, "", "is there already");
    if (!view || !diagnostics.empty()) return wrong(diagnostics);
    if (out.has_parent_path()) fs::create_directories(out.parent_path());
    write_text(out, view->made_up);
    fmt::print("{}\n", out.generic_string());
    return exit_good;
}

}  // namespace penumbra
