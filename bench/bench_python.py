# SPDX-License-Identifier: MIT
"""What the Python layer costs: call overhead, rows against the C row loop, threads, import."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import lcor
import numpy as np
from results import best, table, write

HEIGHT, WIDTH = 4096, 4096


def overhead() -> dict:
    """Microseconds of one small call."""
    pixel, colour = np.array([0.9, 0.2, 0.6]), (0.9, 0.2, 0.6)
    plan = lcor.Plan(23.4, 0.5)
    calls = {
        "rgb_to_lab(array of 3)": lambda: lcor.rgb_to_lab(pixel),
        "rgb_to_lab(tuple of 3)": lambda: lcor.rgb_to_lab(colour),
        "adapt(number)": lambda: lcor.adapt(0.5, 1.0, 1.0, 23.4),
        "contrast_from_density": lambda: lcor.contrast_from_density(1.44, 0.07),
        "Plan.apply(array of 3)": lambda: plan.apply(pixel, 1.0),
    }
    rows = [[name, 1e6 * best(call, 9, 0.02)] for name, call in calls.items()]
    return table("Python: cost of one small call", "", ["call", "microseconds"], rows)


def imports() -> dict:
    """Milliseconds of `import lcor`, over those of starting Python."""

    def start(code: str) -> float:
        run = partial(subprocess.run, [sys.executable, "-c", code], check=True)
        return best(run, 9, clock=lambda: sum(os.times()[2:4]))  # of finished children

    bare = start("pass")
    rows = [
        ["import lcor", 1e3 * (start("import lcor") - bare)],
        ["import lcor; lcor.correct", 1e3 * (start("import lcor; lcor.correct") - bare)],
        ["import numpy", 1e3 * (start("import numpy") - bare)],
    ]
    note = "Names load when first used, and numpy with them."
    return table("Python: import", note, ["statement", "milliseconds"], rows)


class Options(ctypes.Structure):
    """lcor_plan_options."""

    _fields_ = (
        [("struct_size", ctypes.c_size_t)]
        + [(n, ctypes.c_double) for n in ("contrast", "r_mean", "rho", "rho_ratio", "exponent")]
        + [("reading", ctypes.c_int), ("gamut", ctypes.c_int), ("colour", ctypes.c_void_p)]
        + [(n, ctypes.c_int) for n in ("in_type", "out_type", "map_type")]
        + [("in_layout", ctypes.c_size_t * 2), ("out_layout", ctypes.c_size_t * 2)]
        + [("tone_curve", ctypes.c_void_p), ("tone_size", ctypes.c_size_t)]
        + [("allocator", ctypes.c_void_p * 3)]
    )


def c_loop(library: Path, rgb: np.ndarray, light: np.ndarray, out: np.ndarray):
    """The C row loop, one lcor_correct_row a row, and the plan it uses."""
    lib = ctypes.CDLL(str(library))
    types = {"float32": 0, "float64": 1, "uint8": 2, "uint16": 3}
    kind = types[rgb.dtype.name]
    options = Options(ctypes.sizeof(Options), 23.4, 0.5, 0.5, 1.0, 1.0)
    options.in_type = options.out_type = kind
    plan = ctypes.c_void_p()
    assert lib.lcor_plan_new(ctypes.byref(options), ctypes.byref(plan), None) == 0
    row = lib.lcor_correct_row
    row.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t] + [ctypes.c_void_p] * 5
    row.restype = None
    bases = [(a.ctypes.data, a.strides[0]) for a in (rgb, light, out)]

    def run() -> None:
        (i, di), (e, de), (o, do) = bases
        for y in range(rgb.shape[0]):
            row(plan, y, rgb.shape[1], i + y * di, e + y * de, None, o + y * do, None)

    return run


def halves(plan: lcor.Plan, rgb: np.ndarray, light: np.ndarray, out: np.ndarray) -> None:
    """Two threads, one half of the picture each."""
    middle = rgb.shape[0] // 2
    threads = [
        threading.Thread(target=plan.apply, args=(rgb[s], light[s]), kwargs={"out": out[s]})
        for s in (slice(0, middle), slice(middle, None))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def rows_against_c(library: Path) -> dict:
    """Plan.apply, the C row loop and two threads, turn about in one run."""
    random = np.random.default_rng(0)
    lines = []
    for dtype in (np.float32, np.uint8):
        top = 255 if dtype == np.uint8 else 1
        rgb = (random.random((HEIGHT, WIDTH, 3), np.float32) * top).astype(dtype)
        light = random.random((HEIGHT, WIDTH), np.float32) + 0.1
        out, check = np.empty_like(rgb), np.empty_like(rgb)
        plan = lcor.Plan(23.4, 0.5)
        in_c = c_loop(library, rgb, light, check)
        turns = [
            (
                best(in_c, 1),
                best(partial(plan.apply, rgb, light, out=out), 1),
                best(partial(plan.apply, rgb, light, out=out), 1, clock=time.perf_counter),
                best(partial(halves, plan, rgb, light, out), 1, clock=time.perf_counter),
            )
            for _ in range(4)
        ]
        assert (out == check).all()
        c, python, wall, two = (min(column) for column in zip(*turns))
        ns = 1e9 / (HEIGHT * WIDTH)
        lines.append([np.dtype(dtype).name, c * ns, python * ns, python / c, wall / two])
    return table(
        "Python: 16 megapixels against the C row loop",
        "Processor time, best of four turns in one run, the output compared byte for byte. Two "
        "threads on two halves: elapsed time, so the machine's other work counts against them.",
        [
            "type",
            "C loop, ns a pixel",
            "Plan.apply, ns a pixel",
            "ratio",
            "two threads, times faster",
        ],
        lines,
    )


if __name__ == "__main__":
    # the shared library of ./dev bench, or the first one built
    found = sorted(Path("build").glob("**/lib/liblcor.so"), key=lambda p: "bench" not in p.parts)
    tables = [overhead(), imports()]
    if found:
        tables.append(rows_against_c(found[0].resolve()))
    write(tables)
