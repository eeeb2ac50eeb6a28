#!/usr/bin/env bash
# scripts/apt.sh on made-up systems (apt and dpkg are functions here, /etc is a folder of ours), and test.sh with made-up
# scripts, drivers and ctest. Exits 1 on any failure.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/apt.sh
source "$root/scripts/apt.sh"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
checks=0 failures=0
expect() { # what, got, wanted
    checks=$((checks + 1))
    [[ $2 == "$3" ]] && return
    failures=$((failures + 1))
    printf 'FAILED %s\n--- got\n%s\n--- wanted\n%s\n' "$1" "$2" "$3" >&2
}

# What the made-up apt does: an update fails for a source file that holds one of these words; the candidate is ...
failing=""
candidate=""
as_root() { "$@"; }
apt-get() {
    local argument
    for argument in "$@"; do
        if [[ $argument == Dir::Etc::sourcelist=* && -n $failing ]]; then
            ! grep -qE "$failing" "${argument#*=}" || return 100
        fi
    done
}
apt-cache() { printf 'mesa-vulkan-drivers:\n  Installed: (none)\n  Candidate: %s\n' "$candidate"; }
dpkg-query() { printf 'installed cmake\nnot-installed ccache\nconfig-files ninja-build\n'; return 1; }

system() { # name: an empty made-up system
    made=$work/$1
    mkdir -p "$made/etc/apt/sources.list.d"
}
candidates() { # all candidates of the system, in order
    local folder
    folder=$(mktemp -d -p "$work")
    write_candidates "$made" "$folder"
    (cd "$folder" && find . -type f -printf '%f\n' | sort -n | while read -r file; do echo "== $file"; cat "$file"; done)
}
own_files() { (cd "$made/etc/apt" && find . -name 'penumbra*' | sort | tr '\n' ' '); }

expect "missing packages" "$(missing_packages cmake ccache ninja-build g++ | tr '\n' ' ')" "ccache ninja-build g++ "

system deb822
cat >"$made/etc/apt/sources.list.d/debian.sources" <<'END'
# The mirror.
Types: deb deb-src
URIs: http://own.example/main
Suites: bookworm
 bookworm-updates
Components: main contrib
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Types: deb
URIs: http://own.example/security
Suites: bookworm-security
Components: main

Enabled: no
Types: deb
URIs: http://switched-off.example/debian
Suites: bookworm
Components: main

Types: deb
URIs: http://third-party.example
Suites: bookworm
Components: stable
END
expect "deb822 entry" "$(candidates)" "== 1.sources
URIs: http://own.example/main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
Types: deb
Suites: bookworm-backports
Components: main"

failing="" candidate=25.0.7-2~bpo12+1
expect "backports to be had" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" yes
expect "its files" "$(own_files)" "./preferences.d/penumbra-mesa ./sources.list.d/penumbra-backports.sources "
expect "a second time" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" yes
expect "still one entry" "$(candidates | grep -c ==)" 1

failing=backports
expect "backports unreachable" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" no
expect "nothing left behind" "$(own_files)" ""

failing="" candidate=22.3.6-1+deb12u2
expect "backports without a newer Mesa" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" no
expect "nothing left behind either" "$(own_files)" ""

system oneline
cat >"$made/etc/apt/sources.list" <<'END'
# deb http://commented.example bookworm main
deb [ arch=amd64 signed-by=/usr/share/keyrings/a.gpg ] http://third-party.example/x bookworm main # theirs
deb http://own.example/main bookworm main contrib
deb-src http://own.example/main bookworm main
deb http://own.example/main bookworm-updates main
deb http://own.example/main bookworm main non-free-firmware
END
expect "one-line entries" "$(candidates)" "== 1.list
deb [ arch=amd64 signed-by=/usr/share/keyrings/a.gpg ] http://third-party.example/x bookworm-backports main
== 2.list
deb http://own.example/main bookworm-backports main"
failing=third-party candidate=25.0.7-2~bpo12+1
expect "the second entry serves" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" yes
expect "and is kept" "$(cat "$made/etc/apt/sources.list.d/penumbra-backports.list")" \
    "deb http://own.example/main bookworm-backports main"

system present
echo "deb http://own.example/main bookworm-backports main" >"$made/etc/apt/sources.list.d/own.list"
failing=""
expect "backports are there already" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" yes
expect "so only the pin is ours" "$(own_files)" "./preferences.d/penumbra-mesa "

system other
echo "deb http://own.example/ubuntu noble main" >"$made/etc/apt/sources.list"
expect "another distribution" "$(enable_backports "$made" 2>/dev/null && echo yes || echo no)" no
expect "is left alone" "$(own_files)" ""

tree="$work/a tree"
mkdir -p "$tree/scripts" "$tree/bin"
cp "$root/test.sh" "$tree"
# shellcheck disable=SC2016 # what the made-up scripts ask
printf '#!/bin/sh\necho "$0"\n' | tee "$tree"/scripts/{setup,build,scenes,mesa22,swiftshader}.sh >/dev/null
printf '#!/bin/sh\necho "-R <regex>, --tests-regex <regex>"\n' >"$tree/bin/ctest"
# shellcheck disable=SC2016
printf '#!/bin/sh\nprintf %%s "$MESA"\n' >"$tree/bin/dpkg-query"
chmod +x "$tree"/scripts/* "$tree"/bin/*
ended() { # settings, then arguments of test.sh: its exit code
    local code=0
    env -u PENUMBRA_ALL_DRIVERS PATH="$tree/bin:$PATH" "$1" "$2" "$tree/test.sh" "${@:3}" >"$work/said" 2>&1 || code=$?
    echo $code
}
expect "two versions of Mesa" "$(ended MESA=25.0.7-2 PENUMBRA_ALL_DRIVERS=1)" 0
expect "the older one is run" "$(grep -c 'on Mesa 22.3.6' "$work/said")" 1
expect "the older one alone" "$(ended MESA=22.3.6-1 A=1)" 0
expect "the older one alone, where all are asked for" "$(ended MESA=22.3.6-1 PENUMBRA_ALL_DRIVERS=1)" 1
expect "everything" "$(ended MESA=25.0.7-2 A=1 --all)" 0
expect "some" "$(ended MESA=25.0.7-2 A=1 -R X)" 0
expect "everything, and some" "$(ended MESA=25.0.7-2 A=1 --all -R X)" 2
expect "and the other way round" "$(ended MESA=25.0.7-2 A=1 -R X --all)" 2
expect "no option of anybody's" "$(ended MESA=25.0.7-2 A=1 --nosuch)" 2

echo "setup: $((checks - failures)) of $checks checks passed"
[[ $failures -eq 0 ]]
