#!/usr/bin/env bash
# Fuzzes everything that takes bytes from outside, under address and undefined-behaviour sanitisers, so many seconds each:
#
#   scripts/fuzz.sh [SECONDS] [TARGET...]     60; pipeline declaration shot gltf exr image c_api mutant
#
# Starts from tests/fuzz/corpus and what ships, with tests/fuzz/TARGET.dict where there is one; what it finds interesting is
# kept in build/fuzz/corpus, what breaks something in build/fuzz/broken/TARGET, which is tried first from then on (it belongs
# into tests/fuzz/corpus, which every test run replays). Fails where anything broke. Set PENUMBRA_FUZZER to a fuzzer that is
# built already, PENUMBRA_FUZZ_OUT to another folder than build/fuzz, and PENUMBRA_FUZZ_RUNS=N for N inputs, in SECONDS at
# most, that are the same in each run, which begins without a corpus of its own.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:-60}
shift || true
targets=("$@")
[[ ${#targets[@]} -gt 0 ]] || targets=(pipeline declaration shot gltf exr image c_api mutant)
fuzzer=${PENUMBRA_FUZZER:-}
if [[ -z $fuzzer ]]; then
    scripts/build.sh release fuzz
    fuzzer=build/release/tests/fuzz
fi
out=${PENUMBRA_FUZZ_OUT:-build/fuzz}
runs=${PENUMBRA_FUZZ_RUNS:-}
start=()
if [[ -n $runs ]] && setarch -R true 2>/dev/null; then start=(setarch -R); fi # addresses that are the same, where that may be asked
failed=0
for target in "${targets[@]}"; do
    own=$out/corpus/$target broken=$out/broken/$target
    [[ -z $runs ]] || rm -rf "$own"
    mkdir -p "$own" "$broken"
    seeds=("$broken")
    [[ ! -d tests/fuzz/corpus/$target ]] || seeds+=("tests/fuzz/corpus/$target")
    case $target in
        pipeline) seeds+=(pipelines tests/golden/broken) ;;
        declaration) seeds+=(nodes tests/golden/broken) ;;
        shot)
            rm -rf "$out/shots"
            mkdir -p "$out/shots" # a fuzzer reads a folder with all that is below it
            cp scenes/*.shot.json "$out/shots"
            seeds+=("$out/shots" scenes/tuning)
            ;;
    esac
    dictionary=()
    [[ ! -f tests/fuzz/$target.dict ]] || dictionary=(-dict="tests/fuzz/$target.dict")
    # Seeds count as runs. The corpus is not read again by the clock, and nothing is taken from what is compared, as numbers of
    # processes, which no two runs share.
    repeated=()
    [[ -z $runs ]] || repeated=(-seed=1 -reload=0 -use_cmp=0 -runs=$((runs + $(find "${seeds[@]}" -type f | wc -l))))
    # 20 seconds for an input are a hang; 256 MiB at once are a bomb, and 2 GiB in all (sanitisers take a part of it).
    if PENUMBRA_FUZZ_TARGET=$target "${start[@]}" "$fuzzer" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -malloc_limit_mb=256 \
        -max_len=65536 -print_final_stats=1 "${repeated[@]}" "${dictionary[@]}" -artifact_prefix="$broken/" "$own" "${seeds[@]}" >"$out/$target.log" 2>&1; then
        echo "fuzz: $target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$out/$target.log") inputs"
    else
        echo "fuzz: $target BROKE:" >&2
        tail -40 "$out/$target.log" >&2
        failed=1
    fi
done
exit $failed
