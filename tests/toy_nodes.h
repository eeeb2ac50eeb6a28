// SPDX-License-Identifier: MIT
// A small node set for tests of the front end: declarations with every feature of the vocabulary, without
// shaders.
#pragma once

#include <string>

#include "penumbra/node_set.h"

namespace penumbra::test {

// The shadow nodes' domain with one fact more and structs of its own.
std::shared_ptr<const Domain> toy_domain();
NodeSet toy_nodes();

// A declaration's text ("filter", "trace", ...), to break on purpose.
std::string toy_declaration(const std::string& name);

// A valid pipeline over the toy nodes with history, an update and conditions.
std::string toy_pipeline();

// Parses a declaration; throws std::runtime_error with the diagnostics' text if it has errors.
NodeType parse_toy(const std::string& text, const std::string& name);

}  // namespace penumbra::test
