#!/usr/bin/env bash
# Under address and undefined-behaviour sanitisers: tests of whatever takes input, plans and
# packs, then ten seconds of each fuzzer. `scripts/sanitize.sh all` runs the whole suite instead.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh --dev
export ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1
cmake --preset asan
if [[ ${1:-} == all ]]; then
    cmake --build --preset asan
    exec ctest --preset asan --no-tests=error -j2
fi
cmake --build --preset asan --target graph_test robustness_test
build/asan/tests/graph_test --gtest_filter='-Pack.*:Optimum.*:*HeapIsWithin*:House*:*PlanMutation*'
build/asan/tests/robustness_test --gtest_filter='-CliRobustness.AnAllocation*'
exec scripts/fuzz.sh 10
