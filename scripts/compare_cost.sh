#!/usr/bin/env bash
# What pipelines cost, as a Markdown table: CPU milliseconds of each pass of a type in TYPES on each shot, and their sum.
#   scripts/compare_cost.sh
# PIPELINES (sheared hybrid_shadows shadows), SHOTS, TYPES (trace and the denoisers' passes), FRAMES (0..11; each figure is a
# median of all but the first two), RUNS (3, the pipelines in turn: of each pass the least counts, as other work on the
# machine only adds), SIZE (640x360) and PENUMBRA may be set; VK_DRIVER_FILES chooses the driver, as scripts/mesa22.sh has it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
penumbra=${PENUMBRA:-build/release/app/penumbra}
read -ra shots <<<"${SHOTS:-cards colonnade engine fan heightfield lamp trees}"
read -ra pipelines <<<"${PIPELINES:-sheared hybrid_shadows shadows}"
types=${TYPES:-trace prepare sun_points gather drift soften accumulate smooth tileclass filter}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "| shot | pipeline | sum | of which |"
echo "|---|---|---|---|"
for shot in "${shots[@]}"; do
    for ((run = 0; run < ${RUNS:-3}; ++run)); do
        for pipeline in "${pipelines[@]}"; do
            "$penumbra" render "pipelines/$pipeline.json" --shot "scenes/$shot.shot.json" --size "${SIZE:-640x360}" \
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
print(f"| {shot} | {pipeline} | {sum(least.values()):.1f} | {parts} |", flush=True)
PYTHON
    done
done
