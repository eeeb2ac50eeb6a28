#!/usr/bin/env bash
# Installs what is missing, builds the program, and renders a colonnade and a real engine model into out/demo. Safe to repeat.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

render() { # pipeline, shot, frame to write, folder
    build/release/app/penumbra render "pipelines/$1.json" --shot "scenes/$2.shot.json" --frames "$3..$3" --out "out/demo/$4"
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
    cat <<EOF
demo: done. Look at
  out/demo/colonnade_raw/visibility.0015.png   noisy mask
  out/demo/colonnade/visibility.0015.png       visibility, nothing to denoise
  out/demo/colonnade/color.0015.png            lit and anti-aliased frame
  out/demo/engine/color.0015.png               the engine
  out/demo/colonnade_published/visibility.0015.png   what the published denoiser makes of the noise
(.exr beside each in full precision; report.json in each folder)
EOF
}

scripts/setup.sh
scripts/build.sh release penumbra penumbra_make_scenes
scripts/scenes.sh release
main_job
