# SPDX-License-Identifier: MIT
"""Measure a printer, then correct a photograph for it: lit by a lamp at its upper left.

usage: photograph.py PHOTO PORT OUT
PORT is the densitometer's (lccal list). Without one: python -m lcor.emulator --model printalyzer
--auto-press 5 --once prints the name of an emulated port.
"""

import subprocess
import sys

import lcor
import numpy as np
from PIL import Image

photo, port, out = sys.argv[1:]
subprocess.run(["lccal", "--port", port, "--yes", "-o", "printer.cgats"], check=True)
profile = lcor.Profile.load("printer.cgats")
texture = np.asarray(Image.open(photo).convert("RGB"))  # uint8, stored as sRGB
y, x = np.mgrid[0.0 : 1.0 : texture.shape[0] * 1j, 0.0 : 1.0 : texture.shape[1] * 1j]
illuminance = 100 / (0.2 + (x - 0.2) ** 2 + (y - 0.2) ** 2)  # lx: a lamp near the upper left
corrected = lcor.correct(
    texture, illuminance, profile.contrast, reading="texel", space="srgb", transfer="srgb"
)
Image.fromarray(corrected).save(out)
print(f"{out}: for a contrast of {profile.contrast:.1f} ± {profile.contrast_u95:.1f}")
