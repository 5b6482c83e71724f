#!/bin/sh
# SPDX-License-Identifier: MIT
# The shared library exports exactly the symbols listed, so that a change of the ABI is a change of
# that list. UPDATE=1 writes the list anew.
set -eu
library=$1 nm=$2 list=$3
found=$(mktemp)
trap 'rm -f "$found"' EXIT
"$nm" -D --defined-only -g "$library" | awk 'NF == 3 { print $3 }' | LC_ALL=C sort >"$found"
if grep -v '^lcor_' "$found"; then
    echo "exports without the prefix lcor_"
    exit 1
fi
[ "${UPDATE:-}" != 1 ] || cp "$found" "$list"
diff -u "$list" "$found" || {
    echo "exported symbols differ from $list; if that is meant, run this with UPDATE=1"
    exit 1
}
