#!/usr/bin/env bash
# Fuzzes everything that takes bytes from outside, under address and undefined-behaviour sanitisers, so many seconds each:
#
#   scripts/fuzz.sh [SECONDS] [TARGET...]     60; pipeline declaration shot gltf exr image c_api mutant
#
# Starts from tests/fuzz/corpus and what ships; what it finds interesting is kept in build/fuzz/corpus, what breaks something
# in build/fuzz/broken (it belongs into tests/fuzz/corpus, which every test run replays). Fails where anything broke.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:-60}
shift || true
targets=("$@")
[[ ${#targets[@]} -gt 0 ]] || targets=(pipeline declaration shot gltf exr image c_api mutant)

cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --target "${targets[@]/#/fuzz_}"
mkdir -p build/fuzz/broken
failed=0
for target in "${targets[@]}"; do
    own=build/fuzz/corpus/$target
    mkdir -p "$own"
    seeds=("tests/fuzz/corpus/$target")
    case $target in
        pipeline) seeds+=(pipelines tests/golden/broken) ;;
        declaration) seeds+=(nodes tests/golden/broken) ;;
        shot) seeds+=(scenes/tuning) ;;
    esac
    # A second for an input is a hang; a GiB is a bomb (sanitisers take a part of it).
    if build/fuzz/tests/"fuzz_$target" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 \
        -artifact_prefix=build/fuzz/broken/"$target-" "$own" "${seeds[@]}" >build/fuzz/"$target.log" 2>&1; then
        echo "fuzz: $target: $(sed -n 's/^stat::number_of_executed_units: *//p' build/fuzz/"$target.log") inputs"
    else
        echo "fuzz: $target BROKE:" >&2
        tail -40 build/fuzz/"$target.log" >&2
        failed=1
    fi
done
exit $failed
