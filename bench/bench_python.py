# SPDX-License-Identifier: MIT
"""What the Python layer costs: call overhead, rows against the C row loop, threads, import."""

from __future__ import annotations

import ctypes
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from timeit import repeat

import lcor
import numpy as np
from results import best, table, write

HEIGHT, WIDTH, TURNS = 4096, 4096, 64


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
    number = 20000
    rows = [
        [name, 1e6 / number * min(repeat(call, timer=time.process_time, number=number, repeat=9))]
        for name, call in calls.items()
    ]
    note = f"Processor time, best of 9 times {number} calls, with the lambda around each."
    return table("Python: cost of one small call", note, ["call", "microseconds"], rows)


def imports() -> dict:
    """Milliseconds of `import lcor`, over those of starting Python."""

    def start(code: str) -> float:
        run = partial(subprocess.run, [sys.executable, "-c", code], check=True)
        return best(run, 9, clock=lambda: sum(getrusage(RUSAGE_CHILDREN)[:2]))

    bare = start("pass")
    rows = [
        ["import lcor", 1e3 * (start("import lcor") - bare)],
        ["import lcor; lcor.correct", 1e3 * (start("import lcor; lcor.correct") - bare)],
        ["import numpy", 1e3 * (start("import numpy") - bare)],
    ]
    note = "Names load when first used, and numpy with them."
    return table("Python: import", note, ["statement", "milliseconds"], rows)


def c_loop(library: ctypes.CDLL, rgb: np.ndarray, light: np.ndarray, out: np.ndarray):
    """The C row loop over these arrays as a call without arguments."""
    samples = {"float32": 0, "float64": 1, "uint8": 2, "uint16": 3}
    library.row_loop_plan.restype = ctypes.c_void_p
    library.row_loop_run.restype = None
    library.row_loop_run.argtypes = [
        ctypes.c_void_p,
        *[ctypes.c_size_t] * 2,
        *[ctypes.c_void_p] * 3,
        ctypes.c_size_t,
    ]
    plan = library.row_loop_plan(samples[rgb.dtype.name])
    rows, n = rgb.shape[:2]
    data = [array.ctypes.data for array in (rgb, light, out)]
    return partial(library.row_loop_run, plan, rows, n, *data, rgb.strides[0])


def together(*calls) -> None:
    """Each in a thread of its own; neither holds the GIL for long."""
    threads = [threading.Thread(target=call) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def applied(plan: lcor.Plan, rgb: np.ndarray, light: np.ndarray, out: np.ndarray):
    """Plan.apply over these arrays as a call without arguments."""
    return partial(plan.apply, rgb, light, out=out)


def in_halves(make, *arrays: np.ndarray):
    """Two threads, one half of the picture each: make(half of each array) is what one does."""
    middle = arrays[0].shape[0] // 2
    parts = [slice(0, middle), slice(middle, None)]
    return partial(together, *(make(*(array[part] for array in arrays)) for part in parts))


def seconds(call, clock) -> float:
    start = clock()
    call()
    return clock() - start


def rows_against_c(library: ctypes.CDLL) -> dict:
    """Plan.apply, the C row loop and two threads, turn about in one run."""
    random = np.random.default_rng(0)
    lines = []
    for dtype in (np.float32, np.uint8):
        top = 255 if dtype == np.uint8 else 1
        rgb = (random.random((HEIGHT, WIDTH, 3), np.float32) * top).astype(dtype)
        light = random.random((HEIGHT, WIDTH), np.float32) + 0.1
        out = np.zeros_like(rgb)  # one buffer for all: where it lies counts as much as the rest
        plan = lcor.Plan(23.4, 0.5)
        in_c = c_loop(library, rgb, light, out)
        one = applied(plan, rgb, light, out)
        two = in_halves(partial(applied, plan), rgb, light, out)
        two_in_c = in_halves(partial(c_loop, library), rgb, light, out)
        in_c()
        check = out.copy()
        out[...] = 0
        two()
        assert (out == check).all()
        turns = [
            (
                seconds(in_c, time.process_time),
                seconds(one, time.process_time),
                seconds(one, time.perf_counter),
                seconds(two, time.perf_counter),
                seconds(in_c, time.perf_counter),
                seconds(two_in_c, time.perf_counter),
            )
            for _ in range(TURNS)
        ]
        c, python = (min(turn[i] for turn in turns) for i in (0, 1))
        ns = 1e9 / (HEIGHT * WIDTH)
        lines.append(
            [
                np.dtype(dtype).name,
                c * ns,
                python * ns,
                python / c,
                median(turn[2] / turn[3] for turn in turns),
                median(turn[4] / turn[5] for turn in turns),
            ]
        )
    return table(
        "Python: 16 megapixels against the C row loop",
        f"Processor time, best of {TURNS} turns in one run, the output compared byte for byte. Two "
        "threads on two halves: elapsed time of one thread over that of two, one after the other, "
        f"median of {TURNS} turns; the machine's other work counts against them, and the C loop in "
        "two threads shows what can be had.",
        [
            "type",
            "C loop, ns a pixel",
            "Plan.apply, ns a pixel",
            "ratio",
            "two threads, times faster",
            "C loop in two threads, times faster",
        ],
        lines,
    )


if __name__ == "__main__":
    found = Path("build/bench/bench/librow_loop.so")
    tables = [overhead(), imports()]
    if found.exists():
        tables.append(rows_against_c(ctypes.CDLL(str(found.resolve()))))
    else:
        print(f"left out: {found} is not built (./dev bench builds it)")
    write(tables)
