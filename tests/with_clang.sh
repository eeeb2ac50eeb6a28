#!/bin/sh
# with_clang.sh RUNNER CLANG COMPILER ARGUMENTS...: CLANG in the configured compiler's place, started by RUNNER (one argument,
# a word or more). The launcher of targets that take what g++ lacks (sanitized.cmake).
set -eu
runner=$1 clang=$2
shift 3
# shellcheck disable=SC2086 # its words
exec $runner "$clang" "$@"
