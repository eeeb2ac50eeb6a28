#!/usr/bin/env bash
# Speed at equal error: per shot and number of rays per pixel the root mean square error over all receivers, and CPU
# milliseconds from classify to trace of raw.json / hybrid_raw.json, one after the other: no proofs, and those that pay at
# this number. Both must give the same image, or the script stops. A Markdown table.
#   scripts/compare_rays.sh
# SHOTS, COUNTS (1 2 4 8 16), FRAME (4), SIZE (640x360), RAYS (256, of the reference) and PENUMBRA may be set; ARGS goes to
# the hybrid, such as ARGS="--set nodes.cones.params.budget=24"; HYBRID (hybrid_raw) is its name, hybrid_cones_raw for all proofs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
penumbra=${PENUMBRA:-build/release/app/penumbra}
frame=${FRAME:-4} size=${SIZE:-640x360} hybrid=${HYBRID:-hybrid_raw}
read -ra shots <<<"${SHOTS:-cards colonnade engine fan heightfield lamp trees}"
read -ra counts <<<"${COUNTS:-1 2 4 8 16}"
read -ra more <<<"${ARGS:-}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
run() { "$penumbra" "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }
render() { # pipeline, rays, further arguments
    run render "pipelines/$1.json" --shot "$shot" --size "$size" --frames "0..$frame" --no-jitter \
        --set 'outputs=["visibility"]' --set "nodes.trace.params.rays_per_pixel=$2" --out "$work/$1" "${@:3}"
}

echo "| shot |$(printf ' %s |' "${counts[@]}")"
echo "|---|$(printf -- '---|%.0s' "${counts[@]}")"
for name in "${shots[@]}"; do
    shot=scenes/$name.shot.json
    run reference --shot "$shot" --size "$size" --frames "$frame" --rays "${RAYS:-256}" --out "$work/truth"
    printf '| %s |' "$name"
    for rays in "${counts[@]}"; do
        render raw "$rays"
        render "$hybrid" "$rays" ${more[@]+"${more[@]}"}
        "$penumbra" compare "$work/raw" "$work/truth" --frames "$frame" --json >"$work/compare.json"
        python3 - "$work" "$hybrid" <<'PYTHON'
import json, sys
work, hybrid = sys.argv[1:]
reports = [json.load(open(f"{work}/{name}/report.json")) for name in ("raw", hybrid)]
images = [[o["hash"] for o in r["outputs"]] for r in reports]
assert images[0] == images[1], "the pipelines' images differ"
ms = [sum(p["cpu_ms"]["median"] for p in r["passes"] if p["type"] in ("classify", "beams", "cones", "trace")) for r in reports]
error = json.load(open(f"{work}/compare.json"))["rmse"]["all"]
print(f" {error:.4f}: {ms[0]:.0f} / {ms[1]:.0f} |", end="")
PYTHON
    done
    echo
done
