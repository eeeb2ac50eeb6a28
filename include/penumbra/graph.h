// SPDX-License-Identifier: MIT
// Penumbra's render graph. A pipeline (JSON) wires node types (declared in JSON) into a dataflow; compile()
// turns it into a plan, which is pure data; a Program holds its shaders on a device and a View records it for
// one camera.
//
// clang-format off
//     Diagnostics errors;
//     NodeSet nodes = shadow_nodes();  // penumbra/shadow_nodes.h, or a set of your own
//     auto pipeline = load_pipeline("pipelines/fidelityfx.json", {}, errors);
//     auto checked  = check(*pipeline, nodes, errors);
//     auto plan     = compile(*checked, {.extent = {1280, 720}, .device = device_table(device)}, {}, errors);
//     auto program  = std::make_shared<Program>(device, std::make_shared<Plan>(std::move(*plan)));
//     View view(program, {});
//     view.record(cmd, frame, slots);  // into your command buffer
// clang-format on
#pragma once

#include "penumbra/check.h"
#include "penumbra/compile.h"
#include "penumbra/device.h"
#include "penumbra/dump.h"
#include "penumbra/error.h"
#include "penumbra/node_set.h"
#include "penumbra/pipeline.h"
#include "penumbra/plan.h"
#include "penumbra/program.h"
#include "penumbra/requirements.h"
#include "penumbra/view.h"
