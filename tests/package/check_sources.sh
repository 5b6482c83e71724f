#!/bin/sh
# SPDX-License-Identifier: MIT
# liblcor builds from its bare sources with one command and no build system, as print drivers vendor
# it, and needs nothing but libm; no locale-dependent number reading stands in lib/ or calib/.
set -eu
root=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cc -std=c99 -O1 -ffp-contract=off -DLCOR_STATIC -I"$root/lib/include" -I"$root/lib/src" \
    -shared -fPIC -Wl,-z,defs "$root"/lib/src/*/*.c -o liblcor.so -lm
if grep -rnE '\b(strtod|strtof|strtold|atof|sscanf|fscanf|setlocale) *\(' "$root/lib" "$root/calib"; then
    echo "locale-dependent parsing in lib/ or calib/"
    exit 1
fi
