#!/usr/bin/env bash
# Error and cost of pipelines on shots, as a Markdown table: root mean square error over all receivers and over the
# penumbra, effective samples per pixel (both against `penumbra reference`), and CPU milliseconds per frame of all passes.
#   scripts/compare_pipelines.sh
# SHOTS, PIPELINES, FRAME (15: after 16 frames), SIZE (640x360), RAYS (256, of the reference) and PENUMBRA may be set, and
# SUN: the sun's angular radius in degrees instead of the shots', for wider or narrower penumbrae.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
penumbra=${PENUMBRA:-build/release/app/penumbra}
frame=${FRAME:-15} size=${SIZE:-640x360} rays=${RAYS:-256}
read -ra shots <<<"${SHOTS:-cards colonnade engine fan heightfield lamp trees}"
read -ra pipelines <<<"${PIPELINES:-raw fidelityfx shadows}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The first number behind "key" in a JSON file, searched from the line that holds "section".
number() { # file, section, key
    awk -v section="\"$2\"" -v key="\"$3\":" '
        index($0, section) { inside = 1 }
        inside && index($0, key) { sub(/.*: */, ""); sub(/,.*/, ""); print; exit }' "$1"
}

echo "| shot | pipeline | RMSE all | RMSE penumbra | N_eff | CPU ms |"
echo "|---|---|---|---|---|---|"
for shot in "${shots[@]}"; do
    file=$work/$shot.shot.json
    sed -E "s#(\"scene\": *\")#\1$PWD/scenes/#; ${SUN:+s#(\"angular_radius_deg\": *)[0-9.]+#\1$SUN#}" \
        "scenes/$shot.shot.json" >"$file"
    "$penumbra" reference --shot "$file" --size "$size" --frames "$frame" --rays "$rays" \
        --out "$work/truth" >/dev/null
    for pipeline in "${pipelines[@]}"; do
        # Without jitter: the truth is that of pixel centres.
        "$penumbra" render "pipelines/$pipeline.json" --shot "$file" --size "$size" \
            --frames "$frame" --no-jitter --out "$work/$pipeline" >/dev/null 2>&1
        "$penumbra" compare "$work/$pipeline" "$work/truth" --json >"$work/compare.json"
        printf '| %s | %s | %.4f | %.3f | %.2f | %.0f |\n' "$shot" "$pipeline" \
            "$(number "$work/compare.json" rmse all)" "$(number "$work/compare.json" rmse penumbra)" \
            "$(number "$work/compare.json" n_eff value)" "$(number "$work/$pipeline/report.json" cpu_ms median)"
    done
done
