#!/usr/bin/env bash
# Finds SwiftShader, a Vulkan driver on the CPU that is no relative of Mesa's, in Debian's chromium-common, and prints the path of
# its driver manifest: VK_DRIVER_FILES=$(scripts/swiftshader.sh) runs a program on it. Where the package is not installed it
# is unpacked into .cache/swiftshader.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/apt.sh
source "$root/scripts/apt.sh"

installed=/usr/lib/chromium
place="$root/.cache/swiftshader"
manifest="$place/vk_swiftshader_icd.json"

if manifest_holds "$manifest"; then
    echo "$manifest"
    exit 0
fi
if [[ -f $installed/libvk_swiftshader.so && -f $installed/vk_swiftshader_icd.json ]]; then
    mkdir -p "$place"
    write_manifest "$installed/libvk_swiftshader.so" "$installed/vk_swiftshader_icd.json" "$manifest"
    exit 0
fi

command -v apt-get >/dev/null || die "no apt here to fetch chromium-common with"
candidate() { candidate_version chromium-common | grep -v '(none)' || true; }
version=$(candidate)
if [[ -z $version ]] && can_be_root; then
    say "updating the package lists"
    apt_get update >&2 || true
    version=$(candidate)
fi
[[ -n $version ]] || die "apt offers no chromium-common"
unpack_package "$place" "chromium-common=$version"
write_manifest "$(find "$place/unpacked" -name libvk_swiftshader.so -print -quit)" \
    "$(find "$place/unpacked" -name vk_swiftshader_icd.json -print -quit)" "$manifest"
