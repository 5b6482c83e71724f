#!/bin/sh
# SPDX-License-Identifier: MIT
# Builds the portable core (base, colour, adapt, correct, profile) for other machines, runs it there
# and compares every byte with this machine:
#   run.sh OUT [aarch64 | armhf | musl | mingw | cortex-m4 | cortex-m7 | avx512 | avx512-clang]...
# A port whose compiler or emulator is missing is skipped with a word; 77 if none could run.
# shellcheck disable=SC2086 # lists are words
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
out=$1
shift
[ $# -gt 0 ] || set -- aarch64 armhf musl mingw cortex-m4 cortex-m7 avx512 avx512-clang
mkdir -p "$out"
out=$(cd "$out" && pwd)

sources=$(for room in base colour adapt correct profile; do echo "$root"/lib/src/$room/*.c; done)
flags="-std=c99 -O2 -ffp-contract=off -fno-math-errno -fno-trapping-math -ffunction-sections -fdata-sections
    -DLCOR_STATIC -I$root/lib/include -I$root/lib/src -I$out"

awk -F, 'NR > 1 { printf "{\x27%s\x27, {%s, %s, %s}, %s, %s, %s, %s, {%s, %s, %s}},\n",
    $1, $2, $3, $4, $5, $6, $7, $8, $23, $24, $25 }' "$root/tests/data/golden/pixel_cie.csv" >"$out/golden.inc"

# have PROGRAM...: all are installed.
have() {
    for program in "$@"; do
        command -v "$program" >/dev/null || { missing=$program; return 1; }
    done
}

# hosted NAME RUN COMPILER FILE OR FLAG...: build for a machine with an operating system and run.
hosted() {
    name=$1 runner=$2 compiler=$3
    shift 3
    $compiler $flags "$here/core.c" "$here/hosted.c" "$@" -o "$out/$name.exe" -lm
    $runner "$out/$name.exe" | tr -d '\r' >"$out/$name.txt"
}

port_aarch64() {
    have aarch64-linux-gnu-gcc qemu-aarch64 || return 77
    hosted aarch64 "qemu-aarch64 -L /usr/aarch64-linux-gnu" aarch64-linux-gnu-gcc $sources
}

port_armhf() {
    have arm-linux-gnueabihf-gcc qemu-arm || return 77
    hosted armhf "qemu-arm -L /usr/arm-linux-gnueabihf" arm-linux-gnueabihf-gcc $sources
}

port_musl() {
    have musl-gcc || return 77
    hosted musl "" musl-gcc -static $sources
}

# The DLL must export what liblcor exports elsewhere, optimised or not; the core runs where wine is.
port_mingw() {
    have x86_64-w64-mingw32-gcc x86_64-w64-mingw32-objdump || return 77
    # shellcheck disable=SC2046
    x86_64-w64-mingw32-gcc -std=c99 -DLCOR_BUILDING -I"$root/lib/include" -I"$root/lib/src" \
        -shared -static-libgcc "$root"/lib/src/*/*.c -o "$out/lcor.dll"
    x86_64-w64-mingw32-objdump -p "$out/lcor.dll" | sed -n '/Ordinal\/Name Pointer\] Table/,$p' |
        awk '/^\t\[/ { print $NF }' | LC_ALL=C sort >"$out/mingw-exports.txt"
    diff "$root/tests/package/symbols.txt" "$out/mingw-exports.txt" || { echo "lcor.dll exports something else"; return 1; }
    # Debian's wine64 has no command on the path.
    wine=$(command -v wine64 || command -v wine || ls /usr/lib/wine/wine64 2>/dev/null || true)
    if [ -n "$wine" ]; then
        export WINEPREFIX="$out/wine" WINEDEBUG=-all
        hosted mingw "timeout 240 $wine" x86_64-w64-mingw32-gcc -static $sources
    else
        hosted mingw true x86_64-w64-mingw32-gcc -static $sources
        echo "# mingw: linked, $(wc -l <"$out/mingw-exports.txt") exports as on Linux; not run: no wine"
        cp "$out/native.txt" "$out/mingw.txt"
    fi
}

# compile NAME SOURCES COMMAND...: each source to an object of its own; their names into $objects.
compile() {
    folder=$out/$1 list=$2 objects=
    shift 2
    mkdir -p "$folder"
    for source in $list; do
        object=$folder/$(basename "$(dirname "$source")")-$(basename "$source" .c).o
        "$@" -c "$source" -o "$object"
        objects="$objects $object"
    done
}

# cortex NAME BOARD FLAG...: no operating system, and no heap in the row path.
cortex() {
    name=$1 board=$2
    shift 2
    have arm-none-eabi-gcc qemu-system-arm || return 77
    compile "$name" "$sources $here/core.c $here/cortex-m/board.c" arm-none-eabi-gcc $flags -Os -mthumb "$@"
    arm-none-eabi-gcc -mthumb "$@" -nostartfiles --specs=nosys.specs -Wl,--gc-sections,--no-warn-rwx-segments \
        -T "$here/cortex-m/mps2.ld" $objects -o "$out/$name.elf" -lm 2>"$out/$name.log" || { cat "$out/$name.log"; return 1; }
    row=$(for room in base colour adapt correct; do echo "$out/$name/$room"-*.o; done)
    code=$(arm-none-eabi-size -t $row | awk 'END { print $1 + $2 }')
    echo "# $name: base, colour, adapt and correct: $code bytes of code and constants"
    [ "$code" -le 32768 ] || { echo "more than 32 KiB"; return 1; }
    timeout 240 qemu-system-arm -M "$board" -nographic -monitor none -serial none \
        -semihosting-config enable=on,target=native -kernel "$out/$name.elf" 2>"$out/$name.txt" ||
        { tail -n 3 "$out/$name.txt"; return 1; }
}

port_cortex_m4() { cortex cortex-m4 mps2-an386 -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard; }
port_cortex_m7() { cortex cortex-m7 mps2-an500 -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard; }

# With AVX-512, on a PC that is emulated.
avx512() {
    name=$1 compiler=$2
    have bochs musl-gcc "$compiler" || return 77
    compile "$name" "$sources" $compiler $flags
    hosted "$name" "$here/pc/run.sh" musl-gcc -static -no-pie $objects
    grep -q '^# kernel avx512' "$out/$name.txt" || { echo "the machine has no AVX-512"; return 1; }
}

port_avx512() { avx512 avx512 gcc; }
port_avx512_clang() { avx512 avx512-clang clang; }

hosted native "" "${CC:-cc}" $sources
ran=0 bad=0
for port in "$@"; do
    missing=
    status=0
    port_"$(echo "$port" | tr - _)" || status=$?
    if [ $status = 77 ]; then
        echo "$port: skipped, $missing is not installed"
    elif [ $status != 0 ]; then
        echo "$port: FAILED"
        bad=1
    elif ! grep -v '^#' "$out/native.txt" >"$out/native.cmp" || ! grep -v '^#' "$out/$port.txt" >"$out/$port.cmp" ||
        ! diff "$out/native.cmp" "$out/$port.cmp"; then
        echo "$port: FAILED, not the bytes of this machine"
        bad=1
    else
        grep '^# stack' "$out/$port.txt" | grep -v ': 0$' || true
        echo "$port: the same bytes as here, $(wc -l <"$out/$port.cmp") lines"
        ran=1
    fi
done
[ $bad = 0 ] || exit 1
[ $ran = 1 ] || exit 77
