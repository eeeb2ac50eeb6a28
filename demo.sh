#!/usr/bin/env bash
# Installs what is missing, builds the program, and renders a colonnade and a real engine model into out/demo. Safe to repeat.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

render() { # pipeline, shot, frame to write, folder
    build/release/app/penumbra render "pipelines/$1.json" --shot "scenes/$2.shot.json" --frames "$3..$3" --out "out/demo/$4"
}

# Sun, reflections and indirect light: the rays as they are, and denoised, in one picture.
lit_room() {
    echo "demo: reflections and indirect light from one ray each per pixel, as they are and denoised"
    local signals=(--set nodes.compose.in.specular=radiance --set nodes.compose.in.diffuse=diffuse_radiance)
    for name in lit_noisy lit; do
        build/release/app/penumbra render pipelines/lit.json --shot scenes/radiance/chrome.shot.json --size 400x225 \
            --frames 15..15 --capture lit --out "out/demo/$name" $([[ $name == lit ]] || echo "${signals[@]}")
    done
    build/release/app/penumbra compare --signal lit --picture out/demo/lit.png out/demo/lit_noisy out/demo/lit
}

# The program's main job: visibility by exact coverage, and the frame that is lit with it and anti-aliased; beside it the noise
# that one ray per pixel gives, and what the published denoiser makes of it.
main_job() {
    echo "demo: one shadow ray per pixel, not denoised"
    render raw colonnade 15 colonnade_raw
    echo "demo: exact coverage, lit and anti-aliased, 16 frames of a moving camera, there and before a real model"
    render hybrid_shadows colonnade 15 colonnade
    render hybrid_shadows engine 15 engine
    echo "demo: the published denoiser on the first shot"
    render fidelityfx colonnade 15 colonnade_published
    lit_room
    cat <<EOF
demo: done. Look at
  out/demo/colonnade_raw/visibility.0015.png   noisy mask
  out/demo/colonnade/visibility.0015.png       visibility, nothing to denoise
  out/demo/colonnade/color.0015.png            lit and anti-aliased frame
  out/demo/engine/color.0015.png               the engine
  out/demo/colonnade_published/visibility.0015.png   what the published denoiser makes of the noise
  out/demo/lit.png                             a room with reflections and indirect light, one ray each per pixel: before, after
(.exr beside each in full precision; report.json in each folder)
EOF
}

scripts/setup.sh
scripts/build.sh release penumbra penumbra_make_scenes
scripts/scenes.sh release
main_job
