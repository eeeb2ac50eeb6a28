// SPDX-License-Identifier: MIT
// What `--help` says beyond the options, and completion for shells: both follow the command line as it is
// declared.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace penumbra {

// What is wrong with the words behind `penumbra`, one at least, which `error` has stopped at, in a line or
// two: with the command or the option that a misspelt one may have been.
std::string wrong_words(const CLI::App& app, const CLI::ParseError& error,
                        const std::vector<std::string>& words);

// Gives every command its examples, and what options take in the words of this program. Throws
// std::logic_error where a command has none, or where there are examples of one that does not exist.
void add_examples(CLI::App& app);

// A script for "bash", "zsh" or "fish" that completes commands, options and their values.
std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace penumbra
