#!/usr/bin/env bash
# Renders every glTF file (.gltf, .glb, .vrm) of Debian's packages, or below folders, as `penumbra render MODEL` does and prints
# Markdown tables: what came of them by package, which were refused and why, what the program warned of. Fails where one ends
# otherwise than with a picture or with a reason, or takes longer than a minute.
# Usage: scripts/models.sh [FOLDER...]. Without a folder the packages are those that apt-file's index of apt's own sources
# names; each version that can be had is unpacked, not installed, into out/models, and stays there for the next run.
# Settings: PENUMBRA (the program), SIZE, LIMIT (seconds that a file may take).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=scripts/apt.sh
source scripts/apt.sh
program=${PENUMBRA:-build/release/app/penumbra}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Prints PACKAGE=VERSION, one a line.
packages_with_models() {
    mapfile -t missing < <(missing_packages apt-file)
    [[ ${#missing[@]} -eq 0 ]] || install_packages "${missing[@]}" >&2
    apt_get update >&2 # with the index that apt-file asks apt for
    apt-file search --package-only -x '(?i)\.(gltf|glb|vrm)$' | while IFS= read -r package; do
        apt-cache madison "$package" | awk -F ' *[|] *' '!seen[$2]++ { gsub(/ /, "", $1); print $1 "=" $2 }'
    done
}

tried() { # name in the table, folder
    local file code result said
    while IFS= read -r file; do
        code=0
        timeout "${LIMIT:-60}" "$program" render "$file" raw --ground --size "${SIZE:-96x54}" --frames 1 --out "$out/image" \
            >/dev/null 2>"$out/errors" </dev/null || code=$?
        said=$({ grep -v ' triangles, x ' "$out/errors" || true; } | sed -e "s|$file: ||g" -e 's/^warning: //' -e 's/|/\\|/g' |
            cut -c1-200 | paste -sd '~' - | sed 's/~/; /g')
        case $code in
            0) result=rendered ;;
            2) result=refused ;;
            *) result="ended with $code" ;;
        esac
        if [[ $result == refused && -z $said ]]; then result="refused without a reason"; fi
        printf '%s\t%s\t%s\t%s\n' "$1" "${file#"$2"/}" "$result" "$said" >>"$out/results"
        rm -rf "$out/image"
    done < <(find "$2" -type f \( -iname '*.gltf' -o -iname '*.glb' -o -iname '*.vrm' \) | LC_ALL=C sort)
}

: >"$out/results"
for folder in "$@"; do tried "$(basename "$folder")" "${folder%/}"; done
if [[ $# -eq 0 ]]; then
    packages_with_models >"$out/packages"
    while IFS= read -r package; do
        folder=out/models/$package
        [[ -d $folder/unpacked ]] || unpack_package "$folder" "$package" </dev/null
        tried "${package/=/ }" "$folder/unpacked"
    done <"$out/packages"
fi
if [[ ! -s $out/results ]]; then
    say "no glTF file there"
    exit 1
fi

awk -F '\t' '
    # Lines of one package and text are one row, in the order in which they came first.
    function add(kind, text, file,    key) {
        key = $1 " | " text
        if (!((kind, key) in number)) row[kind, ++rows[kind]] = key
        ++number[kind, key]
        names[kind, key] = names[kind, key] (number[kind, key] > 1 ? ", " : "") file
    }
    {
        if (!($1 in files)) package[++packages] = $1
        ++files[$1]
        ++result[$1, $3]
        folders = split($2, folder, "/")
        name = (folders > 1 ? folder[folders - 1] "/" : "") folder[folders]
        if ($3 != "rendered") add("bad", ($3 == "refused" ? $4 : "**" $3 "** " $4), name)
        else if ($4 != "") {
            ++warned[$1]
            parts = split($4, part, /; /)
            for (i = 1; i <= parts; ++i) {
                sub(/^[0-9]+ /, "", part[i]) # how many of something there were differs from file to file
                if (!(($1, $2, part[i]) in told)) add("warning", part[i], name)
                told[$1, $2, part[i]] = 1
            }
        }
    }
    END {
        print "| package | files | rendered | of these with a warning | refused, with a reason | anything else |\n|---|---|---|---|---|---|"
        for (i = 1; i <= packages; ++i) {
            p = package[i]
            other = files[p] - result[p, "rendered"] - result[p, "refused"]
            failed += other
            print "| " p " | " files[p] " | " result[p, "rendered"] + 0 " | " warned[p] + 0 " | " result[p, "refused"] + 0 " | " other " |"
        }
        if (rows["bad"]) print "\n| package | not rendered, because | files |\n|---|---|---|"
        for (i = 1; i <= rows["bad"]; ++i) print "| " row["bad", i] " | " names["bad", row["bad", i]] " |"
        if (rows["warning"]) print "\n| package | rendered, with the warning | files |\n|---|---|---|"
        for (i = 1; i <= rows["warning"]; ++i) print "| " row["warning", i] " | " number["warning", row["warning", i]] " |"
        exit failed > 0
    }' "$out/results"
