// SPDX-License-Identifier: MIT
#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

namespace penumbra {

Progress::Progress(std::string what, uint32_t total)
    : what_(std::move(what)), total_(total), visible_(isatty(STDERR_FILENO) == 1 && total > 0) {
    if (visible_) draw();
}

Progress::~Progress() {
    if (visible_) fmt::print(stderr, "\n");
}

void Progress::step() {
    ++done_;
    if (visible_) draw();
}

void Progress::draw() const {
    constexpr uint32_t width = 40;
    const uint32_t filled = width * done_ / total_;
    fmt::print(stderr, "\r{} [{:#<{}}{:.<{}}] {}/{}", what_, "", filled, "", width - filled, done_, total_);
}

}  // namespace penumbra
