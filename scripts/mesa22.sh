#!/usr/bin/env bash
# Unpacks Debian 12's own lavapipe (Mesa 22.3.6) beside the installed one, into .cache/mesa22, and prints the path of its
# driver manifest: VK_DRIVER_FILES=$(scripts/mesa22.sh) runs a program on it. Nothing is installed.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/apt.sh
source "$root/scripts/apt.sh"

place="$root/.cache/mesa22"
manifest="$place/lvp_icd.json"

# The manifest holds an absolute path, which a moved checkout would break.
if [[ -f $manifest && -f $(sed -n 's/.*"library_path": *"\([^"]*\)".*/\1/p' "$manifest") ]]; then
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

rm -rf "$place"
mkdir -p "$place"
say "fetching mesa-vulkan-drivers $version"
# apt would drop to a user who cannot write here; the package's signature is checked all the same.
(cd "$place" && apt-get -q -o APT::Sandbox::User="$(id -un)" download "mesa-vulkan-drivers=$version" >&2) ||
    die "could not download mesa-vulkan-drivers $version"
dpkg -x "$place"/mesa-vulkan-drivers_*.deb "$place/unpacked"

library=$(find "$place/unpacked" -name libvulkan_lvp.so -print -quit)
stock=$(find "$place/unpacked" -name 'lvp_icd*.json' -print -quit)
[[ -n $library && -n $stock ]] || die "the package holds no lavapipe"
absent=$(ldd "$library" | awk '/not found/ { printf " %s", $1 }')
[[ -z $absent ]] || die "libraries that Mesa 22.3.6 needs are not installed:$absent"
sed "s|\"library_path\": *\"[^\"]*\"|\"library_path\": \"$library\"|" "$stock" >"$manifest"
echo "$manifest"
