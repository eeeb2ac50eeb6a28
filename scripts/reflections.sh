#!/usr/bin/env bash
# Effective rays per pixel of pipelines of reflections by roughness, standing still after 1, 9 and 65 frames and in motion after
# 17, as docs/reflections.md shows them. Usage: scripts/reflections.sh OUT [SEEDS [PIPELINE...]]
set -euo pipefail
out=$(realpath -m "${1:?usage: scripts/reflections.sh OUT [SEEDS [PIPELINE...]]}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seeds=${2:-4}
shift $(($# < 2 ? $# : 2))
pipelines=("$@")
[[ ${#pipelines[@]} -gt 0 ]] || pipelines=(raw_reflections fidelityfx_reflections reflections)
penumbra=build/release/app/penumbra
size=192x108
signal=${SIGNAL:-specular}
mkdir -p "$out/shots"
ln -sfn "$PWD/scenes/polished.glb" "$PWD/scenes/chrome.glb" "$out"

# The shot, its camera and objects held at the first of their keys.
still() {
    sed -E 's/(\{ "frame": 0, [^}]*\}), *$/\1 ] },/; s/(\{ "frame": 0, [^}]*\}), \{ "frame": 63.*$/\1 ] } }/; /^ *\{ "frame": 63/d; s/"frames": 64/"frames": 65/' "scenes/radiance/$1.shot.json" >"$out/shots/still_$1.shot.json"
}

compare() { # PIPELINE SHOT FRAME: the row's figures
    local also=()
    for ((seed = 1; seed < seeds; ++seed)); do also+=(--also "$out/$1.$2.$seed"); done
    "$penumbra" compare --signal "$signal" --frames "$3" "$out/$1.$2.0" "$out/truth.$2" "${also[@]}" |
        sed -nE 's/^n_eff +([^ ]+) .*:(.*)/\2 \1/p; s/.*bias ([^ ]+) +fireflies ([0-9]+).*/bias \1 fireflies \2/p' | paste -sd' '
}

for shot in polished chrome; do
    still $shot
    "$penumbra" reference --signal "$signal" --rays 4096 --shot "$out/shots/still_$shot.shot.json" --size $size --frames 0..0 --out "$out/truth.still_$shot" >/dev/null
    for frame in 0008 0064; do cp "$out/truth.still_$shot/$signal.0000.exr" "$out/truth.still_$shot/$signal.$frame.exr"; done
    "$penumbra" reference --signal "$signal" --rays 4096 --shot scenes/radiance/$shot.shot.json --size $size --frames 16..16 --out "$out/truth.$shot" >/dev/null
    for pipeline in "${pipelines[@]}"; do
        for ((seed = 0; seed < seeds; ++seed)); do
            "$penumbra" render "pipelines/$pipeline.json" --shot "$out/shots/still_$shot.shot.json" --size $size --frames 0..64 --every 8 --seed $seed --out "$out/$pipeline.still_$shot.$seed" >/dev/null
            "$penumbra" render "pipelines/$pipeline.json" --shot scenes/radiance/$shot.shot.json --size $size --frames 16..16 --seed $seed --out "$out/$pipeline.$shot.$seed" >/dev/null
        done
        for frame in 0 8 64; do echo "$shot $pipeline still $((frame + 1)): $(compare "$pipeline" "still_$shot" $frame..$frame)"; done
        echo "$shot $pipeline moving 17: $(compare "$pipeline" "$shot" 16..16)"
    done
done
