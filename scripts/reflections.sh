#!/usr/bin/env bash
# Effective rays per pixel of pipelines of reflections by roughness, standing still after 1, 9 and 65 frames and in motion after
# 17, and what is left of a lamp that went off, as docs/reflections.md shows them. Usage: scripts/reflections.sh OUT [SEEDS [PIPELINE...]]
set -euo pipefail
out=$(realpath -m "${1:?usage: scripts/reflections.sh OUT [SEEDS [PIPELINE...]]}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seeds=${2:-4}
shift $(($# < 2 ? $# : 2))
pipelines=("$@")
[[ ${#pipelines[@]} -gt 0 ]] || pipelines=(raw_reflections fidelityfx_reflections relax reflections)
penumbra=build/release/app/penumbra
size=192x108
signal=${SIGNAL:-specular}
mkdir -p "$out/shots"
ln -sfn "$PWD/scenes/polished.glb" "$PWD/scenes/chrome.glb" "$PWD/scenes/street.glb" "$out"

# The shot, its camera and objects held at the first of their keys.
still() {
    sed -E 's/(\{ "frame": 0, [^}]*\}), *$/\1 ] },/; s/(\{ "frame": 0, [^}]*\}), \{ "frame": 63.*\}$/\1 ] } }/; s/(\{ "frame": 0, [^}]*\}), \{ "frame": 63.*,$/\1 ] },/; /^ *\{ "frame": 63/d; s/"frames": 64/"frames": 65/' "scenes/radiance/$1.shot.json" >"$out/shots/still_$1.shot.json"
}

compare() { # PIPELINE SHOT FRAME: the row's figures
    local also=()
    for ((seed = 1; seed < seeds; ++seed)); do also+=(--also "$out/$1.$2.$seed"); done
    "$penumbra" compare --signal "$signal" --frames "$3" "$out/$1.$2.0" "$out/truth.$2" "${also[@]}" |
        sed -nE 's/^n_eff +([^ ]+) .*:(.*)/\2 \1/p; s/.*bias ([^ ]+) +fireflies ([0-9]+).*/bias \1 fireflies \2/p' | paste -sd' '
}

# The standing shot, whose lamps leave with frame 33.
off() { # SHOT OBJECT...
    local away='{ "keys": [ { "frame": 32, "translation": [0, 0, 0] }, { "frame": 33, "translation": [0, -500, 0] } ] }' objects=()
    for name in "${@:2}"; do objects+=("\"$name\": $away"); done
    sed -E "/\"objects\"/d; s/\"frames\": 65/\"frames\": 97/; s/(\"to_sun\": .*\] \}),?$/\1, \"objects\": { $(IFS=,; echo "${objects[*]}") }/" "$out/shots/still_$1.shot.json" >"$out/shots/off_$1.shot.json"
}

bias() { # PIPELINE SHOT FRAME
    "$penumbra" compare --signal "$signal" --frames "$3..$3" "$out/$1.off_$2" "$out/truth.off_$2" | sed -nE 's/.*bias ([^ ]+) .*/\1/p'
}

# Of the excess of light at frame 32 over that at frame 96, the share that is left 4, 8, 12, 16 and 24 frames later.
left() { # PIPELINE SHOT
    "$penumbra" render "pipelines/$1.json" --shot "$out/shots/off_$2.shot.json" --size $size --frames 0..96 --out "$out/$1.off_$2" >/dev/null
    for frame in 32 36 40 44 48 56 96; do bias "$1" "$2" $frame; done |
        awk '{ b[NR] = $1 } END { for (i = 2; i < NR; ++i) printf " %.0f %%", 100 * (b[i] - b[NR]) / (b[1] - b[NR]); print "" }'
}

for shot in polished chrome; do
    still $shot
    [[ $shot == polished ]] && off polished lamp bar || off chrome light
    "$penumbra" reference --signal "$signal" --rays 512 --shot "$out/shots/off_$shot.shot.json" --size $size --frames 36..36 --out "$out/truth.off_$shot" >/dev/null
    for frame in 32 40 44 48 56 96; do cp "$out/truth.off_$shot/$signal.0036.exr" "$out/truth.off_$shot/$signal.00$frame.exr"; done
    for pipeline in "${pipelines[@]}"; do
        [[ $pipeline != raw_* ]] || continue
        share=$(left "$pipeline" $shot)
        echo "$shot $pipeline, lamp off, left after 4 8 12 16 24 frames:$share"
    done
done

for shot in polished chrome street; do
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
