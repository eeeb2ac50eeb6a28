// SPDX-License-Identifier: MIT
#pragma once

namespace penumbra {

extern const char* const reference_pipeline_text;           // pipelines/reference.json
extern const char* const raw_pipeline_text;                 // pipelines/raw.json
extern const char* const reference_radiance_pipeline_text;  // pipelines/reference_radiance.json
extern const char* const reference_lit_pipeline_text;       // pipelines/reference_lit.json

}  // namespace penumbra
