#!/bin/sh
# Long runs of whole pipelines: the mean, the error and the reaction to a jump, at the beginning and after FRAMES (100000).
#
#   scripts/soak.sh [PIPELINE...]        shadows_fast where none is named
#
# FRAMES and BUILD (build/release) may be set.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$root/build/release}
[ $# -gt 0 ] || set -- shadows_fast
ninja -C "$build" soak >&2
exec "$build/tests/soak" "${FRAMES:-100000}" "$@"
