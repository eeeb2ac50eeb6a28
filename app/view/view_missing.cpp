// SPDX-License-Identifier: MIT
// penumbra view where the program was built without what a window takes.
#include <iostream>

#include "app/commands.h"

namespace penumbra {

int run_view(const ViewCommandArguments&) {
    std::cerr << "view: this program was built without GLFW and Dear ImGui. Install libglfw3-dev and "
                 "libimgui-dev (scripts/setup.sh does), and build it again\n";
    return exit_wrong;
}

}  // namespace penumbra
