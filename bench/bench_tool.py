# SPDX-License-Identifier: MIT
"""The tool lcor as a user meets it, whole processes: correcting a picture of 100 megapixels beside
a plain copy of the same file, and rendering a room beside decoding its textures and encoding the
view alone.

    bench_tool.py RESULTS.json        (needs OpenImageIO's iconvert and oiiotool)
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import results
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PHOTOGRAPHS = Path("/usr/share/backgrounds/mate/nature")
WIDTH, HEIGHT = 12288, 8192


@dataclass
class Cost:
    """What a process took: seconds elapsed, seconds of all its threads, megabytes at its peak."""

    elapsed: float
    processor: float
    memory: float


def run(*command: object) -> Cost:
    begin = time.perf_counter()
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"bench_tool.py: {command[0]} ended with {process.returncode}")
    return Cost(
        time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024
    )


def best(turns: int, *commands: tuple[object, ...]) -> list[Cost]:
    """The least of each figure over several turns, the commands taking turns."""
    costs = [[run(*command) for command in commands] for _ in range(turns)]
    return [
        Cost(
            min(c.elapsed for c in column),
            min(c.processor for c in column),
            max(c.memory for c in column),
        )
        for column in zip(*costs, strict=True)
    ]


def find_lcor() -> Path:
    for folder in (os.environ.get("LCOR_BINDIR", ""), "build/bench/bin", "build/release/bin"):
        if folder and (ROOT / folder / "lcor").exists():
            return ROOT / folder / "lcor"
    sys.exit("bench_tool.py: no lcor; build it first")


def photograph(path: Path) -> None:
    """Saves a picture of WIDTH x HEIGHT: a photograph with its grain, four times below itself."""
    with Image.open(PHOTOGRAPHS / "GreenMeadow.jpg") as image:
        part = image.convert("RGB").resize((WIDTH, HEIGHT // 4), Image.Resampling.BICUBIC)
    grain = np.random.default_rng(1).integers(-2, 3, (HEIGHT // 4, WIDTH, 1), np.int16)
    grainy = np.clip(np.asarray(part) + grain, 0, 255).astype(np.uint8)
    Image.fromarray(np.tile(grainy, (4, 1, 1))).save(path)


def correcting(lcor: Path, folder: Path) -> dict[str, Any]:
    original, copy, out = folder / "original.tif", folder / "copy.tif", folder / "out.tif"
    # A process starts with the peak of the one that starts it, so this one has to stay small.
    with ProcessPoolExecutor(1) as pool:
        pool.submit(photograph, folder / "plain.tif").result()
    light = np.linspace(0.05, 1.0, 512, dtype="<f4")[None].repeat(512, 0)
    (folder / "light.pfm").write_bytes(b"Pf\n512 512\n-1\n" + light.tobytes())
    rows = []
    for compression, turns in (("none", 5), ("lzw", 2), ("zip", 1)):
        convert = ("iconvert", "--threads", 2, "--compression", compression)
        run(*convert, folder / "plain.tif", original)
        arguments = ("--illuminance", folder / "light.pfm", "--contrast", "23.4", "--threads", 2)
        peer, own = best(
            turns,
            (*convert, original, copy),
            (lcor, "correct", original, *arguments, "-o", out, "--quiet"),
        )
        rows.append(
            [
                compression,
                peer.elapsed,
                own.elapsed,
                own.elapsed / peer.elapsed,
                own.processor / peer.processor,
                own.memory,
            ]
        )
    return results.table(
        "lcor correct: 100 megapixels of 8 bits against a plain copy",
        "A TIFF file read and written again with the same compression by OpenImageIO's iconvert, "
        "and corrected by lcor; two threads each, whole processes, best of five, two and one "
        "turns. lcor reads the picture twice and waits until the disk has it; what it compresses "
        "is another picture.",
        ["compression", "copy s", "lcor s", "ratio", "ratio of processor time", "lcor MB"],
        rows,
    )


def rendering(lcor: Path, folder: Path) -> dict[str, Any]:
    room, view, copy = folder / "room.glb", folder / "view.png", folder / "copy.png"
    textures = []
    for name in ("GreenMeadow", "Dune", "Wood"):
        with Image.open(PHOTOGRAPHS / f"{name}.jpg") as image:
            image.convert("RGB").resize((1000, 1000)).save(folder / f"{name}.jpg", quality=90)
        textures.append(folder / f"{name}.jpg")
    faces = [f"--texture={f}={t}" for f, t in zip(("y1", "floor", "x0"), textures, strict=True)]
    run(lcor, "room", "-o", room, "--quiet", *faces)
    render = (lcor, "render", room, "--contrast", "23.4", "--size", "1920x1080", "--quiet")
    run(*render, "-o", folder / "view.tif")
    read = [word for t in (*textures, folder / "view.tif") for word in ("-i:now=1", t)]
    peer, own = best(5, ("oiiotool", *read, "-o", copy), (*render, "-o", view))
    return results.table(
        "lcor render: the room in 1920 x 1080 with three textures of 1000 x 1000",
        "Beside OpenImageIO's oiiotool decoding the textures and encoding the finished view; whole "
        "processes, best of five turns.",
        ["decode + encode s", "lcor s", "ratio", "ratio of processor time", "lcor MB"],
        [
            [
                peer.elapsed,
                own.elapsed,
                own.elapsed / peer.elapsed,
                own.processor / peer.processor,
                own.memory,
            ]
        ],
    )


def main() -> None:
    lcor = find_lcor()
    with tempfile.TemporaryDirectory(prefix="lcor-bench-") as name:
        folder = Path(name)
        results.write([correcting(lcor, folder), rendering(lcor, folder)])


if __name__ == "__main__":
    main()
