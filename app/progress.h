// SPDX-License-Identifier: MIT
// A progress bar on standard error, where that is a terminal; silent elsewhere.
#pragma once

#include <cstdint>
#include <string>

namespace penumbra {

class Progress {
  public:
    Progress(std::string what, uint32_t total);
    ~Progress();
    void step();  // one more of `total` is done

  private:
    void draw() const;

    std::string what_;
    uint32_t total_, done_ = 0;
    bool visible_;
};

}  // namespace penumbra
