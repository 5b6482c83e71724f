# SPDX-License-Identifier: MIT
"""What the Python benches share: timing by the best of several runs, and the file of results."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any


def best(
    call: Callable[[], Any],
    repeat: int = 5,
    least: float = 0.0,
    clock: Callable[[], float] = time.process_time,
) -> float:
    """Seconds of the fastest of `repeat` runs, each repeated until it takes `least` seconds.

    The processor's time unless told otherwise: other programs on the machine count less.
    """
    call()
    times = []
    for _ in range(repeat):
        number, start = 0, clock()
        while True:
            call()
            number += 1
            spent = clock() - start
            if spent >= least:
                break
        times.append(spent / number)
    return min(times)


def rounded(value: Any) -> Any:
    """Three significant digits of a number."""
    return float(f"{value:.3g}") if isinstance(value, float) else value


def table(
    title: str, note: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]
) -> dict[str, Any]:
    """One table of docs/ACCURACY.md; printed as it is made."""
    rows = [[rounded(value) for value in row] for row in rows]
    print(f"\n{title}\n{note}", flush=True)
    for row in [columns, *rows]:
        print("  ".join(f"{value!s:>18}" for value in row), flush=True)
    command = f"build/venv/bin/python bench/{Path(sys.argv[0]).name} RESULTS.json"
    return {
        "title": title,
        "note": note,
        "columns": list(columns),
        "rows": rows,
        "command": command,
    }


def write(tables: Sequence[dict[str, Any]]) -> None:
    """The file named on the command line."""
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(json.dumps({"tables": list(tables)}, indent=1) + "\n")
