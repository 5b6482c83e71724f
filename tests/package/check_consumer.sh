#!/bin/sh
# SPDX-License-Identifier: MIT
# Clients in C and C++, built and run as a print driver would: against the installed library, shared
# and static, by find_package and by pkg-config, after the installed tree was moved or with a library
# folder outside the prefix; by add_subdirectory; and from the vendored sources.
set -eu
cmake=$1 build=$2 root=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
src=$root/tests/package/consumer
cp "$src/main.c" "$work/main.cpp"

# The library is built with options under which ccache has most of it from other builds.
export CMAKE_BUILD_TYPE=Release
command -v ninja >/dev/null && export CMAKE_GENERATOR=Ninja
command -v ccache >/dev/null && export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
werror=$(sed -n 's/^LCOR_WERROR:BOOL=/-DLCOR_WERROR=/p' "$build/CMakeCache.txt")

by_cmake() { # NAME, then cmake arguments
    name=$1
    shift
    "$cmake" -S "$src" -B "$work/$name" "$@" >/dev/null
    "$cmake" --build "$work/$name" >/dev/null
    "$work/$name/consumer_c" && "$work/$name/consumer_cpp"
}

by_pkg_config() { # FOLDER of the installation, then options of pkg-config
    PKG_CONFIG_PATH=$(dirname "$(find "$1" -name lcor.pc)")
    export PKG_CONFIG_PATH
    shift
    libdir=$(pkg-config --variable=libdir lcor)
    # shellcheck disable=SC2046 # flags are words
    cc -std=c99 $(pkg-config --cflags lcor) "$src/main.c" -o "$work/pc_c" $(pkg-config "$@" --libs lcor)
    # shellcheck disable=SC2046
    c++ -std=c++11 $(pkg-config --cflags lcor) "$work/main.cpp" -o "$work/pc_cpp" $(pkg-config "$@" --libs lcor)
    LD_LIBRARY_PATH=$libdir "$work/pc_c" && LD_LIBRARY_PATH=$libdir "$work/pc_cpp"
}

# Shared, as built here, and moved after it was installed.
"$cmake" --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"
by_cmake find_shared -DCMAKE_PREFIX_PATH="$work/moved"
by_pkg_config "$work/moved"

# Static, as the Python package has it too, with the library in a folder of its own outside the prefix.
"$cmake" -S "$root" -B "$work/static" -DBUILD_SHARED_LIBS=OFF \
    -DLCOR_BUILD_CALIB=OFF -DLCOR_BUILD_CLI=OFF -DLCOR_BUILD_TESTING=OFF \
    -DCMAKE_INSTALL_PREFIX="$work/prefix" -DCMAKE_INSTALL_LIBDIR="$work/elsewhere/lib" >/dev/null
"$cmake" --build "$work/static" >/dev/null
"$cmake" --install "$work/static" >/dev/null
[ -e "$work/elsewhere/lib/liblcor.a" ] && [ ! -e "$work/prefix/lib" ]
by_cmake find_static -Dlcor_DIR="$work/elsewhere/lib/cmake/lcor"
by_pkg_config "$work/elsewhere" --static

by_cmake subdirectory_static -DLCOR_SUBDIRECTORY="$root"
by_cmake subdirectory_shared -DLCOR_SUBDIRECTORY="$root" "$werror" -DBUILD_SHARED_LIBS=ON

# Vendored: bare sources, one command, no build system, nothing but libm; clients of both languages.
flags="-DLCOR_STATIC -I$root/lib/include"
# shellcheck disable=SC2086
cc -std=c99 -ffp-contract=off $flags -I"$root/lib/src" -shared -fPIC -Wl,-z,defs "$root"/lib/src/*/*.c \
    -o "$work/vendored.so" -lm
# shellcheck disable=SC2086
cc -std=c99 $flags "$src/main.c" "$work/vendored.so" -o "$work/vendored_c" -lm
# shellcheck disable=SC2086
c++ -std=c++11 $flags "$work/main.cpp" "$work/vendored.so" -o "$work/vendored_cpp" -lm
"$work/vendored_c" && "$work/vendored_cpp"
