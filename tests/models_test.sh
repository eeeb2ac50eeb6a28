#!/usr/bin/env bash
# scripts/models.sh on a made-up program, which does with each file what its name says. Exits 1 on any failure.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cat >"$work/program" <<'END'
#!/usr/bin/env bash
case $2 in
    *drawn* | *DRAWN*) exit 0 ;;
    *warned*) echo "$2: 5780 triangles, x 0 .. 1" >&2; echo "warning: $2: 3 odd things dropped" >&2; exit 0 ;;
    *refused*) echo "$2: is too old | for us" >&2; exit 2 ;;
    *silent*) exit 2 ;;
    *killed*) kill -SEGV $$ ;;
    *slow*) sleep 30 ;;
esac
END
chmod +x "$work/program"

failures=0
tried() { # wanted exit code, files
    local code=0 wanted=$1
    shift
    rm -rf "$work/models"
    mkdir -p "$work/models/a"
    for name in "$@"; do : >"$work/models/a/$name"; done
    PENUMBRA=$work/program LIMIT=2 "$root/scripts/models.sh" "$work/models" >"$work/table" 2>/dev/null || code=$?
    [[ $code == "$wanted" ]] && return
    failures=$((failures + 1))
    printf 'FAILED %s: ended with %s, wanted %s\n' "$*" "$code" "$wanted" >&2
}
holds() { # line
    grep -qxF -- "$1" "$work/table" && return
    failures=$((failures + 1))
    printf 'FAILED there is no line\n%s\nin\n%s\n' "$1" "$(cat "$work/table")" >&2
}

tried 0 drawn.gltf DRAWN.GLB drawn.vrm.txt warned.glb warned2.vrm refused.gltf refused2.glb
holds "| models | 6 | 4 | 2 | 2 | 0 |"
holds "| models | is too old \\| for us | a/refused.gltf, a/refused2.glb |"
holds "| models | odd things dropped | 2 |"
tried 1 silent.gltf drawn.gltf
holds "| models | **refused without a reason**  | a/silent.gltf |"
tried 1 killed.gltf
holds "| models | **ended with 139**  | a/killed.gltf |"
tried 1 slow.gltf
holds "| models | **ended with 124**  | a/slow.gltf |"
tried 1 nothing.txt
exit $((failures > 0))
