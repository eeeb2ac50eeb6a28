#!/usr/bin/env bash
# One line per image that the shipped pipelines make of the shipped shots: what to compare before and after a change that is to
# change none. Usage: scripts/image_hashes.sh >before.txt; the driver is whatever VK_DRIVER_FILES says. Settings: PENUMBRA (the
# program), PIPELINES, SHOTS, SIZE, FRAMES.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${PENUMBRA:-build/release/app/penumbra}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# denoise*.json want a host's own rays, reference.json is what `penumbra reference` runs.
for pipeline in ${PIPELINES:-$(ls pipelines | sed -n 's/\.json$//p' | grep -vE '^(pipeline\.schema|denoise.*|reference)$')}; do
    for shot in ${SHOTS:-cards colonnade engine fan heightfield lamp trees}; do
        "$program" render "pipelines/$pipeline.json" --shot "scenes/$shot.shot.json" --size "${SIZE:-192x108}" \
            --frames "${FRAMES:-0..5}" --out "$out" >/dev/null
        (cd "$out" && sha256sum ./*.exr) | while read -r hash file; do echo "$pipeline $shot ${file#./} $hash"; done
        rm -rf "${out:?}"/*
    done
done
