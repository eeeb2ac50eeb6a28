#!/usr/bin/env bash
# What cmake --install gives is enough to build and run examples/ with: static, as the build folder has it, and shared, from a
# build that looks for nothing but what the libraries need. Arguments: the build folder, a folder to work in (kept, so that the
# shared build is made once), the program record_inputs, the compiler's launcher or nothing. Exits 1 on any failure.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$1 work=$2 record=$3 launcher=${4:-}
checks=0 failures=0
expect() { # what, command...
    local what=$1
    shift
    checks=$((checks + 1))
    if ! "$@" >"$work/now" 2>&1; then
        failures=$((failures + 1))
        printf 'FAILED %s: %s\n' "$what" "$*" >&2
        cat "$work/now" >&2
    fi
    mv "$work/now" "$work/log" # what the next one may look at
}
expect_not() { expect "$1" bash -c '! "$@"' bash "${@:2}"; }

# The examples, from a copy that no folder of the sources is above.
examples_of() { # prefix, name, has glsl?
    local prefix=$1 out=$work/$2
    rm -rf "$out"
    cp -r "$root/examples" "$out"
    expect "$2: configure" cmake -G Ninja -S "$out" -B "$out/build" -DCMAKE_PREFIX_PATH="$prefix" \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" -DCMAKE_C_COMPILER_LAUNCHER="$launcher"
    expect "$2: build" cmake --build "$out/build"
    expect "$2: plan" "$out/build/plan"
    expect "$2: the plan has shaders" grep -qE '[1-9][0-9]{3} bytes of SPIR-V' "$work/log"
    expect_not "$2: a pipeline that is not there" "$out/build/plan" nosuch.json
    expect "$2: bvh" "$out/build/bvh"
    if [[ $3 == glsl ]]; then
        expect "$2: a user's node is compiled" "$out/build/invert"
        expect "$2: and includes penumbra's own GLSL" grep -q common/pixels.glsl "$out/invert/nodes/invert.comp"
        expect "$2: without the sources" bash -c "! grep -aoF '$root/shaders' '$out/build/invert'"
        # GLSL that is not there is named, which says that the one above was looked for.
        sed -i s/pixels.glsl/pixls.glsl/ "$out/invert/nodes/invert.comp"
        expect_not "$2: an include that is not there" "$out/build/invert"
        expect "$2: is named" grep -q pixls.glsl "$work/log"
    else
        expect "$2: no invert without glsl" test ! -e "$out/build/invert"
    fi
}

# Hosts that render give what the standalone program gives, bit for bit, and validation has nothing to say (they exit 1).
images_of() { # prefix, name
    local pipeline host file
    for pipeline in denoise shadows hybrid_shadows; do
        for host in minimal minimal_c engine; do
            expect "$2: $host runs $pipeline" "$work/$2/build/$host" "$1/share/penumbra/pipelines/$pipeline.json" 96 54 4 "$work/inputs/$pipeline"
            for file in "$work/inputs/$pipeline"/*/visibility.out; do
                expect "$2: $host gives the program's image of $pipeline" cmp "$file" "${file%.out}.$host"
                rm -f "${file%.out}.$host"
            done
        done
    done
    # A world of the host's own, with rays of its own: other hosts make the same of what it wrote.
    rm -rf "$work/world"
    expect "$2: denoise, with rays of its own" "$work/$2/build/denoise" "$1/share/penumbra/pipelines/denoise.json" 96 54 12 "$work/world"
    expect "$2: minimal, with those rays" "$work/$2/build/minimal" "$1/share/penumbra/pipelines/denoise.json" 96 54 12 "$work/world"
    for file in "$work/world"/*/visibility.denoise; do
        expect "$2: the same image of that world" cmp "$file" "${file%.denoise}.minimal"
    done
    expect_not "$2: the world is no constant" cmp "$work/world/3/visibility.denoise" "$work/world/4/visibility.denoise"
    # A host that says the wrong layout is found out: what found nothing above was listening.
    for file in minimal/main.cpp minimal_c/main.c; do
        host=${file%%/*}
        sed -i 's/layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL/layout_before = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL/' "$work/$2/$file"
        expect "$2: build $host with a mistake" cmake --build "$work/$2/build" --target "$host"
        expect_not "$2: validation notices the mistake of $host" "$work/$2/build/$host" \
            "$1/share/penumbra/pipelines/shadows.json" 96 54 1 "$work/inputs/shadows"
    done
    expect_not "$2: an input that is missing" "$work/$2/build/minimal" "$1/share/penumbra/pipelines/shadows.json" 96 54 1 "$work"
}

mkdir -p "$work"
for pipeline in denoise shadows hybrid_shadows; do
    rm -rf "$work/inputs/$pipeline"
    expect "inputs of $pipeline" "$record" $pipeline 96 54 4 "$work/inputs/$pipeline"
    expect "frames differ" bash -c "! cmp -s '$work/inputs/$pipeline/1/visibility.out' '$work/inputs/$pipeline/3/visibility.out'"
done
prefix=$work/prefix_static
rm -rf "$prefix"
expect "install" cmake --install "$build" --prefix "$work/made"
rm -rf "$prefix" && mv "$work/made" "$prefix" # a package may be moved
for file in include/penumbra/graph.h include/penumbra/penumbra.h include/penumbra/version.h include/penumbra/blocks.h include/penumbra/bvh.h \
    include/penumbra/penumbra_bvh.h include/penumbra/frame_block.glsl share/penumbra/pipelines/hybrid_shadows.json \
    share/penumbra/pipelines/pipeline.schema.json share/penumbra/nodes/node.schema.json \
    share/penumbra/nodes/visibility/trace.json share/penumbra/shaders/common/pixels.glsl share/penumbra/shaders/penumbra/frame_block.glsl; do
    expect "is installed" test -f "$prefix/$file"
done
expect "headers are the public ones" bash -c "[[ -z \$(ls '$prefix/include' | grep -vx penumbra) ]]"
expect "no path of this machine is in the package" bash -c "! grep -rlF -e '$root' -e '$work/made' '$prefix'/lib*/cmake '$prefix'/lib*/pkgconfig"
examples_of "$prefix" examples_static glsl
images_of "$prefix" examples_static

# pkg-config, with the linker's own words.
pc=$(dirname "$(find "$prefix" -name penumbra.pc)")
export PKG_CONFIG_PATH=$pc
expect "pkg-config knows its version" pkg-config --exact-version=0.1.0 penumbra
expect "pkg-config, static" bash -c "pkg-config --static --cflags --libs penumbra | xargs g++ -std=c++20 \
    -DPIPELINES='\"$prefix/share/penumbra/pipelines\"' '$root/examples/plan/main.cpp' -o '$work/plan_pc' && '$work/plan_pc'"
expect "pkg-config, static, users' nodes" bash -c "pkg-config --static --cflags --libs penumbra-glsl | xargs g++ -std=c++20 \
    -DPIPELINES='\"$prefix/share/penumbra/pipelines\"' -DEXAMPLE='\"$root/examples/invert\"' '$root/examples/invert/main.cpp' \
    -o '$work/invert_pc' && '$work/invert_pc'"
# C, with nothing but the builder of trees.
cat >"$work/tree.c" <<'END'
#include <penumbra/penumbra_bvh.h>
int main(void) {
    const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 0, 1};
    penumbra_bvh_request request = {sizeof request, 1, 0, 0, 0};
    penumbra_bvh_info info = {sizeof info, 0, 0, 0, 0, 0, 0, 0, 0};
    penumbra_bvh* bvh;
    request.triangles = triangle;
    if (penumbra_bvh_create(&request, &bvh, 0) || penumbra_bvh_read(bvh, &info, 0)) return 1;
    penumbra_bvh_destroy(bvh);
    return info.leaf_count != 1;
}
END
expect "pkg-config, static, a tree in C" bash -c "gcc -std=c99 -Wall -Wextra -pedantic -Werror '$work/tree.c' -o '$work/tree_pc' \
    \$(pkg-config --static --cflags --libs penumbra-bvh) && '$work/tree_pc'"

# A plugin is a shared library, whatever it links.
for library in penumbra penumbra_bvh penumbra_glsl; do
    expect "$library goes into a shared library" g++ -shared -o "$work/plugin.so" \
        -Wl,--whole-archive "${pc%/*}/lib$library.a" -Wl,--no-whole-archive
done

# The builder of trees alone needs neither Vulkan nor fmt, whatever the project calls its variables.
rm -rf "$work/trees" && mkdir "$work/trees"
cat >"$work/trees/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(trees LANGUAGES CXX)
set(bvh ON)
find_package(penumbra REQUIRED COMPONENTS bvh)
add_executable(trees "$root/examples/bvh/main.cpp")
target_link_libraries(trees PRIVATE penumbra::bvh)
END
expect "COMPONENTS bvh: configure" cmake -G Ninja -S "$work/trees" -B "$work/trees/build" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_DISABLE_FIND_PACKAGE_Vulkan=ON -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON
expect "COMPONENTS bvh: build" cmake --build "$work/trees/build"

# Shared, without the program, run-time GLSL, and what only they need.
shared=$work/build_shared
hide=()
for package in OpenEXR TinyGLTF CLI11 GTest embree valijson; do hide+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
nodes=$(sed -n 's/^PENUMBRA_SHADER_CACHE:PATH=//p' "$build/CMakeCache.txt") # the same ones
expect "shared: configure" cmake -G Ninja -S "$root" -B "$shared" -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON \
    -DPENUMBRA_BUILD_PROGRAM=OFF -DPENUMBRA_TESTS=OFF -DPENUMBRA_GLSL=OFF -DPENUMBRA_SHADER_CACHE="$nodes" "${hide[@]}"
expect "shared: build" cmake --build "$shared"
prefix=$work/prefix_shared
rm -rf "$prefix"
expect "shared: install" cmake --install "$shared" --prefix "$prefix"
library=$(find "$prefix" -name 'libpenumbra.so')
expect "soname" bash -c "readelf -d '$library' | grep -q 'soname: .libpenumbra.so.0.1.'"
# Everything that is shown is penumbra's, or a template of the standard library's that was made here.
expect "what is not public is hidden" bash -c "nm -DC --defined-only '$library' | cut -d' ' -f3- |
    grep -vE '(^|[ :&*<(])(penumbra|std)::|^penumbra_' | tee /dev/stderr | wc -l | grep -qx 0"
expect_not "an inner function is hidden" bash -c "nm -DC --defined-only '$library' | grep -q 'penumbra::place_barriers'"
expect_not "no embedded file is shown" bash -c "nm -D --defined-only '$library' | grep -q node_files"
expect_not "glslang is not linked" bash -c "readelf -d '$library' | grep -qiE 'glslang|spirv'"
expect_not "no Vulkan function is linked" bash -c "nm -D --undefined-only '$library' | grep -q ' vk[A-Z]'"
examples_of "$prefix" examples_shared none
images_of "$prefix" examples_shared

# Who asks for what was not built is told so.
cat >"$work/asks.cmake" <<'END'
cmake_minimum_required(VERSION 3.25)
project(asks LANGUAGES C CXX)
find_package(penumbra REQUIRED COMPONENTS glsl)
END
rm -rf "$work/asks" && mkdir "$work/asks" && mv "$work/asks.cmake" "$work/asks/CMakeLists.txt"
expect_not "asking for glsl" cmake -G Ninja -S "$work/asks" -B "$work/asks/build" -DCMAKE_PREFIX_PATH="$prefix"
expect "says what is missing" grep -q "built with PENUMBRA_GLSL=OFF" "$work/log"

# A folder of somebody's project, who puts all libraries into one place and has a launcher.
rm -rf "$work/inside" && mkdir "$work/inside"
cat >"$work/inside/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(inside LANGUAGES CXX)
add_subdirectory("$root" penumbra)
add_executable(inside "$root/examples/plan/main.cpp")
target_compile_definitions(inside PRIVATE PIPELINES="$root/pipelines")
target_link_libraries(inside PRIVATE penumbra::glsl penumbra::bvh)
END
expect "add_subdirectory: configure" cmake -G Ninja -S "$work/inside" -B "$work/inside/build" -DPENUMBRA_GLSL=ON \
    -DCMAKE_ARCHIVE_OUTPUT_DIRECTORY="$work/inside/lib" -DCMAKE_CXX_COMPILER_LAUNCHER=env "${hide[@]}"
expect "add_subdirectory: could be built" ninja -C "$work/inside/build" -n
expect "add_subdirectory: the builder's launcher" grep -qw 'command = env' "$work/inside/build/CMakeFiles/rules.ninja"
expect_not "add_subdirectory: and no other" grep -qw ccache "$work/inside/build/CMakeFiles/rules.ninja"
expect "add_subdirectory: no program, no tests" bash -c \
    "! ninja -C '$work/inside/build' -t targets all | grep -qE 'penumbra_(app|host|models|test)|make_scenes'"

echo "install: $((checks - failures)) of $checks checks passed"
[[ $failures -eq 0 ]]
