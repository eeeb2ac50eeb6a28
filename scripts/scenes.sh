#!/usr/bin/env bash
# Puts the models that the shots in scenes/ look at in place: the project's own are generated (always the same bytes), the
# engine comes from Debian's package assimp-testmodels. Usage: scripts/scenes.sh PRESET
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${1:?usage: scripts/scenes.sh PRESET}

for name in cards chrome colonnade fan heightfield interior lamp polished stained_glass street trees; do
    if [[ ! -f scenes/$name.glb || build/$preset/host/penumbra_make_scenes -nt scenes/$name.glb ]]; then
        echo "scenes: generating the project's own models"
        "build/$preset/host/penumbra_make_scenes" scenes
        break
    fi
done

engine=/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb
if [[ ! -f scenes/2CylinderEngine.glb ]]; then
    [[ -f $engine ]] || { echo "scenes: $engine is missing; it belongs to the package assimp-testmodels" >&2; exit 1; }
    echo "scenes: copying 2CylinderEngine.glb from assimp-testmodels"
    cp "$engine" scenes/
fi
