#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs the build into a stage, moves the stage, and builds and runs clients in C and C++ there:
# by find_package, by pkg-config, by add_subdirectory (static) and from the vendored sources.
set -eu
cmake=$1 build=$2 root=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
src=$root/tests/package/consumer

"$cmake" --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/stage" # what is installed can be moved

client() { # NAME, then cmake arguments
    name=$1
    shift
    "$cmake" -S "$src" -B "$work/$name" "$@" >/dev/null
    "$cmake" --build "$work/$name" >/dev/null
    "$work/$name/consumer_c" && "$work/$name/consumer_cpp"
}
client find_package -DCMAKE_PREFIX_PATH="$work/stage"
client add_subdirectory -DLCOR_SUBDIRECTORY="$root"

PKG_CONFIG_PATH=$(dirname "$(find "$work/stage" -name lcor.pc)")
export PKG_CONFIG_PATH
libdir=$(pkg-config --variable=libdir lcor)
cc -std=c99 $(pkg-config --cflags lcor) "$src/main.c" -o "$work/pc" $(pkg-config --libs lcor) -lm
LD_LIBRARY_PATH=$libdir "$work/pc"

cc -std=c99 -O1 -ffp-contract=off -DLCOR_STATIC -I"$root/lib/include" -I"$root/lib/src" \
    "$src/main.c" "$root"/lib/src/*/*.c -o "$work/vendored" -lm
"$work/vendored"
