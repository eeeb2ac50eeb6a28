// SPDX-License-Identifier: MIT
// What `--help` says beyond the options, and completion for shells: both follow the command line as it is
// declared.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace penumbra {

// Gives every command its examples. Throws std::logic_error where a command has none, or where there are
// examples of one that does not exist.
void add_examples(CLI::App& app);

// A script for "bash", "zsh" or "fish" that completes commands, options and their values.
std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace penumbra
