// SPDX-License-Identifier: MIT
// What this process holds, for tests that look for growth.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace penumbra::test {

inline long resident_kib() {
    std::ifstream status("/proc/self/statm");
    long pages = 0;
    status >> pages >> pages;
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

// Open files, which shared memory and sockets are as well.
inline long open_files() {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

}  // namespace penumbra::test
