#!/usr/bin/env bash
# What the sun's shadow maps spare, and what they get wrong, on every shipped shot: each pixel's decision against many rays
# (penumbra compare), and the image against that of the same rays without a classifier. Prints a table. Environment: SIZE
# (default 160x90), CASCADE (texels, default 1024), RADII (of the sun, degrees), RAYS (of the reference), SHOTS, PENUMBRA
# (the program).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${PENUMBRA:-build/release/app/penumbra}
size=${SIZE:-160x90} cascade=${CASCADE:-1024} last=2
work=$(mktemp -d)
variant="scenes/maps_$$.shot.json" # beside the original, so that its model is found
trap 'rm -rf "$work" "$variant"' EXIT
run() { "$program" "$@" > "$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }

echo "| shot | sun's radius | classifier | rays without, % of receivers | rays, % | penumbra with rays | MR(.05) | false lit | eta | frames equal to the rays' | CPU ms without | with | pyramid | maps drawn | kept |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for shot in ${SHOTS:-cards colonnade engine fan heightfield lamp trees}; do
    for radius in ${RADII:-0.25 1}; do
        sed -E "s/(\"angular_radius_deg\": *)[0-9.]+/\1$radius/" "scenes/$shot.shot.json" > "$variant"
        run reference --shot "$variant" --out "$work/truth" --size "$size" --frames "$last..$last" --rays "${RAYS:-256}"
        for pipeline in raw hybrid_cascades_raw hybrid_published_raw; do
            rm -rf "${work:?}/$pipeline"
            verdicts=()
            [[ $pipeline == raw ]] || verdicts=(--capture "undecided_words,preloaded_hits")
            run render "pipelines/$pipeline.json" --shot "$variant" --out "$work/$pipeline" --size "$size" --frames "0..$last" \
                --cascade-size "$cascade" --no-jitter "${verdicts[@]}"
            "$program" compare "$work/$pipeline" "$work/truth" --frames "$last..$last" --json > "$work/$pipeline/compare.json"
        done
        python3 - "$work" "$shot" "$radius" <<'PYTHON'
import json, sys
work, shot, radius = sys.argv[1:]

def report(name): return json.load(open(f"{work}/{name}/report.json"))
def cpu(r, *types): return sum(p["cpu_ms"]["median"] for p in r["passes"] if p["type"] in types)
def images(r): return [o["hash"] for o in r["outputs"] if o["resource"] == "visibility"]
def show(value, form): return "-" if value is None else format(value, form)

raw = report("raw")
base = raw["counts"]["receivers"]
for name in ("hybrid_cascades_raw", "hybrid_published_raw"):
    r, m = report(name), json.load(open(f"{work}/{name}/compare.json"))["misclassified"]
    maps = r["cascades"]["cpu_ms"]
    same = sum(a == b for a, b in zip(images(raw), images(r)))
    print(f'| {shot} | {radius} | {name.split("_")[1]} | {100 * raw["counts"]["rays"] / base:.1f} | {100 * r["counts"]["rays"] / base:.1f} '
          f'| {show(m["recall"], ".4f")} | {show(m["0.05"], ".1e")} | {show(m["false_lit"], ".1e")} | {show(m["eta_ray"], ".3f")} | {same} of {len(images(raw))} '
          f'| {cpu(raw, "classify", "trace"):.1f} | {cpu(r, "classify", "cascades", "cascade_taps", "trace"):.1f} | {cpu(r, "cascade_pyramid"):.1f} '
          f'| {show(maps["drawn"], ".0f")} | {show(maps["kept"], ".2f")} |', flush=True)
PYTHON
    done
done
