# SPDX-License-Identifier: MIT
"""The row call against OpenCV's float RGB -> L*a*b* -> RGB pair, which corrects nothing.

OpenCV as it comes from PyPI has these two conversions in SSE2 code alone, whatever the machine; its
other functions choose. So the kernel `base`, which is SSE2 on x86-64, is the one on the same set.
OpenCV takes cube roots from a table of splines; its error is the distance in L*a*b* between a
colour and what comes back.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from lcor import rgb_to_lab
from results import table, write

try:
    import cv2
except ImportError as error:
    print(f"left out: {error}")
    sys.exit(0)

SIDE, TURNS = 4096, 4
KERNELS = Path(__file__).resolve().parent.parent / "build/bench/bench/bench_kernel"


def opencv_pair() -> tuple[float, float, float]:
    """Nanoseconds a pixel of the two conversions, one thread, buffers reused; worst and mean dE."""
    cv2.setNumThreads(1)
    rgb = np.random.default_rng(1).random((SIDE, SIDE, 3), dtype=np.float32)
    lab, back = np.empty_like(rgb), np.empty_like(rgb)

    times = []
    for _ in range(6):
        start = time.process_time()  # the processor's time, as bench_kernel
        cv2.cvtColor(rgb, cv2.COLOR_LRGB2Lab, dst=lab)
        cv2.cvtColor(lab, cv2.COLOR_Lab2LRGB, dst=back)
        times.append(time.process_time() - start)
    there, here = (rgb_to_lab(a[:256].astype(float), space="srgb") for a in (rgb, back))
    error = np.linalg.norm(there - here, axis=-1)
    return 1e9 * min(times) / SIDE**2, error.max(), error.mean()


def rows() -> list[list]:
    """The same picture size through lcor_correct_row, by the compiled bench."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "kernel.json"
        program = [str(KERNELS), str(out), "16", "f32 clip"]
        subprocess.run(program, check=True, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text())["tables"][0]["rows"]


def main() -> None:
    if not KERNELS.exists():
        sys.exit(f"bench_opencv: {KERNELS} is missing: ./dev bench builds it")
    pairs, runs = zip(*((opencv_pair(), rows()) for _ in range(TURNS)))
    pair, *error = min(pairs)
    lines = [["OpenCV " + cv2.__version__, pair, 1.0, *error]]
    for same_kernel in zip(*runs):
        kernel, _, ns, _, _, *error = min(same_kernel, key=lambda row: row[2])
        if kernel != "double":
            lines.append(["lcor " + kernel, ns, pair / ns, *error])
    note = (
        "16 megapixels, interleaved linear float RGB, one thread, best of several, turn about. "
        "OpenCV: RGB to L*a*b* and back, nothing else, in the SSE2 code that is all its wheel has "
        "for them; dE of what comes back. lcor: the whole correction, gamut clipped; base is SSE2 "
        "on x86-64; dE against double."
    )
    title = "Correction against two colour conversions"
    write([table(title, note, ["", "ns/pixel", "times", "dE max", "dE mean"], lines)])


if __name__ == "__main__":
    main()
