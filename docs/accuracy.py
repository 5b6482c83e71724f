# SPDX-License-Identifier: MIT
"""Write docs/ACCURACY.md from the results of ./dev bench.

usage: accuracy.py [RESULTS=build/bench-results]
"""

from __future__ import annotations

import json
import os
import platform
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
HEAD = """# Accuracy, and what it costs

Every number below was measured by

```sh
./dev bench                      # results into build/bench-results
build/venv/bin/python docs/accuracy.py
```

on {machine}.
Times are for comparing the lines of one table, which were taken in the same run; on another machine
they differ. Errors do not.
"""


def machine() -> str:
    """The processor and system the numbers are from."""
    name = platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{name}, {os.cpu_count()} processors, {platform.system()}"


def text(value: object) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{value:.3g}"
    return f"{value}".replace("*", "\\*").replace("|", "\\|")


def lines(table: dict) -> list[str]:
    """One table as markdown, with its command."""
    head = "| " + " | ".join(table["columns"]) + " |"
    rule = "|" + " --- |" * len(table["columns"])
    rows = ["| " + " | ".join(text(v) for v in row) + " |" for row in table["rows"]]
    note = [text(table["note"]), ""] if table.get("note") else []
    command = [f"`{table['command']}`"] if table.get("command") else []
    title = f"## {text(table['title'])}"
    return [title, "", *note, *front(table), head, rule, *rows, "", *command, ""]


#: A table that has one column of each is drawn too: what it costs, and how wrong it is.
COSTS = ("ns/pixel", "seconds", "ms", "with patches, s", "solve, s")
ERRORS = ("rms error", "largest dE", "true rms", "rms", "rms at points")


def weighed(columns: list[str]) -> list[tuple[str, str, str]]:
    """Who is weighed in a table, by which column of cost and of error. Programs side by side have
    columns of their own, "NAME, s" and "NAME rms"; otherwise each row says who it is."""
    names = [column[:-3] for column in columns if column.endswith(", s")]
    found = [(name, f"{name}, s", f"{name} rms") for name in names if f"{name} rms" in columns]
    if found:
        return found
    cost = next((name for name in COSTS if name in columns), None)
    error = next((name for name in ERRORS if name in columns), None)
    return [("", cost, error)] if cost and error else []


def front(table: dict) -> list[str]:
    """The figure of a table that weighs speed against accuracy, if it is one; its markdown."""
    from lcor import plots

    points: dict[str, list[tuple[float, float]]] = {}
    cost = error = ""
    for program, cost, error in weighed(table["columns"]):
        x, y = table["columns"].index(cost), table["columns"].index(error)
        for row in table["rows"]:
            if all(isinstance(row[i], (int, float)) and row[i] > 0 for i in (x, y)):
                name = row[0].split(",")[0] if isinstance(row[0], str) else "lcor"
                name = f"{program}, {name}" if program else name
                points.setdefault(name, []).append((row[x], row[y]))
        if program:
            cost, error = "seconds", "rms error"
    if sum(map(len, points.values())) < 3:
        return []
    name = "-".join(re.findall(r"[a-z0-9]+", table["title"].lower())[:8])
    target = HERE / "images" / f"front-{name}.png"
    target.parent.mkdir(exist_ok=True)
    plots.fronts(points, cost, error, table["title"]).savefig(target, dpi=90)
    return [f"![{text(table['title'])}](images/{target.name})", ""]


def main() -> int:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/bench-results")
    tables: list[dict] = []
    for path in sorted(folder.glob("*.json")):
        found = json.loads(path.read_text())
        if isinstance(found, dict):
            tables += found.get("tables", [])
    if not tables:
        print(f"accuracy.py: no tables in {folder}: run ./dev bench first", file=sys.stderr)
        return 2
    for old in (HERE / "images").glob("front*.png"):
        old.unlink()
    page = [HEAD.format(machine=machine())]
    for table in tables:
        page += lines(table)
    target = HERE / "ACCURACY.md"
    target.write_text("\n".join(page).rstrip() + "\n", encoding="utf-8")
    print(f"{target}: {len(tables)} tables")
    return 0


if __name__ == "__main__":
    sys.exit(main())
