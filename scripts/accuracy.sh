#!/bin/sh
# Effective samples per pixel of a pipeline on a straight penumbra with a known answer, as a Markdown table: rows are
# penumbra widths in pixels, columns speeds of the edge in pixels per frame (positive: the shadow grows).
#
#   scripts/accuracy.sh [PIPELINE] [EXTRA RENDER ARGUMENTS...]
#
# SEEDS (8), FRAME (79: the frame that is measured), SIZE (256x128), BORDER (24 pixels are left out: what a denoiser
# does at the image's border is not in question), WIDTHS, SPEEDS, EDGE_DEG (20) and PENUMBRA (the program) may be set.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
pipeline=${1:-$root/pipelines/fidelityfx.json}
[ $# -gt 0 ] && shift
penumbra=${PENUMBRA:-$root/build/release/app/penumbra}
seeds=${SEEDS:-8} frame=${FRAME:-79} size=${SIZE:-256x128} border=${BORDER:-24} edge_deg=${EDGE_DEG:-20}
widths=${WIDTHS:-8 16 32} speeds=${SPEEDS:-0 0.25 1 4 -0.25 -1 -4}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# At the measured frame the penumbra's middle passes the image's.
write_shot() { # WIDTH SPEED
    offset=$(awk "BEGIN { print -($2) * $frame }")
    cat >"$work/shot.json" <<END
{
  "penumbra_shot": 1,
  "scene": { "analytic": "half_plane", "penumbra_px": $1, "edge_deg": $edge_deg, "speed_px": $2, "offset_px": $offset },
  "frames": $((frame + 1)),
  "sun": { "angular_radius_deg": 0.2665, "keys": [ { "frame": 0, "to_sun": [0.3, 0.2, 1] } ] }
}
END
}

n_eff() { # WIDTH SPEED, and arguments of render
    write_shot "$1" "$2"
    shift 2
    "$penumbra" reference --shot "$work/shot.json" --size "$size" --frames "$frame" --out "$work/truth" >/dev/null
    also=
    seed=1
    while [ "$seed" -le "$seeds" ]; do
        "$penumbra" render "$pipeline" --shot "$work/shot.json" --size "$size" --frames "$frame" --no-jitter --seed "$seed" \
            --out "$work/$seed" "$@" >/dev/null
        [ "$seed" -eq 1 ] || also="$also --also $work/$seed"
        seed=$((seed + 1))
    done
    # shellcheck disable=SC2086  # a list of words
    "$penumbra" compare "$work/1" "$work/truth" $also --border "$border" >"$work/result"
    awk '$1 == "n_eff" { printf "%.3g", $2 }' "$work/result"
}

printf '| w \\\\ u |'
for speed in $speeds; do printf ' %s |' "$speed"; done
printf '\n|---|'
for speed in $speeds; do printf -- '---|'; done
printf '\n'
for width in $widths; do
    printf '| %s |' "$width"
    for speed in $speeds; do
        value=$(n_eff "$width" "$speed" "$@")
        printf ' %s |' "$value"
    done
    printf '\n'
done
