// SPDX-License-Identifier: MIT
// Penumbra's render graph. A pipeline (JSON) wires node types (declared in JSON) into a dataflow; compile()
// turns it into a plan, which is pure data; a Program holds its shaders on a device and a View records it for
// one camera.
//
// clang-format off
//     Diagnostics errors;
//     NodeSet nodes = shadow_nodes();  // nodes/nodes.h, or a set of your own
//     auto pipeline = load_pipeline("pipelines/fidelityfx.json", {}, errors);
//     auto checked  = check(*pipeline, nodes, errors);
//     auto plan     = compile(*checked, {.extent = {1280, 720}, .device = device_table(device)}, {}, errors);
//     auto program  = std::make_shared<Program>(device, std::make_shared<Plan>(std::move(*plan)));
//     View view(program, {});
//     view.record(cmd, frame, slots);  // into your command buffer
// clang-format on
#pragma once

#include "graph/check.h"
#include "graph/compile.h"
#include "graph/dump.h"
#include "graph/node_set.h"
#include "graph/pipeline.h"
#include "graph/plan.h"
#include "graph/program.h"
#include "graph/view.h"
