#!/usr/bin/env bash
# Prints the table of docs/scenes.md, measured anew. Usage: scripts/scene_facts.sh PRESET
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${1:?usage: scripts/scene_facts.sh PRESET}
"scripts/scenes.sh" "$preset" >&2
exec "build/$preset/host/penumbra_scene_facts" scenes/{cards,colonnade,engine,fan,heightfield,lamp,trees}.shot.json
