#!/usr/bin/env bash
# Configures and builds one preset of CMakePresets.json: `scripts/build.sh release` builds everything, the tests included;
# `scripts/build.sh release TARGET...` these targets alone, for which the tests' packages need not be there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${1:?usage: scripts/build.sh PRESET [TARGET...]}
shift
if [[ $# -eq 0 ]]; then tests=ON; else tests=OFF; fi

# Ninja configures again by itself where a CMake file changed. A folder that has tests keeps them.
if [[ ! -f build/$preset/build.ninja ]] ||
    { [[ $tests == ON ]] && grep -qx 'PENUMBRA_TESTS:BOOL=OFF' "build/$preset/CMakeCache.txt"; }; then
    cmake --preset "$preset" -DPENUMBRA_TESTS=$tests
fi
cmake --build --preset "$preset" ${1:+--target "$@"}
