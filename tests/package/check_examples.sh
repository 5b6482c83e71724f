#!/bin/sh
# SPDX-License-Identifier: MIT
# The C examples build as their comments say, against the installed library, and do what they say.
set -eu
cmake=$1 build=$2 root=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$cmake" --install "$build" --prefix "$work/stage" >/dev/null
PKG_CONFIG_PATH=$(dirname "$(find "$work/stage" -name lcor.pc)")
export PKG_CONFIG_PATH
LD_LIBRARY_PATH=$(pkg-config --variable=libdir lcor)
export LD_LIBRARY_PATH

example() { # NAME, then packages
    name=$1
    shift
    # shellcheck disable=SC2046 # flags are words
    cc -std=c99 -Wall -Wextra -Werror -Wno-deprecated-declarations "$root/examples/$name.c" \
        $(pkg-config --cflags --libs "$@") -o "$work/$name"
}

example profile_in_memory lcor
"$work/profile_in_memory" >"$work/out"
grep -q '^contrast 23\.2 ' "$work/out"

# A grey row under a lamp on its left comes out lighter there and falls off to the right.
example row_filter lcor
printf 'P6\n8 2\n255\n%048d' 0 | "$work/row_filter" 23 | tail -c 48 | od -An -v -tu1 -w3 |
    awk '$1 != $2 || $2 != $3 || (NR % 8 != 1 && $1 >= last) { bad = 1 } { last = $1 } END { exit bad || NR != 16 }'

if pkg-config --exists pappl; then
    example pappl_lines lcor pappl
    "$work/pappl_lines" drivers | grep -q '^lcor-rgb '
else
    echo "pappl_lines: not built, no libpappl-dev"
fi

if [ -x "$build/bin/rastertolcor" ] && command -v gs >/dev/null; then
    printf '%%!PS\n0.5 setgray 0 0 400 400 rectfill showpage\n' >"$work/page.ps"
    RASTERTOLCOR=$build/bin/rastertolcor DPI=36 "$root/examples/pdf_to_raster.sh" "$work/page.ps" 12 >"$work/page.ras" 2>"$work/log"
    grep -q '^PAGE: 1 1' "$work/log" && grep -aq 'lcor corrected' "$work/page.ras"
else
    echo "pdf_to_raster.sh: not run, no rastertolcor in this build or no ghostscript"
fi
