#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The paper from end to end: a densitometer measures a print, the device profile comes out of it, and
# the room of the paper's Table 3 is rendered for that printer. ./dev demo calls this.
# usage: demo.sh BINDIR PYTHON PHOTOGRAPHS OUT
set -euo pipefail
bin=$1 python=$2 photographs=$3 out=$4
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
mkdir -p "$out"

# 1. A printer of contrast 23.4 (section 5.1), seen through an emulated Printalyzer densitometer that
#    waits on a pseudo-terminal as the real one does on /dev/ttyACM0.
PYTHONPATH=$here/../bindings/python "$python" -m lcor.emulator --model printalyzer --contrast 23.4 \
    --auto-press 5 --once >"$out/.port" </dev/null &
emulator=$!
trap 'kill "$emulator" 2>/dev/null || true; rm -f "$out/.port"' EXIT
until [[ -s $out/.port ]]; do kill -0 "$emulator" && sleep 0.05; done
"$bin/lccal" --port "$(head -n 1 "$out/.port")" --yes -o "$out/printer.cgats"

# 2. The room: six faces of 50 x 50 patches, one point light of 100 cd, three photographs.
"$bin/lcor" room --quiet -o "$out/room.glb" --light 0.5,0.45,0.6,100 \
    --texture "floor=$photographs/Wood.jpg" --texture "ceiling=$photographs/Storm.jpg" \
    --texture "x0=$photographs/Dune.jpg" --texture "x1=$photographs/Dune.jpg" \
    --texture "y0=$photographs/Dune.jpg" --texture "y1=$photographs/Dune.jpg"

# 3. Both views of Figure 4, by the paper's method and by the conventional one (eq 19).
for camera in side above; do
    "$bin/lcor" render --quiet "$out/room.glb" --camera "$camera" --size 1280x960 \
        --profile "$out/printer.cgats" -o "$out/$camera-corrected.png" \
        --aov "false-colour=$out/$camera-illuminance.png"
    "$bin/lcor" render --quiet "$out/room.glb" --camera "$camera" --size 1280x960 \
        --profile "$out/printer.cgats" --conventional -o "$out/$camera-conventional.png"
done

# 4. Figures.
"$python" "$here/demo_figures.py" "$out"

cat <<LIST

In $out:
  printer.cgats             device profile: every reading, D_min, D_max and the contrast c
  room.glb                  the paper's room (Table 3) as a glTF scene with its photographs
  side-corrected.png        Figure 4 (a), lightness corrected for the printer
  side-conventional.png     the same view by the conventional method, eq 19
  above-corrected.png       Figure 4 (b), lightness corrected
  above-conventional.png    the same view by eq 19
  side-illuminance.png      illuminance of the side view in false colour, with its scale in lux
  above-illuminance.png     the same of the view from above
  comparison.png            all of them side by side, and how far eq 19 turns hue
  measurement.png           the readings, their spread and the contrast that follows
  figure5.png               Figure 5: display luminance, hue and chroma against illuminance
LIST
