// SPDX-License-Identifier: MIT
// The page's parts, from app/report/assets/, as the build has embedded them.
#pragma once

namespace penumbra::report::assets {

extern const char* const page_html;      // the whole, with {{places}}
extern const char* const headline_html;  // masks after a cut
extern const char* const edge_html;      // masks behind moving edges
extern const char* const shot_html;      // a section per shot
extern const char* const pipeline_html;  // an article per pipeline
extern const char* const radiance_html;  // the whole page of radiance, with {{places}}
extern const char* const style_css;
extern const char* const page_js;

}  // namespace penumbra::report::assets
