#!/bin/sh
# SPDX-License-Identifier: MIT
# A PDF or PostScript file through Ghostscript and the correction into CUPS raster, without a print
# queue:
#   pdf_to_raster.sh FILE CONTRAST [LIGHT.pfm] > pages.ras
# RASTERTOLCOR names the filter if it is not where CUPS keeps filters.
set -eu
file=$1 contrast=$2 light=${3:-}
filter=${RASTERTOLCOR:-/usr/lib/cups/filter/rastertolcor}
options="lcor-contrast=$contrast"
[ -z "$light" ] || options="$options lcor-illuminance=$light"

# cupsColorSpace 19 is sRGB; the names are those of the raster's page header.
gs -q -dSAFER -dNOPAUSE -dBATCH -sstdout=%stderr -sDEVICE=cups -r"${DPI:-300}" \
    -dcupsColorSpace=19 -dcupsBitsPerColor=8 -dcupsColorOrder=0 -sOutputFile=%stdout "$file" |
    "$filter" 1 "${USER:-user}" "$(basename "$file")" 1 "$options"
