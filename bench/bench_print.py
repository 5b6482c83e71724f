# SPDX-License-Identifier: MIT
"""rastertolcor measured: its time for an A4 page of 600 dpi beside a filter that only
copies, and what it costs to correct a page that is read once instead of twice.

    bench_print.py RESULTS.json        (needs a build with -DLCOR_BUILD_CUPS=ON)
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "print"))
import raster  # noqa: E402

PHOTOGRAPHS = Path("/usr/share/backgrounds/mate/nature")
WIDTH, HEIGHT = 4960, 7016
SIDE = 900  # longer side of the photographs that stand for pages


def find_filter() -> Path:
    folders = [os.environ.get("LCOR_BINDIR", ""), "build/bench/bin", "build/release/bin"]
    for folder in folders:
        path = ROOT / folder / "rastertolcor"
        if folder and path.exists():
            return path
    sys.exit("bench_print.py: no rastertolcor; configure with -DLCOR_BUILD_CUPS=ON")


def photographs(side: int) -> list[tuple[str, np.ndarray]]:
    pictures = []
    for path in sorted(PHOTOGRAPHS.glob("*.jpg")):
        with Image.open(path) as image:
            picture = image.convert("RGB")
            picture.thumbnail((side, side))
            pictures.append((path.stem, np.asarray(picture)))
    return pictures


def page_of(picture: np.ndarray) -> np.ndarray:
    image = Image.fromarray(picture).resize((WIDTH, HEIGHT), Image.Resampling.BICUBIC)
    noise = np.random.default_rng(1).integers(-2, 3, (HEIGHT, WIDTH, 3), np.int16)
    return np.clip(np.asarray(image).astype(np.int16) + noise, 0, 255).astype(np.uint8)


def timed(command: list[str], page: Path, out: Path) -> float:
    with page.open("rb") as read, out.open("wb") as write:
        begin = time.perf_counter()
        subprocess.run(command, stdin=read, stdout=write, stderr=subprocess.DEVNULL, check=True)
        return time.perf_counter() - begin


def throughput(rastertolcor: Path, folder: Path) -> list[dict]:
    pictures = photographs(2000)
    picture = (
        pictures[0][1]
        if pictures
        else np.random.default_rng(0).integers(0, 256, (200, 140, 3), np.uint8)
    )
    pixels = page_of(picture)
    copy = folder / "copy_raster"
    subprocess.run(["cc", "-O2", ROOT / "bench/copy_raster.c", "-o", copy, "-lcups"], check=True)
    light = np.linspace(0.4, 1.8, 64, dtype="<f4")[None].repeat(64, 0)
    (folder / "light.pfm").write_bytes(b"Pf\n64 64\n-1\n" + light.tobytes())
    mapped = f"lcor-contrast=23.4 lcor-illuminance={folder}/light.pfm"
    settings = {
        "even light": "lcor-contrast=23.4",
        "light map": mapped,
        "light map, texels, one pass": f"{mapped} lcor-reading=texel lcor-passes=1",
        "light map, texels, two passes": f"{mapped} lcor-reading=texel",
    }
    rows = []
    raw = folder / "raw.ras"
    raw.write_bytes(raster.write([raster.Page(pixels)]))
    with (
        raw.open("rb") as read,
        (folder / "pwg.ras").open("wb") as write,
    ):  # Python's own packing is slow
        subprocess.run([copy, "3"], stdin=read, stdout=write, check=True)
    for kind, mode in (("raw", "1"), ("pwg", "3")):
        page, out = folder / f"{kind}.ras", folder / "out"
        best: dict[str, float] = {}
        for _ in range(3):  # in turn, so that all meet the same machine
            best["copy"] = min(best.get("copy", 1e9), timed([str(copy), mode], page, out))
            for name, options in settings.items():
                best[name] = min(
                    best.get(name, 1e9),
                    timed([str(rastertolcor), "1", "u", "t", "1", options], page, out),
                )
        rows += [
            {"raster": kind, "filter": name, "seconds": seconds, "ratio": seconds / best["copy"]}
            for name, seconds in best.items()
        ]
    return rows


def adaptive_mean(r: np.ndarray) -> float:
    logs = np.log(np.maximum(r, 1e-300)).ravel()
    mean = logs.mean()
    for _ in range(60):
        mean = np.maximum(logs, mean - np.log(10)).mean()
    return float(np.exp(mean))


def luminance(stored: np.ndarray) -> np.ndarray:
    x = stored / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4) @ [
        0.2126729,
        0.7151522,
        0.072175,
    ]


def lightness(stored: np.ndarray) -> np.ndarray:
    y = luminance(stored)
    return np.where(y > (6 / 29) ** 3, 116 * np.cbrt(y) - 16, y * (29 / 3) ** 3)


def single_pass(rastertolcor: Path) -> list[dict]:
    """The mean of r from a part of the page instead of all of it: error of the mean and of L*."""

    def corrected(pixels: np.ndarray, options: str) -> np.ndarray:
        done = subprocess.run(
            [rastertolcor, "1", "u", "t", "1", f"lcor-contrast=23.4 lcor-reading=texel {options}"],
            input=raster.write([raster.Page(pixels)]),
            capture_output=True,
            check=True,
        )
        return raster.read(done.stdout)[0].pixels

    rows = []
    for name, pixels in photographs(SIDE):
        r = luminance(pixels)
        mean, whole = adaptive_mean(r), lightness(corrected(pixels, ""))
        small = {
            f"preview of {SIDE // n} pixels": adaptive_mean(
                luminance(np.asarray(Image.fromarray(pixels).reduce(n)))
            )
            for n in (4, 16, 64)
        }
        grid = {
            f"grid of {SIDE // n} pixels": adaptive_mean(r[n // 2 :: n, n // 2 :: n])
            for n in (4, 16, 64)
        }
        for source, value in (small | grid).items():
            error = np.abs(lightness(corrected(pixels, f"lcor-mean={value:.12g}")) - whole)
            rows.append(
                {
                    "picture": name,
                    "mean from": source,
                    "error of mean": value / mean - 1,
                    "mean |dL*|": error.mean(),
                    "99 % of |dL*|": np.percentile(error, 99),
                }
            )
        one = np.abs(lightness(corrected(pixels, "lcor-passes=1")) - whole)
        rows.append(
            {
                "picture": name,
                "mean from": "rows so far",
                "error of mean": 0.0,
                "mean |dL*|": one.mean(),
                "99 % of |dL*|": np.percentile(one, 99),
            }
        )
    return rows


def worst(rows: list[dict]) -> list[dict]:
    table: dict[str, dict] = {}
    for row in rows:
        entry = table.setdefault(
            row["mean from"],
            {
                "mean from": row["mean from"],
                "error of mean": 0.0,
                "mean |dL*|": 0.0,
                "99 % of |dL*|": 0.0,
            },
        )
        for key in ("error of mean", "mean |dL*|", "99 % of |dL*|"):
            entry[key] = max(entry[key], abs(row[key]))
    return list(table.values())


def table(title: str, note: str, rows: list[dict]) -> dict:
    """As docs/accuracy.py reads it; also on the screen."""
    print(f"\n{title}")
    for row in rows:
        print(
            "  "
            + "  ".join(
                f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items()
            )
        )
    return {
        "title": title,
        "note": note,
        "columns": list(rows[0]),
        "rows": [list(row.values()) for row in rows],
        "command": "./dev bench",
    }


def main() -> None:
    rastertolcor = find_filter()
    with tempfile.TemporaryDirectory() as folder:
        speed = throughput(rastertolcor, Path(folder))
    tables = [
        table(
            "rastertolcor: A4, 600 dpi, RGB 8 bit",
            "Best of 3, in turn with a filter that only copies through libcups.",
            speed,
        )
    ]
    passes = single_pass(rastertolcor)
    if passes:
        count = len({row["picture"] for row in passes})
        tables.append(
            table(
                f"A page read once: worst of {count} photographs",
                "Texel reading, contrast 23.4, against the mean of r over the whole page.",
                worst(passes),
            )
        )
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(json.dumps({"tables": tables}, indent=1) + "\n")


if __name__ == "__main__":
    main()
