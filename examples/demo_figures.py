# SPDX-License-Identifier: MIT
"""The demo's composed pictures: the four views side by side, and Figure 5.

usage: demo_figures.py DIR
"""

import sys
from pathlib import Path

from lcor import Profile, plots
from PIL import Image, ImageDraw, ImageFont

VIEWS = [("side", "Figure 4 (a)"), ("above", "Figure 4 (b)")]
METHODS = [("corrected", "lightness correction"), ("conventional", "conventional, eq 19")]
CAPTION = 36


def comparison(folder: Path) -> Image.Image:
    """One row a view, one column a method, each with its caption."""
    pictures = {
        (view, method): Image.open(folder / f"{view}-{method}.png").convert("RGB")
        for view, _ in VIEWS
        for method, _ in METHODS
    }
    width, height = next(iter(pictures.values())).size
    sheet = Image.new("RGB", (len(METHODS) * width, len(VIEWS) * (height + CAPTION)), "white")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(22)
    for row, (view, view_title) in enumerate(VIEWS):
        for column, (method, method_title) in enumerate(METHODS):
            left, top = column * width, row * (height + CAPTION)
            draw.text(
                (left + 12, top + 6), f"{view_title}: {method_title}", fill="black", font=font
            )
            sheet.paste(pictures[view, method], (left, top + CAPTION))
    return sheet


def main() -> None:
    folder = Path(sys.argv[1])
    comparison(folder).save(folder / "comparison.png")
    contrast = Profile.load(folder / "printer.cgats").contrast
    plots.figure5(contrast=contrast).savefig(folder / "figure5.png", dpi=150)


if __name__ == "__main__":
    main()
