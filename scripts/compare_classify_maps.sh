#!/usr/bin/env bash
# What shadow maps and cones spare, what they get wrong and what they cost, on every shipped shot: each pixel's decision
# against many rays (penumbra compare), the image against that of the same rays without a classifier, the shortened rays'
# answers against whole ones', and CPU time: of classifiers and rays, of the pyramid, of drawing the maps; the latter two
# also in a variant of the shot in which nothing moves, where both are kept. Prints a table. Environment: SIZE (default
# 160x90), CASCADE (texels, default 1024), RADII (of the sun, degrees), RAYS (of the reference), SHOTS,
# PIPELINES (of the four, raw first), PENUMBRA (the program).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${PENUMBRA:-build/release/app/penumbra}
size=${SIZE:-160x90} cascade=${CASCADE:-1024} last=2
work=$(mktemp -d)
variant="scenes/maps_$$.shot.json" still="scenes/maps_still_$$.shot.json" # beside the original, so that its model is found
trap 'rm -rf "$work" "$variant" "$still"' EXIT
run() { "$program" "$@" > "$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }

echo "| shot | sun | classifier | rays, % of receivers | penumbra with rays | MR(.05) | false lit | eta | answers changed by intervals | frames equal to the rays' | CPU ms classifiers + rays | with pyramid, kept | made anew | with maps, kept | drawn |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for shot in ${SHOTS:-cards colonnade engine fan heightfield lamp trees}; do
    for radius in ${RADII:-0.25 0.5 1 2}; do
        python3 - "$shot" "$radius" "$variant" "$still" << 'PYTHON'
import json, sys
shot, radius, variant, still = sys.argv[1:]
it = json.load(open(f"scenes/{shot}.shot.json"))
it.setdefault("sun", {})["angular_radius_deg"] = float(radius)
json.dump(it, open(variant, "w"))
for keyed in [it.get("camera", {}), it["sun"], *it.get("objects", {}).values()]:
    keyed["keys"] = keyed["keys"][:1]
json.dump(it, open(still, "w"))
PYTHON
        run reference --shot "$variant" --out "$work/truth" --size "$size" --frames "$last..$last" --rays "${RAYS:-256}"
        for pipeline in ${PIPELINES:-raw hybrid_cascades_raw hybrid_cones_raw hybrid_published_raw}; do
            rm -rf "${work:?}/$pipeline" "${work:?}/whole" "${work:?}/still_$pipeline"
            settings=(--size "$size" --frames "0..$last" --cascade-size "$cascade" --no-jitter)
            compared=()
            [[ $pipeline == raw ]] || settings+=(--capture "undecided_words,preloaded_hits,hits")
            run render "pipelines/$pipeline.json" --shot "$variant" --out "$work/$pipeline" "${settings[@]}"
            case $pipeline in
            hybrid_cascades_raw) interval="nodes.cascades.params.use_interval=false" ;;
            hybrid_published_raw) interval="nodes.taps.params.use_interval=false" ;;
            *) interval= ;;
            esac
            if [[ $interval ]]; then
                run render "pipelines/$pipeline.json" --shot "$variant" --out "$work/whole" "${settings[@]}" --set "$interval"
                compared=(--whole-rays "$work/whole")
                run render "pipelines/$pipeline.json" --shot "$still" --out "$work/still_$pipeline" "${settings[@]}"
            fi
            "$program" compare "$work/$pipeline" "$work/truth" --frames "$last..$last" --json "${compared[@]}" > "$work/$pipeline/compare.json"
        done
        python3 - "$work" "$shot" "$radius" << 'PYTHON'
import json, os, sys
work, shot, radius = sys.argv[1:]

def report(name):
    path = f"{work}/{name}/report.json"
    return json.load(open(path)) if os.path.exists(path) else None
def cpu(r, *types): return sum(p["cpu_ms"]["median"] for p in r["passes"] if p["type"] in types)
def images(r): return [o["hash"] for o in r["outputs"] if o["resource"] == "visibility"]
def show(value, form): return "-" if value is None else format(value, form)
def plus(*parts): return None if None in parts else sum(parts)

raw = report("raw")
base = raw["counts"]["receivers"]
for name, said in (("raw", "none"), ("hybrid_cascades_raw", "cascades"), ("hybrid_cones_raw", "cones"), ("hybrid_published_raw", "published")):
    r, still = report(name), report("still_" + name)
    if not r: continue
    m = json.load(open(f"{work}/{name}/compare.json"))["misclassified"]
    nodes = cpu(r, "classify", "cascades", "cascade_taps", "beams", "cones", "trace")
    anew = drawn = kept = maps_kept = None
    if still:
        kept, anew = (plus(nodes, cpu(x, "cascade_pyramid")) for x in (still, r))
        maps_kept, drawn = plus(kept, still["cascades"]["cpu_ms"]["kept"]), plus(anew, r["cascades"]["cpu_ms"]["drawn"])
    same = sum(a == b for a, b in zip(images(raw), images(r)))
    print(f'| {shot} | {radius} | {said} | {100 * r["counts"]["rays"] / base:.1f} '
          f'| {show(m["recall"], ".4f")} | {show(m["0.05"], ".1e")} | {show(m["false_lit"], ".1e")} | {show(m["eta_ray"], ".3f")} '
          f'| {show(m["interval"], ".1e")} | {same} of {len(images(raw))} | {nodes:.1f} | {show(kept, ".1f")} | {show(anew, ".1f")} '
          f'| {show(maps_kept, ".1f")} | {show(drawn, ".0f")} |', flush=True)
PYTHON
    done
done
