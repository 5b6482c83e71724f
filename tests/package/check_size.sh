#!/bin/sh
# SPDX-License-Identifier: MIT
# What a print driver links (base, colour, adapt, correct) is at most 60 KB: code and data of a
# stripped shared library of those rooms alone, which also shows that they need nothing but libm.
set -eu
root=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
rooms=$(for room in base colour adapt correct; do echo "$root/lib/src/$room"/*.c; done)
# shellcheck disable=SC2086 # the list is words
cc -std=c99 -O2 -ffp-contract=off -fno-math-errno -fno-trapping-math -fvisibility=hidden -ffunction-sections \
    -I"$root/lib/include" -I"$root/lib/src" -shared -fPIC -s -Wl,-z,defs,--gc-sections $rooms -o "$work/driver.so" -lm
size=$(size "$work/driver.so" | awk 'NR == 2 { print $1 + $2 }')
echo "base, colour, adapt and correct: $size bytes of code and data"
[ "$size" -le 60000 ]
