# SPDX-License-Identifier: MIT
"""rastertolcor measured: what an A4 page of 600 dpi costs beside a filter that only copies, and
what it costs in accuracy to take the mean of r from a part of a page.

    bench_print.py RESULTS.json        (needs a build with -DLCOR_BUILD_CUPS=ON)
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import results
from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "print"))
import raster  # noqa: E402

PHOTOGRAPHS = Path("/usr/share/backgrounds/mate/nature")
WIDTH, HEIGHT = 4960, 7016
SIDE = 900  # longer side of the photographs that stand for small pages
TURNS = 5


def find_filter() -> Path:
    folders = [os.environ.get("LCOR_BINDIR", ""), "build/bench/bin", "build/release/bin"]
    for folder in folders:
        path = ROOT / folder / "rastertolcor"
        if folder and path.exists():
            return path
    sys.exit("bench_print.py: no rastertolcor; configure with -DLCOR_BUILD_CUPS=ON")


def photographs(side: int) -> Iterator[tuple[str, np.ndarray]]:
    for path in sorted(PHOTOGRAPHS.glob("*.jpg")):
        with Image.open(path) as image:
            picture = image.convert("RGB")
            picture.thumbnail((side, side))
            yield path.stem, np.asarray(picture)


def text_page() -> np.ndarray:
    image = Image.new("L", (WIDTH, HEIGHT), 255)
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(83)  # 10 points
    for y in range(400, HEIGHT - 400, 130):
        draw.text((500, y), "Lightness correction for photorealistic rendering. " * 2, 0, font)
    return np.asarray(image.convert("RGB"))


def photograph_page(dpi: int) -> np.ndarray:
    """As a renderer of PDF enlarges it: each pixel repeated."""
    _, picture = next(photographs(2000), ("", np.full((9, 9, 3), 128, np.uint8)))
    small = Image.fromarray(picture).resize(
        (WIDTH * dpi // 600, HEIGHT * dpi // 600), Image.Resampling.BICUBIC
    )
    return np.asarray(small.resize((WIDTH, HEIGHT), Image.Resampling.NEAREST))


def noisy_page() -> np.ndarray:
    page = photograph_page(600).astype(np.int16)
    page += np.random.default_rng(1).integers(-2, 3, page.shape, np.int8)
    return np.clip(page, 0, 255).astype(np.uint8)


PAGES = {
    "text": text_page,
    "photograph of 90 dpi": lambda: photograph_page(90),
    "photograph of 300 dpi": lambda: photograph_page(300),
    "noise in every pixel": noisy_page,
}


@dataclass
class Cost:
    """Of one process: seconds elapsed, and of all its threads."""

    elapsed: float
    processor: float


def run(command: list[str], page: Path, out: Path) -> Cost:
    with page.open("rb") as read, out.open("wb") as write:
        begin = time.perf_counter()
        process = subprocess.Popen(command, stdin=read, stdout=write, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        elapsed = time.perf_counter() - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"bench_print.py: {command[0]} ended with {process.returncode}")
    return Cost(elapsed, usage.ru_utime + usage.ru_stime)


def peak(command: list[str], page: Path) -> float:
    """Megabytes of the filter at its peak, asked for between the page and the end of the job:
    what wait4 tells is no less than this process had when it started the filter."""
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    assert process.stdin and process.stderr
    process.stdin.write(page.read_bytes())
    process.stdin.flush()
    while not process.stderr.readline().startswith(b"PAGE: "):
        if process.poll() is not None:
            sys.exit(f"bench_print.py: {command[0]} ended with {process.returncode}")
    status = Path(f"/proc/{process.pid}/status").read_text()
    process.communicate()
    return int(re.findall(r"VmHWM:\s+(\d+)", status)[0]) / 1024


def light_map(folder: Path) -> Path:
    down, across = np.mgrid[0:64, 0:64] / 63
    light = (0.4 + 0.4 * down + across**2).astype("<f4")
    path = folder / "light.pfm"
    path.write_bytes(b"Pf\n64 64\n-1\n" + light.tobytes())
    return path


def throughput(rastertolcor: Path, folder: Path) -> dict[str, Any]:
    copy = folder / "copy_raster"
    subprocess.run(["cc", "-O2", ROOT / "bench/copy_raster.c", "-o", copy, "-lcups"], check=True)
    mapped = f"lcor-contrast=23.4 lcor-illuminance={light_map(folder)}"
    settings = {
        "even light": "lcor-contrast=23.4",
        "even light, texels, mean given": "lcor-contrast=23.4 lcor-reading=texel lcor-mean=0.2",
        "light map": mapped,
        "light map, texels, one pass": f"{mapped} lcor-reading=texel lcor-passes=1",
        "light map, texels, two passes": f"{mapped} lcor-reading=texel",
    }
    correct = [str(rastertolcor), "1", "u", "t", "1"]
    rows: list[list[Any]] = []
    memory = 0.0
    for name, make in PAGES.items():
        raw, out = folder / "raw", folder / "out"
        raw.write_bytes(raster.write([raster.Page(make())]))
        run([str(copy), "3"], raw, folder / "pwg")
        for kind, mode in (("raw", "1"), ("pwg", "3")):
            commands = {"copy": [str(copy), mode]}
            commands |= {setting: [*correct, words] for setting, words in settings.items()}
            costs: dict[str, list[Cost]] = {setting: [] for setting in commands}
            for _ in range(TURNS):  # in turn, so that all meet the same machine
                for setting, command in commands.items():
                    costs[setting].append(run(command, folder / kind, out))
            for setting, turns in costs.items():
                pairs = list(zip(turns, costs["copy"], strict=True))
                rows.append(
                    [
                        name,
                        kind,
                        setting,
                        statistics.median(c.elapsed for c in turns),
                        statistics.median(c.elapsed / base.elapsed for c, base in pairs),
                        statistics.median(c.processor for c in turns),
                    ]
                )
            memory = max(memory, *(peak([*correct, o], folder / kind) for o in settings.values()))
    return results.table(
        "rastertolcor: A4, 600 dpi, RGB of 8 bits",
        "From file to file in memory, in turn with a filter that only copies lines through "
        f"libcups (bench/copy_raster.c); medians of {TURNS} turns. The ratio is of elapsed time. "
        "CUPS raster is raw, PWG raster compressed. Memory at its peak, of all: "
        f"{memory:.1f} MB.",
        ["page", "raster", "filter", "elapsed s", "over copy", "processor s"],
        rows,
    )


def adaptive_mean(r: np.ndarray) -> float:
    logs = np.log(np.maximum(r, 1e-300)).ravel()
    mean, before = logs.mean(), np.inf
    while abs(mean - before) > 1e-9:
        mean, before = np.maximum(logs, mean - np.log(10)).mean(), mean
    return float(np.exp(mean))


LINEAR = np.arange(256) / 255
LINEAR = np.where(LINEAR <= 0.04045, LINEAR / 12.92, ((LINEAR + 0.055) / 1.055) ** 2.4)


def luminance(stored: np.ndarray) -> np.ndarray:
    red, green, blue = (LINEAR[stored[..., i]] for i in range(3))
    return 0.2126729 * red + 0.7151522 * green + 0.072175 * blue


def lightness(stored: np.ndarray) -> np.ndarray:
    y = luminance(stored)
    return np.where(y > (6 / 29) ** 3, 116 * np.cbrt(y) - 16, y * (29 / 3) ** 3)


XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)


def lab(stored: np.ndarray) -> np.ndarray:
    t = LINEAR[stored] @ XYZ.T / XYZ.sum(1)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * 841 / 108 + 4 / 29)
    x, y, z = (f[..., i] for i in range(3))
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


def corrected(
    rastertolcor: Path, pixels: np.ndarray, options: str, reading: str = "texel"
) -> tuple[np.ndarray, float]:
    """The page, and its mean of r."""
    options = f"lcor-contrast=23.4 lcor-reading={reading} {options}"
    done = subprocess.run(
        [rastertolcor, "1", "u", "t", "1", options],
        input=raster.write([raster.Page(pixels)]),
        capture_output=True,
        check=True,
    )
    mean = re.search(rb"r_mean ([0-9.e+-]+)", done.stderr)
    assert mean
    return raster.read(done.stdout)[0].pixels, float(mean[1])


def parts_of_a_page(rastertolcor: Path) -> dict[str, Any]:
    worst: dict[str, list[float]] = {}

    def note(source: str, error: float, shown: np.ndarray, whole: np.ndarray) -> None:
        off = np.abs(lightness(shown) - whole)
        found = (abs(error), float(off.mean()), float(np.percentile(off, 99)))
        worst[source] = [max(a, b) for a, b in zip(found, worst.get(source, found), strict=True)]

    for _, pixels in photographs(SIDE):
        r = luminance(pixels)
        exact = adaptive_mean(r)
        whole = lightness(corrected(rastertolcor, pixels, "")[0])
        means = {}
        for n in (4, 16, 64):
            small = np.asarray(Image.fromarray(pixels).reduce(n))
            means[f"preview of {SIDE // n} pixels"] = adaptive_mean(luminance(small))
        for n in (4, 16, 64):
            means[f"grid of {SIDE // n} pixels"] = adaptive_mean(r[n // 2 :: n, n // 2 :: n])
        for source, mean in means.items():
            shown, _ = corrected(rastertolcor, pixels, f"lcor-mean={mean:.12g}")
            note(source, mean / exact - 1, shown, whole)
        shown, _ = corrected(rastertolcor, pixels, "lcor-passes=1")
        note("rows so far", 0.0, shown, whole)
    return results.table(
        "A page read once: the mean of r from a part of it",
        "Worst of the photographs of mate-backgrounds, 900 pixels wide; texel reading, contrast "
        "23.4, against the mean of r over the whole page.",
        ["mean from", "error of mean", "mean dL*", "99 % of dL*"],
        [[source, *numbers] for source, numbers in worst.items()],
    )


def samples_of_a_page(rastertolcor: Path) -> dict[str, Any]:
    """Two passes take r of 2^18 pixels of a larger page: their mean against the one of all."""
    rows = []
    for name, make in PAGES.items():
        pixels = make()
        _, mean = corrected(rastertolcor, pixels, "")
        exact = adaptive_mean(luminance(pixels))
        rows.append([name, mean, exact, mean / exact - 1])
    return results.table(
        "A4 page of 600 dpi: the mean of r from 2^18 of its pixels",
        "What rastertolcor takes with two passes, against all 35 million pixels.",
        ["page", "mean", "of all pixels", "error"],
        rows,
    )


def steps_of_light(rastertolcor: Path, folder: Path) -> dict[str, Any]:
    """A page of 16 bits gets the light of each pixel."""
    options = f"lcor-illuminance={light_map(folder)}"
    rows = []
    for reading in ("patch", "texel"):
        worst = np.zeros(5)
        for _, pixels in photographs(SIDE):
            shown, mean = corrected(rastertolcor, pixels, options, reading)
            deep = pixels * np.uint16(257)
            smooth, _ = corrected(rastertolcor, deep, f"{options} lcor-mean={mean:.12g}", reading)
            smooth = np.round(smooth / 257).astype(np.uint8)
            codes = np.abs(shown.astype(int) - smooth)
            off = np.linalg.norm(lab(shown) - lab(smooth), axis=-1)
            found = [(codes > 0).mean(), (codes > 1).mean(), off.mean()]
            worst = np.maximum(worst, [*found, *np.percentile(off, [99.9, 100])])
        rows.append([reading, *map(float, worst)])
    return results.table(
        "Light in steps of 0.2 % against light of each pixel",
        f"Photographs of mate-backgrounds, {SIDE} pixels wide, 8 bits, under the light map of the "
        "first table; against the same pages of 16 bits, rounded. Worst of the photographs.",
        ["r of", "bytes that differ", "by more than 1", "mean dE", "99.9 % of dE", "largest dE"],
        rows,
    )


def main() -> None:
    rastertolcor = find_filter()
    # In memory: the disk would be measured otherwise.
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as name:
        folder = Path(name)
        tables = [throughput(rastertolcor, folder), samples_of_a_page(rastertolcor)]
        if next(photographs(SIDE), None) is not None:
            tables.append(steps_of_light(rastertolcor, folder))
            tables.append(parts_of_a_page(rastertolcor))
    results.write(tables)


if __name__ == "__main__":
    main()
