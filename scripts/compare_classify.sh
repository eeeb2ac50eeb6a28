#!/usr/bin/env bash
# What proofs cost and save, one Markdown row per shot: how many rays are traced by raw.json and by hybrid_raw.json, and CPU
# milliseconds of each pass from classify to trace.
#   scripts/compare_classify.sh
# SHOTS, FRAMES (0..6), SIZE (640x360) and PENUMBRA may be set; ARGS goes to the hybrid, such as
# ARGS="--set nodes.cones.params.patch=64".
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
penumbra=${PENUMBRA:-build/release/app/penumbra}
frames=${FRAMES:-0..6} size=${SIZE:-640x360}
read -ra shots <<<"${SHOTS:-cards colonnade engine fan heightfield lamp trees}"
read -ra more <<<"${ARGS:-}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The rays of a report, or a node's median CPU milliseconds.
rays() { awk '/"counts"/ { inside = 1 } inside && /"rays":/ { sub(/.*: */, ""); sub(/,.*/, ""); print; exit }' "$1"; }
cpu_ms() { # report, node
    awk -v node="\"node\": \"$2\"" '
        index($0, node) { inside = 1 }
        inside && /"cpu_ms"/ { at = 1 }
        inside && at && /"median":/ { sub(/.*: */, ""); sub(/[,}].*/, ""); printf "%.1f", $0; exit }' "$1"
}
sum() { awk 'BEGIN { for (i = 1; i < ARGC; ++i) s += ARGV[i]; printf "%.1f", s }' "$@"; }

echo "| shot | rays raw | rays hybrid | trace raw | beams | cones | trace hybrid | sum raw | sum hybrid |"
echo "|---|---|---|---|---|---|---|---|---|"
for shot in "${shots[@]}"; do
    "$penumbra" render pipelines/raw.json --shot "scenes/$shot.shot.json" --size "$size" --frames "$frames" \
        --out "$work/raw" >/dev/null 2>&1
    "$penumbra" render pipelines/hybrid_raw.json --shot "scenes/$shot.shot.json" --size "$size" --frames "$frames" \
        --out "$work/hybrid" ${more[@]+"${more[@]}"} >/dev/null 2>&1
    a=$work/raw/report.json b=$work/hybrid/report.json
    trace_a=$(cpu_ms "$a" trace) beams=$(cpu_ms "$b" beams) cones=$(cpu_ms "$b" cones) trace_b=$(cpu_ms "$b" trace)
    printf '| %s | %s | %s | %s | %s | %s | %s | %s | %s |\n' "$shot" "$(rays "$a")" "$(rays "$b")" "$trace_a" "$beams" \
        "$cones" "$trace_b" "$(sum "$(cpu_ms "$a" classify)" "$trace_a")" \
        "$(sum "$(cpu_ms "$b" classify)" "$beams" "$cones" "$trace_b")"
done
