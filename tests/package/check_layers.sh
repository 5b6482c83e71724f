#!/bin/sh
# SPDX-License-Identifier: MIT
# One-way arrows: each folder may include only the headers its line lists.
set -eu
root=$1
bad=0
std="assert.h ctype.h errno.h float.h limits.h math.h stdarg.h stdbool.h stddef.h stdint.h stdio.h stdlib.h string.h time.h wchar.h"

includes() { sed -n 's/^ *# *include *["<]\([^">]*\)[">].*/\1/p' "$1"; }

# room FOLDER PREFIX...: its files may include their own folder, what is listed, and nothing else.
room() {
    dir=$1
    shift
    # shellcheck disable=SC2044 # the tree has no names with spaces
    for file in $(find "$root/$dir" -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.inc'); do
        for header in $(includes "$file"); do
            ok=0
            for prefix in "$@"; do
                case $header in "$prefix"*) ok=1 ;; esac
            done
            [ -e "$(dirname "$file")/$header" ] && ok=1
            [ $ok = 1 ] || { echo "$file may not include $header"; bad=1; }
        done
    done
}

base="$std lcor/status.h lcor/alloc.h lcor/export.h lcor/version.h lcor/parallel.h base/"
room lib/src/base      $base cpuid.h
room lib/src/colour    $base lcor/colour.h colour/
room lib/src/adapt     $base lcor/adapt.h adapt/
room lib/src/correct   $base lcor/colour.h lcor/adapt.h lcor/correct.h colour/ adapt/ correct/
room lib/src/geometry  $base immintrin.h geometry/
room lib/src/scene     $base lcor/scene.h geometry/ scene/
room lib/src/radiosity $base lcor/scene.h lcor/radiosity.h geometry/ scene/ radiosity/
room lib/src/view      $base lcor/scene.h lcor/radiosity.h lcor/view.h geometry/ scene/ radiosity/ view/
room lib/src/profile   $base lcor/adapt.h lcor/profile.h profile/
posix="dirent.h fcntl.h getopt.h glob.h grp.h libgen.h poll.h pwd.h pty.h signal.h sys/ termios.h unistd.h"
room calib/transport  $std $posix number.h transport/ hidapi
room calib/instrument $std number.h transport/ instrument/
room calib $std $posix lcor/ lccal.h number.h buffer.h json.h transport/ instrument/ session/ command/ hidapi libusb tiffio.h linux/hidraw.h
exit $bad
