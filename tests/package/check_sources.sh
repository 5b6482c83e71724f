#!/bin/sh
# SPDX-License-Identifier: MIT
# No number reading that follows the locale stands in lib/ or calib/.
set -eu
root=$1
if grep -rnE '\b(strtod|strtof|strtold|atof|sscanf|fscanf|setlocale) *\(' "$root/lib" "$root/calib"; then
    echo "locale-dependent parsing in lib/ or calib/"
    exit 1
fi
