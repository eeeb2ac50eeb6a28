// SPDX-License-Identifier: MIT
#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <iostream>
#include <set>
#include <string_view>

#include "penumbra/diagnostic.h"

namespace penumbra {

std::string duration_text(double seconds) {
    if (seconds < 90) return fmt::format("{:.0f} s", std::ceil(seconds));
    if (seconds < 90 * 60) return fmt::format("{:.0f} min", seconds / 60);
    return fmt::format("{:.1f} h", seconds / 3600);
}

std::string time_left(double seconds_so_far, uint64_t done, uint64_t total) {
    if (done >= total || seconds_so_far < 1 || done * 100 < total) return "";
    const double left = seconds_so_far * static_cast<double>(total - done) / static_cast<double>(done);
    return fmt::format("about {} left", duration_text(left));
}

Progress::Progress(std::string what, uint64_t total)
    : what_(std::move(what)), total_(total), visible_(isatty(STDERR_FILENO) == 1 && total > 0) {
    if (visible_) draw();
}

Progress::~Progress() {
    if (visible_) fmt::print(stderr, "\n");
}

void Progress::step(uint64_t work) {
    done_ += work;
    if (visible_) draw();
}

void Progress::note(const std::string& text) const {
    if (visible_) return;
    const std::string rest = left();
    fmt::print(stderr, "{}{}{}\n", text, rest.empty() ? "" : ", ", rest);
}

void Progress::say(const std::string& text) const {
    fmt::print(stderr, "{}{}\n", visible_ ? "\r\x1b[K" : "", text);
    if (visible_) draw();
}

void Progress::print(const std::string& lines) const {
    if (visible_) fmt::print(stderr, "\r\x1b[K");
    fmt::print("{}", lines);
    std::fflush(stdout);
    if (visible_) draw();
}

std::string Progress::left() const {
    const std::chrono::duration<double> so_far = std::chrono::steady_clock::now() - start_;
    return time_left(so_far.count(), done_, total_);
}

Doing::Doing() : visible_(isatty(STDERR_FILENO) == 1) {}

void Doing::operator()(const std::string& what, double share) {
    if (!visible_) return;
    const auto now = std::chrono::steady_clock::now();
    if (what != what_) start_ = now;
    what_ = what;
    constexpr uint64_t parts = 1000;
    const std::chrono::duration<double> so_far = now - start_;
    const std::string left = time_left(so_far.count(), static_cast<uint64_t>(share * parts), parts);
    const std::string part = share > 0 ? fmt::format(" {:.0f} %", 100 * share) : "";
    fmt::print(stderr, "\r\x1b[K{} ...{}{}{}", what, part, left.empty() ? "" : ", ", left);
}

void Doing::clear() const {
    if (visible_) fmt::print(stderr, "\r\x1b[K");
}

void Progress::draw() const {
    constexpr uint64_t width = 40;
    const uint64_t filled = width * done_ / total_;
    fmt::print(stderr, "\r{} [{:#<{}}{:.<{}}] {:3} % {:<20}", what_, "", filled, "", width - filled,
               100 * done_ / total_, left());
}

// By std::cerr, whose lines get colours (colored_errors.h).
void print_warnings(std::span<const std::string> warnings) {
    std::set<std::string_view> said;
    for (const std::string& warning : warnings)
        if (said.insert(warning).second) print_warning(warning);
}

void print_warning(const std::string& warning) {
    std::cerr << "warning: " << to_string(Diagnostic{{}, {}, warning}) << "\n";
}

}  // namespace penumbra
