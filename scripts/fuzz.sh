#!/usr/bin/env bash
# Fuzzes everything that takes bytes from outside, under address and undefined-behaviour sanitisers, so many seconds each:
#
#   scripts/fuzz.sh [SECONDS] [TARGET...]     60; pipeline declaration shot gltf exr image c_api mutant
#
# Starts from tests/fuzz/corpus and what ships, with tests/fuzz/TARGET.dict where there is one; what it finds interesting is
# kept in build/fuzz/corpus, what breaks something in build/fuzz/broken (it belongs into tests/fuzz/corpus, which every test
# run replays). Fails where anything broke. Set PENUMBRA_FUZZER to a fuzzer that is built already, PENUMBRA_FUZZ_SEED to repeat
# a run from the same corpus, PENUMBRA_FUZZ_OUT to
# another folder than build/fuzz.
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
mkdir -p "$out/broken"
failed=0
for target in "${targets[@]}"; do
    own=$out/corpus/$target
    mkdir -p "$own"
    seeds=("tests/fuzz/corpus/$target")
    case $target in
        pipeline) seeds+=(pipelines tests/golden/broken) ;;
        declaration) seeds+=(nodes tests/golden/broken) ;;
        shot) seeds+=(scenes/tuning) ;;
    esac
    dictionary=()
    [[ ! -f tests/fuzz/$target.dict ]] || dictionary=(-dict="tests/fuzz/$target.dict")
    # 20 seconds for an input are a hang; 256 MiB at once are a bomb, and 2 GiB in all (sanitisers take a part of it).
    if PENUMBRA_FUZZ_TARGET=$target "$fuzzer" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -malloc_limit_mb=256 -max_len=65536 \
        -seed="${PENUMBRA_FUZZ_SEED:-0}" -print_final_stats=1 "${dictionary[@]}" -artifact_prefix="$out/broken/$target-" "$own" "${seeds[@]}" >"$out/$target.log" 2>&1; then
        echo "fuzz: $target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$out/$target.log") inputs"
    else
        echo "fuzz: $target BROKE:" >&2
        tail -40 "$out/$target.log" >&2
        failed=1
    fi
done
exit $failed
