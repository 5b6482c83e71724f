#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs a statically linked x86-64 program on a PC with AVX-512 that Bochs emulates, without an
# operating system (boot.S): prints what the program prints and exits as it does.
#   run.sh PROGRAM
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

entry=$(readelf -h "$program" | awk '/Entry point/ { print $NF }')
lowest=$(objdump -h "$program" | awk '/^ +[0-9]/ { at = $4 } /ALLOC/ { print at }' | sort | head -n 1)
# shellcheck disable=SC2046 # address, size in the file and in memory of the last segment, the data
set -- $(readelf -lW "$program" | awk '$1 == "LOAD" { last = $3 " " $5 " " $6 } END { print last }')
objcopy -O binary "$program" "$work/program" # must end in the MiB where it begins: Bochs loads no more
cc -c -DENTRY="$entry" -DZEROS=$(($1 + $2)) -DZEROS_SIZE=$(($3 - $2)) "$here/boot.S" -o "$work/boot.o"
ld -Ttext=0xffff0000 -e start --oformat binary "$work/boot.o" -o "$work/rom"

cat >"$work/bochsrc" <<END
cpu: model=corei7_skylake_x, ips=100000000, reset_on_triple_fault=0
memory: guest=64, host=64
romimage: file=$work/rom, address=0xffff0000
optramimage1: file=$work/program, address=0x$lowest
com1: enabled=1, mode=file, dev=$work/out
display_library: term
panic: action=fatal
log: $work/log
END
# Debian's Bochs starts in its debugger.
echo continue | TERM=vt100 timeout 600 bochs -q -f "$work/bochsrc" >"$work/screen" 2>&1 || true

[ -e "$work/out" ] || { grep PANIC "$work/log"; exit 1; }
status=$(sed -n '$s/^exit //p' "$work/out")
sed '/^exit .$/d' "$work/out"
[ -n "$status" ] || { grep PANIC "$work/log"; exit 1; }
exit "$status"
