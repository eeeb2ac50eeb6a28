#!/usr/bin/env bash
# Unpacks Debian 12's own lavapipe (Mesa 22.3.6) beside the installed one, into .cache/mesa22, and prints the path of its
# driver manifest: VK_DRIVER_FILES=$(scripts/mesa22.sh) runs a program on it. Nothing is installed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/apt.sh
source "$root/scripts/apt.sh"

place="$root/.cache/mesa22"
manifest="$place/lvp_icd.json"

if manifest_holds "$manifest"; then
    echo "$manifest"
    exit 0
fi

command -v apt-get >/dev/null || die "no apt here to fetch mesa-vulkan-drivers 22.3.6 with"
release_version() { apt-cache madison mesa-vulkan-drivers | awk '$3 ~ /^22\.3\.6/ { print $3; exit }'; }
version=$(release_version)
if [[ -z $version ]] && can_be_root; then
    say "updating the package lists"
    apt_get update >&2 || true
    version=$(release_version)
fi
[[ -n $version ]] || die "apt offers no mesa-vulkan-drivers 22.3.6 (lists missing, or not Debian 12)"

unpack_package "$place" "mesa-vulkan-drivers=$version"
write_manifest "$(find "$place/unpacked" -name libvulkan_lvp.so -print -quit)" \
    "$(find "$place/unpacked" -name 'lvp_icd*.json' -print -quit)" "$manifest"
