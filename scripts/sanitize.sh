#!/usr/bin/env bash
# Under address and undefined-behaviour sanitisers: tests of whatever takes input, plans and packs, then ten
# seconds of each fuzzer, all in the fuzzers' build, so that one serves both. `scripts/sanitize.sh all` builds and runs
# the whole suite instead, with the other compiler (the preset asan).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh --dev
export ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1
if [[ ${1:-} == all ]]; then
    cmake --preset asan
    cmake --build --preset asan
    exec ctest --preset asan --no-tests=error -j2
fi
cmake --preset fuzz
cmake --build --preset fuzz --target graph_test robustness_test
# Left out: searches for packings that take minutes, and what replaces operator new, which is ASan's here.
build/fuzz/tests/graph_test --gtest_filter='-Pack.*:Optimum.*:*HeapIsWithin*:House*:*PlanMutation*:*reflections*:*indirect*'
build/fuzz/tests/robustness_test --gtest_filter='-CliRobustness.AnAllocation*:CliRobustness.AFileThat*'
exec scripts/fuzz.sh 10
