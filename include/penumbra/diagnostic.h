// SPDX-License-Identifier: MIT
// Errors are values with a place: file, line and column in the user's text, the path inside it, and what to
// do. Functions that read user input take a Diagnostics& and return std::optional; they report every error
// they find.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

// A position in a text file. Lines and columns count from 1; 0 means "the whole file" (or no file at all).
struct Place {
    std::string file;
    int line = 0;
    int column = 0;
};

std::string to_string(const Place& place);  // "pipelines/x.json:14:23"

// One error. `path` is where in the document ("nodes.filter1.in.signal"), empty for syntax errors.
struct Diagnostic {
    Place place;
    std::string path;
    std::string message;
};

// "pipelines/x.json:14:23: nodes.filter1.in.signal: no resource named ..."
std::string to_string(const Diagnostic& diagnostic);

// The errors found so far, in the order they were found.
class Diagnostics {
  public:
    void add(Place place, std::string path, std::string message);
    bool empty() const { return list_.empty(); }
    size_t size() const { return list_.size(); }
    std::span<const Diagnostic> list() const { return list_; }
    std::string text() const;  // one line each

  private:
    std::vector<Diagnostic> list_;
};

// "; did you mean \"x\"?" for the candidate nearest to `name` in edit distance, or "" where none is near.
std::string did_you_mean(std::string_view name, std::span<const std::string> candidates);

}  // namespace penumbra
