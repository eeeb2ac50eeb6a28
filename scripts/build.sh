#!/usr/bin/env bash
# Configures and builds one preset of CMakePresets.json: `scripts/build.sh release`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${1:?usage: scripts/build.sh PRESET}

# Ninja configures again by itself where a CMake file changed.
[[ -f build/$preset/build.ninja ]] || cmake --preset "$preset"
cmake --build --preset "$preset"
