#!/usr/bin/env bash
# Formats our C++ with clang-format 14: `scripts/format.sh`; with --check it changes nothing, shows what it would change
# and fails if that is anything. Other versions of clang-format format differently.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

formatter=$(command -v clang-format-14 || command -v clang-format || true)
if [[ -z $formatter ]] || ! "$formatter" --version | grep -q 'version 14\.'; then
    echo "format: needs clang-format 14; scripts/setup.sh --dev installs it" >&2
    exit 1
fi

mapfile -d '' -t files < <(find include capi graph nodes host app tests examples \( -name '*.h' -o -name '*.cpp' \) -print0 2>/dev/null)
[[ ${#files[@]} -gt 0 ]] || { echo "format: found no source files" >&2; exit 1; }
case ${1:-} in
    --check) "$formatter" --dry-run --Werror "${files[@]}" ;;
    "") "$formatter" -i "${files[@]}" ;;
    *) echo "usage: scripts/format.sh [--check]" >&2; exit 1 ;;
esac
