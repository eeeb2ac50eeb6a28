// SPDX-License-Identifier: MIT
// Colours on a terminal, and nowhere else: what goes to std::cerr line by line is red, a warning yellow.
// NO_COLOR in the environment leaves it plain (no-color.org).
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <streambuf>
#include <string>

namespace penumbra {

class ColoredErrors : public std::streambuf {
  public:
    ColoredErrors() : plain_(std::cerr.rdbuf()) {
        const char* wish = std::getenv("NO_COLOR");
        if (isatty(STDERR_FILENO) == 1 && !(wish && *wish)) std::cerr.rdbuf(this);
    }
    ~ColoredErrors() override {
        write();
        std::cerr.rdbuf(plain_);
    }
    ColoredErrors(const ColoredErrors&) = delete;
    ColoredErrors& operator=(const ColoredErrors&) = delete;

  protected:
    int_type overflow(int_type c) override {
        if (c == '\n') write();
        if (c == '\n')
            plain_->sputc('\n');
        else if (c != traits_type::eof())
            line_ += static_cast<char>(c);
        return traits_type::not_eof(c);
    }

  private:
    void write() {
        if (line_.empty()) return;
        const std::string text =
            (line_.starts_with("warning:") ? "\x1b[33m" : "\x1b[31m") + line_ + "\x1b[0m";
        plain_->sputn(text.data(), static_cast<std::streamsize>(text.size()));
        line_.clear();
    }

    std::streambuf* plain_;
    std::string line_;
};

}  // namespace penumbra
