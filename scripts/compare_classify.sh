#!/usr/bin/env bash
# What proofs cost and save, one Markdown row per shot: rays, and CPU milliseconds of each pass from classify to trace, of
# raw.json (no proofs), hybrid_raw.json (those that pay at its rays per pixel) and hybrid_cones_raw.json (beams and cones).
# The three must give the same images, or the script stops.
#   scripts/compare_classify.sh
# SHOTS, FRAMES (0..11; each figure is a median of all but the first two), RUNS (1; in turn, and that of the least sum
# counts: other work on the machine only adds), SIZE (640x360), COUNT (1, rays per pixel) and PENUMBRA may be set; ARGS goes
# to the latter two pipelines, such as ARGS="--set nodes.cones.params.patch=64".
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
penumbra=${PENUMBRA:-build/release/app/penumbra}
read -ra shots <<<"${SHOTS:-cards colonnade engine fan heightfield lamp trees}"
read -ra more <<<"${ARGS:-}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "| shot | rays raw | chosen | cones | trace raw | chosen: beams | cones | trace | cones: beams | cones | trace | sum raw | chosen | cones |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for shot in "${shots[@]}"; do
    for ((run = 0; run < ${RUNS:-1}; ++run)); do
        for pipeline in raw hybrid_raw hybrid_cones_raw; do
            settings=(--set "nodes.trace.params.rays_per_pixel=${COUNT:-1}" --set 'outputs=["visibility"]' --no-jitter)
            [[ $pipeline == raw ]] || settings+=(${more[@]+"${more[@]}"})
            "$penumbra" render "pipelines/$pipeline.json" --shot "scenes/$shot.shot.json" --size "${SIZE:-640x360}" \
                --frames "${FRAMES:-0..11}" --out "$work/$pipeline.$run" "${settings[@]}" >"$work/log" 2>&1 ||
                { cat "$work/log" >&2; exit 1; }
        done
    done
    python3 - "$work" "$shot" "${RUNS:-1}" <<'PYTHON'
import json, sys
work, shot, runs = sys.argv[1:]
def total(r): return sum(p["cpu_ms"]["median"] for p in r["passes"] if p["type"] in ("classify", "beams", "cones", "trace"))
def least(name): return min((json.load(open(f"{work}/{name}.{i}/report.json")) for i in range(int(runs))), key=total)
raw, chosen, cones = (least(name) for name in ("raw", "hybrid_raw", "hybrid_cones_raw"))
for r in (chosen, cones):
    assert [o["hash"] for o in r["outputs"]] == [o["hash"] for o in raw["outputs"]], "the pipelines' images differ"
def ms(r, *types):
    found = [p["cpu_ms"]["median"] for p in r["passes"] if p["type"] in types]
    return f"{sum(found):.1f}" if found else "-"
parts = [ms(raw, "trace")] + [ms(r, t) for r in (chosen, cones) for t in ("beams", "cones", "trace")]
sums = [f"{total(r):.1f}" for r in (raw, chosen, cones)]
print(f"| {shot} | " + " | ".join([str(r["counts"]["rays"]) for r in (raw, chosen, cones)] + parts + sums) + " |", flush=True)
PYTHON
done
