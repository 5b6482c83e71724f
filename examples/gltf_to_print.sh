#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a scene exported by Blender to a picture for one printer; docs/blender.md explains each step.
# usage: gltf_to_print.sh SCENE.glb PORT DIR
set -euo pipefail
scene=$1 port=$2 out=$3
mkdir -p "$out"

lcor info "$scene"
lccal --port "$port" --yes -o "$out/printer.cgats"
lcor render "$scene" --size 320x240 --profile "$out/printer.cgats" -o "$out/print.png"
lcor render "$scene" --size 320x240 --profile "$out/printer.cgats" --conventional -o "$out/eq19.png"
lcor info "$out/print.png"
