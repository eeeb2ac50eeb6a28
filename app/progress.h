// SPDX-License-Identifier: MIT
// What a command says on standard error as it works: a progress bar with the time that is left, where that
// is a terminal, and elsewhere notes alone; warnings.
#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>

namespace penumbra {

class Progress {
  public:
    // `total` in any unit of work.
    Progress(std::string what, uint64_t total);
    ~Progress();
    void step(uint64_t work = 1);  // so much more of `total` is done
    // A line of its own where there is no bar, with what is left.
    void note(const std::string& text) const;
    // A line of its own, above the bar where there is one.
    void say(const std::string& text) const;
    // Whole lines on standard output, which may be the terminal that the bar is on.
    void print(const std::string& lines) const;

  private:
    void draw() const;
    std::string left() const;

    std::string what_;
    uint64_t total_, done_ = 0;
    bool visible_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// What is being done before the amount of work is known: a line on a terminal, which the next one replaces
// and which is gone in the end.
class Doing {
  public:
    Doing();
    ~Doing() { clear(); }
    Doing(const Doing&) = delete;
    Doing& operator=(const Doing&) = delete;
    // `share` of it is done, 0 to 1: with the time that is left, where that can be told.
    void operator()(const std::string& what, double share = 0);
    void clear() const;  // before something else is printed

  private:
    bool visible_;
    std::string what_;
    std::chrono::steady_clock::time_point start_;
};

// A line; names in it come from files and may hold anything, which a terminal must not see.
void print_warning(const std::string& warning);
// The same text once.
void print_warnings(std::span<const std::string> warnings);

// "40 s", "12 min", "3.0 h"
std::string duration_text(double seconds);

// "about 40 s left"; nothing while less than a hundredth, or a second's work, is done: too little to tell.
std::string time_left(double seconds_so_far, uint64_t done, uint64_t total);

}  // namespace penumbra
