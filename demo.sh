#!/usr/bin/env bash
# Installs what is missing, builds, and renders the colonnade with two pipelines into out/demo. Safe to repeat.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

# The program's main job. Both pipelines run on the same frames, so that their images can be compared.
main_job() {
    local penumbra=build/release/app/penumbra
    local pipeline
    for pipeline in raw fidelityfx; do
        echo "demo: rendering scenes/colonnade.shot.json with pipelines/$pipeline.json"
        "$penumbra" render "pipelines/$pipeline.json" scenes/colonnade.shot.json --frames 8 --out "out/demo/$pipeline"
    done
    "$penumbra" plan pipelines/fidelityfx.json
    echo "demo: the images are in out/demo"
}

scripts/setup.sh
scripts/build.sh release
mkdir -p out/demo
main_job
