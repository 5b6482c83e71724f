#!/bin/sh
# SPDX-License-Identifier: MIT
# The same input gives the same bytes from every compiler here, at every optimisation, for every
# instruction set: builds rows.c with the sources it needs and compares what it prints.
#   run.sh OUT
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
out=$1
mkdir -p "$out"
sources=$(for room in base colour adapt correct; do echo "$root/lib/src/$room"/*.c; done)
flags="-std=c99 -ffp-contract=off -I$root/lib/include -I$root/lib/src"

# build NAME COMMAND...: compile, run and keep the hashes in OUT/NAME.txt; fails quietly if the
# compiler is missing or the machine cannot run the set
build() {
    name=$1
    shift
    command -v "$1" >/dev/null || { echo "skipped: $1 is not installed"; return 1; }
    # shellcheck disable=SC2086 # the lists are words
    "$@" $flags $sources "$here/rows.c" -o "$out/$name" -lm -pthread
}

reference=
failed=0
compare() {
    name=$1
    build "$@" || return 0
    "$out/$name" >"$out/$name.txt" || { echo "$name: does not run here"; return 0; }
    if grep differs "$out/$name.txt"; then
        failed=1
    fi
    if [ -z "$reference" ]; then
        reference=$name
    elif ! cmp -s "$out/$reference.txt" "$out/$name.txt"; then
        echo "$name differs from $reference:"
        diff "$out/$reference.txt" "$out/$name.txt" | head -n 5
        failed=1
    fi
    compared="${compared-} $name"
}

compare gcc-O0 gcc -O0
compare gcc-O3 gcc -O3
compare clang-O2 clang -O2
if grep -q avx2 /proc/cpuinfo 2>/dev/null && grep -q fma /proc/cpuinfo; then
    compare gcc-avx2 gcc -O3 -march=x86-64-v3 # has fused multiply-add, and must not use it
    compare clang-avx2 clang -O3 -march=x86-64-v3
fi
if grep -q avx512vl /proc/cpuinfo 2>/dev/null; then
    compare gcc-avx512 gcc -O3 -march=x86-64-v4 -mprefer-vector-width=512
    compare clang-avx512 clang -O3 -march=x86-64-v4
fi
set -- ${compared-}
[ $# -gt 1 ] || { echo "skipped: fewer than two builds to compare"; exit 77; }
[ $failed = 0 ] && echo "same bytes: $*"
exit $failed
