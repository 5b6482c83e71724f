# SPDX-License-Identifier: MIT
"""Write docs/ACCURACY.md from the results of ./dev bench.

usage: accuracy.py [RESULTS=build/bench-results]
"""

from __future__ import annotations

import json
import platform
import sys
from pathlib import Path

HERE = Path(__file__).parent
HEAD = """# Accuracy, and what it costs

Every number below was measured by

```sh
./dev bench                      # results into build/bench-results
build/venv/bin/python docs/accuracy.py
```

on {machine}. Times are for comparing the lines of one table, which were taken in the same run; on
another machine they differ. Errors do not.
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
    return f"{name}, {platform.system()}"


def text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    return f"{value}".replace("*", "\\*")


def lines(table: dict) -> list[str]:
    """One table as markdown, with its command."""
    head = "| " + " | ".join(table["columns"]) + " |"
    rule = "|" + " --- |" * len(table["columns"])
    rows = ["| " + " | ".join(text(v) for v in row) + " |" for row in table["rows"]]
    note = [text(table["note"]), ""] if table.get("note") else []
    command = [f"`{table['command']}`"] if table.get("command") else []
    return [f"## {text(table['title'])}", "", *note, head, rule, *rows, "", *command, ""]


def fronts(tables: list[dict]) -> list[str]:
    """The figures of the tables that compare programs; returns what to put in the page."""
    from lcor import plots

    wanted = {
        "Irradiance of the paper's room beside other programs": ("seconds", "rms error"),
        "RGB to L*a*b* beside other libraries": ("ns/pixel", "largest dE"),
    }
    out = []
    for number, (title, (cost, error)) in enumerate(wanted.items()):
        for table in tables:
            if table["title"] != title:
                continue
            x, y = table["columns"].index(cost), table["columns"].index(error)
            points: dict[str, list[tuple[float, float]]] = {}
            for row in table["rows"]:
                points.setdefault(str(row[0]).split(",")[0], []).append((row[x], row[y]))
            name = f"images/front{number}.png"
            (HERE / "images").mkdir(exist_ok=True)
            plots.fronts(points, cost, error, title).savefig(HERE / name, dpi=100)
            out += [f"![{text(title)}]({name})", ""]
    return out


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
    page = [HEAD.format(machine=machine()), *fronts(tables)]
    for table in tables:
        page += lines(table)
    target = HERE / "ACCURACY.md"
    target.write_text("\n".join(page).rstrip() + "\n", encoding="utf-8")
    print(f"{target}: {len(tables)} tables")
    return 0


if __name__ == "__main__":
    sys.exit(main())
