#!/usr/bin/env bash
# Renders every glTF file below a folder as `penumbra render MODEL` does and prints a Markdown table: what came of each, and
# what the program said. Fails where one ends otherwise than with a picture or with a reason, or takes longer than a minute.
# Usage: scripts/models.sh [FOLDER = /usr/share/assimp/models]. Settings: PENUMBRA (the program), SIZE.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${PENUMBRA:-build/release/app/penumbra}
folder=${1:-/usr/share/assimp/models}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

echo "| file | result | what was said |"
echo "|---|---|---|"
bad=0
while IFS= read -r file; do
    code=0
    timeout 60 "$program" render "$file" raw --ground --size "${SIZE:-96x54}" --frames 1 --out "$out/image" \
        >"$out/said" 2>"$out/errors" || code=$?
    case $code in
        0) result=rendered ;;
        2) result=refused ;;
        *) result="**ended with $code**"; bad=1 ;;
    esac
    if [[ $code == 2 && ! -s $out/errors ]]; then bad=1; fi
    said=$({ grep -v ' triangles, x ' "$out/errors" || true; } | sed -e "s|$file: ||g" -e 's/^warning: //' -e 's/|/\\|/g' | cut -c1-200 |
        paste -sd '~' - | sed 's/~/; /g')
    echo "| ${file#"$folder"/} | $result | $said |"
    rm -rf "$out/image"
done < <(find "$folder" \( -iname '*.gltf' -o -iname '*.glb' \) | LC_ALL=C sort)
exit $bad
