#!/usr/bin/env bash
# Installs what building and running penumbra takes, on Debian 12 or a relative: `scripts/setup.sh`; with --test also what the
# tests and the scripts that measure take; with --dev also ccache, clang-format, clang-tidy and shellcheck. Does nothing,
# quickly, where all is there.
# The software Vulkan driver comes from bookworm-backports (Mesa 25) where that can be had, else from the release
# (Mesa 22.3.6); both are tested. PENUMBRA_STOCK_MESA=1 leaves the system's Mesa alone; PENUMBRA_SKIP_SETUP=1 installs
# nothing, for systems without apt that have all this already.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=scripts/apt.sh
source "$root/scripts/apt.sh"

packages=(
    g++ cmake ninja-build
    libvulkan-dev
    glslang-dev glslang-tools # the library's CMake package insists on the tools
    spirv-tools               # libraries, CMake package and spirv-val in one
    libglm-dev nlohmann-json3-dev libfmt-dev libcli11-dev
    libopenexr-dev libpng-dev libjpeg-dev libtinygltf-dev libstb-dev assimp-testmodels
    libdraco-dev libmeshoptimizer-dev # compressed meshes of glTF files
    libwebp-dev                       # the report's pictures that move
    libglfw3-dev libimgui-dev         # the window of penumbra view
)
if [[ ${1:-} == --test || ${1:-} == --dev ]]; then
    packages+=(
        libgtest-dev vulkan-validationlayers
        pkg-config                    # asks for what was installed
        libembree-dev libvalijson-dev # judges of rays and of JSON Schemas
        chromium                      # opens the report's page, brings SwiftShader (swiftshader.sh)
        python3                       # scripts that compare
        xvfb xdotool                  # a screen and a hand for penumbra view
        clang-14 libclang-rt-14-dev   # what is fuzzed (tests/sanitized.cmake)
    )
fi
[[ ${1:-} == --dev ]] && packages+=(ccache clang-format-14 clang-tidy-14 shellcheck)
driver="mesa-vulkan-drivers" # lavapipe, and RADV for penumbra statics on null hardware

if [[ ${PENUMBRA_SKIP_SETUP:-} == 1 ]]; then
    say "PENUMBRA_SKIP_SETUP=1: going on with what the system has"
    exit 0
fi
if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    die "no apt here. Install what these Debian packages hold, then set PENUMBRA_SKIP_SETUP=1:" \
        "${packages[*]}, and a Vulkan 1.3 driver such as $driver"
fi

mapfile -t missing < <(missing_packages "${packages[@]}")
mesa=$(installed_version "$driver")
# Written when backports could not be had, so that later runs do not try again each time.
no_backports="$root/.cache/no-backports"

want_newer=no
if [[ ${PENUMBRA_STOCK_MESA:-} != 1 && ! -e $no_backports ]] && ! is_new_mesa "$mesa"; then want_newer=yes; fi

if [[ ${#missing[@]} -eq 0 && -n $mesa && $want_newer == no ]]; then
    say "nothing to install; $driver is $mesa"
    exit 0
fi

[[ -n $mesa ]] || missing_driver=" $driver"
if ! can_be_root; then
    [[ ${#missing[@]} -eq 0 && -n $mesa ]] ||
        die "missing: ${missing[*]}${missing_driver:-}. Not root and no sudo: install them and run this again"
    say "nothing is missing; $driver stays $mesa, since installing a newer one takes root"
    exit 0
fi

export DEBIAN_FRONTEND=noninteractive
say "updating the package lists"
apt_get update || die "apt-get update failed. Missing: ${missing[*]}${missing_driver:-}"
if [[ ${#missing[@]} -gt 0 ]]; then
    say "installing ${missing[*]}"
    install_packages "${missing[@]}" || die "could not install all of: ${missing[*]}"
fi

if [[ $want_newer == yes ]]; then
    say "looking for a newer $driver in bookworm-backports"
    if enable_backports "" && install_packages "$driver"; then
        say "installed $driver $(installed_version "$driver")"
    else
        remove_backports ""
        mkdir -p "$root/.cache"
        printf 'Remove this file to let scripts/setup.sh look for a newer Mesa in bookworm-backports again.\n' >"$no_backports"
        say "no newer $driver to be had from bookworm-backports: using the release's (remove $no_backports to try again)"
    fi
fi
if [[ -z $(installed_version "$driver") ]]; then
    say "installing the release's $driver"
    install_packages "$driver" || die "could not install $driver"
fi

mapfile -t missing < <(missing_packages "${packages[@]}" "$driver")
[[ ${#missing[@]} -eq 0 ]] || die "still missing after the installation: ${missing[*]}"
say "all is installed; $driver is $(installed_version "$driver")"
