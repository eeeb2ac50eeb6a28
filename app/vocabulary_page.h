// SPDX-License-Identifier: MIT
// The keys of declarations and pipelines as a page of Markdown, docs/vocabulary.md.
#pragma once

#include <string>

#include "penumbra/domain.h"

namespace penumbra {

std::string vocabulary_page(const Domain& domain);

}  // namespace penumbra
