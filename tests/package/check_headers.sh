#!/bin/sh
# SPDX-License-Identifier: MIT
# Each public header compiles alone, as C99 and as C++11, without a warning.
set -eu
include=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for header in $(cd "$include" && find lcor -name '*.h'); do
    printf '#include <%s>\nint main(void) { return 0; }\n' "$header" >"$work/header.c"
    cp "$work/header.c" "$work/header.cpp"
    flags="-pedantic-errors -Wall -Wextra -Wundef -Werror -I$include -o $work/header.o"
    cc -std=c99 -Wstrict-prototypes $flags -c "$work/header.c"
    c++ -std=c++11 $flags -c "$work/header.cpp"
done
