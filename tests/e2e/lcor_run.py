# SPDX-License-Identifier: MIT
"""Running lcor and reading what it wrote, for the end-to-end tests."""

from __future__ import annotations

import csv
import json
import os
import re
import struct
import subprocess
from pathlib import Path

LCOR = Path(os.environ["LCOR_BINDIR"]) / "lcor"
SANITIZED = b"__asan_init" in LCOR.read_bytes()
DATA = Path(__file__).parent.parent / "data"


def lcor(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(LCOR), *map(str, arguments)], capture_output=True, text=True, timeout=200, **options
    )


def good(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    run = lcor(*arguments, **options)
    assert run.returncode == 0, run.stderr
    return run


def report(*arguments: object) -> dict:
    """The JSON document of a run that must succeed."""
    return json.loads(good(*arguments, "--json").stdout)


def refused(code: int, *arguments: object, says: str = "", **options: object) -> str:
    """A run that must fail with this exit code and one line on stderr; returns the line."""
    run = lcor(*arguments, **options)
    assert run.returncode == code, (run.returncode, run.stderr)
    lines = [line for line in run.stderr.splitlines() if "warning" not in line]
    assert len(lines) == 1 and lines[0].startswith("lcor: "), run.stderr
    assert says in lines[0], lines[0]
    return lines[0]


def table(path: Path) -> list[dict[str, float]]:
    with path.open() as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def write_pfm(path: Path, rows: list[list]) -> Path:
    """Floats as a portable float map: numbers give one channel, triples three."""
    colour = isinstance(rows[0][0], (tuple, list))
    flat = [x for row in reversed(rows) for pixel in row for x in (pixel if colour else (pixel,))]
    header = f"P{'F' if colour else 'f'}\n{len(rows[0])} {len(rows)}\n-1.0\n"
    path.write_bytes(header.encode() + struct.pack(f"<{len(flat)}f", *flat))
    return path


def pixels(path: Path) -> list[tuple[float, ...]]:
    """Stored samples of a picture, row by row, as OpenImageIO's own tool prints them."""
    run = subprocess.run(
        ["oiiotool", "--dumpdata", str(path)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    found = re.findall(r"Pixel \(\d+, \d+\):([-+.\de ]*)", run.stdout)
    return [tuple(float(x) for x in line.split()) for line in found]


def oiiotool(*arguments: object) -> str:
    return subprocess.run(
        ["oiiotool", *map(str, arguments)], capture_output=True, text=True, check=True, timeout=60
    ).stdout
