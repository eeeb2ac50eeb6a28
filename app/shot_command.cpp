// SPDX-License-Identifier: MIT
// penumbra shot: writes the shot that `render MODEL` would make up, as a start for one's own.
#include <fmt/format.h>

#include "app/commands.h"
#include "app/text_file.h"
#include "app/view_source.h"
#include "app/wrong.h"

namespace penumbra {

int run_shot(const ShotArguments& arguments) {
    namespace fs = std::filesystem;
    const fs::path out =
        arguments.out.empty() ? fs::path(view_name(arguments.view) + ".shot.json") : fs::path(arguments.out);
    Diagnostics diagnostics;
    const auto view = open_view(arguments.view, out.parent_path(), diagnostics);
    if (view && fs::exists(out)) diagnostics.add({out.string(), 0, 0}, "", "is there already");
    if (!view || !diagnostics.empty()) return wrong(diagnostics);
    if (out.has_parent_path()) fs::create_directories(out.parent_path());
    write_text(out, view->made_up);
    fmt::print("{}\n", out.generic_string());
    return exit_good;
}

}  // namespace penumbra
