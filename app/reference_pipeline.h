// SPDX-License-Identifier: MIT
#pragma once

namespace penumbra {

extern const char* const reference_pipeline_text;  // pipelines/reference.json

}  // namespace penumbra
