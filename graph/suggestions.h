// SPDX-License-Identifier: MIT
// did_you_mean() for many names against one list: whoever gets everything wrong at once, in a file of ten
// thousand nodes, reads the first suggestions and not the rest, so the work for all of them together is
// bounded.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "penumbra/diagnostic.h"

namespace penumbra {

class Suggestions {
  public:
    explicit Suggestions(std::vector<std::string> names) : names_(std::move(names)) {}

    // "; did you mean ...?", or nothing where no name is near or where too many have been asked for.
    std::string nearest(std::string_view name) {
        if (compared_ > most_compared) return "";
        compared_ += names_.size();
        return did_you_mean(name, names_);
    }

  private:
    static constexpr size_t most_compared = 1'000'000;  // some tenths of a second

    std::vector<std::string> names_;
    size_t compared_ = 0;
};

}  // namespace penumbra
