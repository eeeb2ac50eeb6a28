// SPDX-License-Identifier: MIT
// Node types of a folder, whose GLSL is compiled at run time; of the library penumbra_glsl.
#include "penumbra/user_nodes.h"

#include "capi/shared.h"

using namespace penumbra;
using namespace penumbra::c;

penumbra_code penumbra_nodes_add_folder(penumbra_nodes* nodes, const char* folder, const char* cache,
                                        penumbra_error* error) {
    return guarded(error, [&] {
        Mistakes mistakes;
        if (!add_user_nodes(given(nodes, "nodes").set, named(folder, "folder"), mistakes.diagnostics,
                            cache ? open_shader_cache(cache) : nullptr))
            throw mistakes;
    });
}
