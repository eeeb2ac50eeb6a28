#!/usr/bin/env bash
# What pipelines cost, as a Markdown table: CPU milliseconds of each pass of a type in TYPES on each shot, their sum, and how
# many native passes (tests/native_pass.h: a 3x3 filter by hand, in the same minutes) that is, which carries over to other machines.
#   scripts/compare_cost.sh
# PIPELINES (shadows fidelityfx), SHOTS, TYPES (trace and the denoisers' passes), FRAMES (0..11; each figure is a
# median of all but the first two), RUNS (3, the pipelines in turn: of each pass the least counts, as other work on the
# machine only adds), SIZE (640x360) and PENUMBRA may be set; VK_DRIVER_FILES chooses the driver, as scripts/mesa22.sh has it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
penumbra=${PENUMBRA:-build/release/app/penumbra}
read -ra shots <<<"${SHOTS:-cards colonnade engine fan heightfield lamp trees}"
read -ra pipelines <<<"${PIPELINES:-shadows fidelityfx}"
types=${TYPES:-trace prepare gather drift soften tileclass filter}
size=${SIZE:-640x360}
build=$(dirname "$penumbra")/..
[[ ! -f $build/build.ninja ]] || ninja -C "$build" native_pass_bench >&2 || : # built without tests there is none
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "| shot | pipeline | sum | native passes | of which |"
echo "|---|---|---|---|---|"
for shot in "${shots[@]}"; do
    : >"$work/native"
    for ((run = 0; run < ${RUNS:-3}; ++run)); do
        "$build/tests/native_pass_bench" "$size" >>"$work/native" || : # it says why
        for pipeline in "${pipelines[@]}"; do
            "$penumbra" render "pipelines/$pipeline.json" --shot "scenes/$shot.shot.json" --size "$size" \
                --frames "${FRAMES:-0..11}" --every 11 --no-jitter --out "$work/$pipeline.$run" >"$work/log" 2>&1 ||
                { cat "$work/log" >&2; exit 1; }
        done
    done
    for pipeline in "${pipelines[@]}"; do
        python3 - "$work/$pipeline" "$shot" "$pipeline" "${RUNS:-3}" "$types" <<'PYTHON'
import json, sys
folder, shot, pipeline, runs, types = sys.argv[1:]
least = {}
for run in range(int(runs)):
    for p in json.load(open(f"{folder}.{run}/report.json"))["passes"]:
        if p["type"] in types.split():
            least[p["node"]] = min(least.get(p["node"], 1e9), p["cpu_ms"]["median"])
parts = ", ".join(f"{name} {ms:.1f}" for name, ms in least.items())
native = min((float(line) for line in open(f"{folder.rpartition('/')[0]}/native")), default=float("nan"))
total = sum(least.values())
print(f"| {shot} | {pipeline} | {total:.1f} | {total / native:.1f} | {parts} |", flush=True)
PYTHON
    done
done
