# SPDX-License-Identifier: MIT
"""The demo's composed pictures: the views side by side, the readings, and Figure 5.

usage: demo_figures.py DIR
"""

import sys
from pathlib import Path

import numpy as np
from lcor import Profile, plots
from matplotlib.figure import Figure
from PIL import Image

VIEWS = {"side": "Figure 4 (a)", "above": "Figure 4 (b)"}
COLUMNS = {
    "illuminance": "illuminance [lx]",
    "corrected": "lightness correction",
    "conventional": "conventional, eq 19",
}


def comparison(folder: Path) -> Figure:
    """One row a view; the last column is the hue of eq 19 against that of the correction."""
    figure = Figure(figsize=(17.0, 6.6), dpi=150, layout="constrained")
    axes = figure.subplots(2, 4)
    for row, (view, name) in zip(axes, VIEWS.items()):
        pictures = {
            column: np.asarray(Image.open(folder / f"{view}-{column}.png").convert("RGB"))
            for column in COLUMNS
        }
        for ax, (column, title) in zip(row, COLUMNS.items()):
            ax.imshow(pictures[column])
            ax.set_title(f"{name}: {title}", fontsize=11)
            ax.set_axis_off()
        change = plots.hue_change(pictures["corrected"], pictures["conventional"], least_chroma=5)
        turned = plots.show_hue_change(row[3], change, f"{name}: hue turned by eq 19")
        row[3].title.set_fontsize(11)
    figure.colorbar(turned, ax=axes[:, 3], shrink=0.6, extend="both").set_label("degrees")
    return figure


def main() -> None:
    folder = Path(sys.argv[1])
    profile = Profile.load(folder / "printer.cgats")
    comparison(folder).savefig(folder / "comparison.png")
    plots.repeatability(profile).savefig(folder / "measurement.png")
    plots.figure5(contrast=profile.contrast).savefig(folder / "figure5.png")


if __name__ == "__main__":
    main()
