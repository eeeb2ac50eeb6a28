#!/usr/bin/env bash
# Whether the intervals that the shadow maps' proof leaves to rays change an answer: frames with and without them, the
# ray-hit words bit by bit. Per shot a Markdown row; below, the share of changed answers that their number rules out with
# 95 % confidence where none is changed (rule of three).
#   scripts/compare_intervals.sh
# SHOTS, FRAMES (0..3), SIZE (960x540), CASCADE (texels, 1024) and PENUMBRA may be set.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${PENUMBRA:-build/release/app/penumbra}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for shot in ${SHOTS:-cards colonnade engine fan heightfield lamp trees}; do
    for interval in true false; do
        "$program" render pipelines/hybrid_cascades_raw.json --shot "scenes/$shot.shot.json" --size "${SIZE:-960x540}" \
            --frames "${FRAMES:-0..3}" --cascade-size "${CASCADE:-1024}" --no-jitter --capture hits \
            --set "nodes.cascades.params.use_interval=$interval" --out "$work/$shot.$interval" > "$work/log" 2>&1 ||
            { cat "$work/log" >&2; exit 1; }
    done
done
python3 - "$work" << 'PYTHON'
import glob, json, sys

def words(report):
    return [o["hash"] for o in report["outputs"] if o["resource"] == "hits"]

print("| shot | frames | rays | frames with another hit word | CPU ms of rays, whole | with intervals |\n|---|---|---|---|---|---|")
total = different = 0
for path in sorted(glob.glob(sys.argv[1] + "/*.true")):
    with_them, whole = (json.load(open(f"{path[:-5]}.{form}/report.json")) for form in ("true", "false"))
    a, b = words(with_them), words(whole)
    assert a and len(a) == len(b), "no hit words were captured"
    rays = with_them["counts"]["rays"] * len(a)  # a median frame's
    changed = sum(x != y for x, y in zip(a, b))
    ms = [sum(p["cpu_ms"]["median"] for p in r["passes"] if p["type"] == "trace") for r in (whole, with_them)]
    total, different = total + rays, different + changed
    print(f"| {path.split('/')[-1][:-5]} | {len(a)} | {rays} | {changed} | {ms[0]:.1f} | {ms[1]:.1f} |")
print(f"\n{total} rays, {different} frames differ" + ("" if different else f"; below {3 / total:.1e} (95 %)"))
PYTHON
