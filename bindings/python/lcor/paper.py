# SPDX-License-Identifier: MIT
"""The paper's experiments, run: ``python -m lcor.paper -o DIR``.

Writes the figures, and a table of the paper's claims beside what is measured here. A claim that is
not reproduced is said to be so.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import lcor

#: The paper's contrast (5.1) and colour (table 4).
CONTRAST = 23.4
COLOUR = (250 / 255, 50 / 255, 150 / 255)


class Claim(NamedTuple):
    """One line of the table."""

    where: str
    claim: str
    measured: str
    agreement: str  # "yes", "no", or how far


def contrast() -> Claim:
    """5.1: the contrast of the printer, from two densities."""
    c = lcor.contrast_from_density(0.07 + math.log10(CONTRAST), 0.07)
    return Claim(
        "5.1",
        "contrast c = 23.4 from the greatest and least density",
        f"densities {math.log10(CONTRAST):.4f} apart give c = {c:.4f}",
        "yes" if abs(c / CONTRAST - 1) < 1e-12 else "no",
    )


def proportional_range(light: NDArray[Any], luminance: NDArray[Any]) -> tuple[float, float]:
    """Ends of the range around 1 where luminance is illuminance within a millionth."""
    follows = light[np.abs(luminance / light - 1) <= 1e-6]
    return float(follows.min()), float(follows.max())


def fine_sweep() -> dict[str, NDArray[Any]]:
    """Table 4's colour under 40001 illuminances over 8^-1.5..8^1.5."""
    from lcor import plots

    return plots.sweep(CONTRAST, COLOUR, 8.0 ** np.linspace(-1.5, 1.5, 40001))


def luminance_claims(data: dict[str, NDArray[Any]]) -> list[Claim]:
    """Figure 5 (a): how far display luminance follows illuminance."""
    light = data["illuminance"]
    low, high = proportional_range(light, data["new_luminance"])
    powers = f"8^{math.log(low, 8):.3f} .. 8^{math.log(high, 8):.3f}"
    wide = high / low
    paper_high = 8 ** (2 / 3)
    j1, j2 = lcor.adapt_range(1.0, 1.0, CONTRAST)
    mean = paper_high / j2
    slope = np.gradient(np.log(data["old_luminance"]), np.log(light))
    r, b = 1 / COLOUR[0], 1 / COLOUR[2]
    slopes = [float(np.interp(x, light, slope)) for x in (0.98 * r, 1.02 * r, 0.98 * b, 1.02 * b)]
    return [
        Claim(
            "6, fig. 5a",
            "display luminance follows illuminance over a wide range: a ratio of "
            f"{paper_high * 8**0.5:.1f} (8^-1/2 .. 8^2/3)",
            f"a ratio of {wide:.2f} ({powers} of the mean); the model's limit is c = {CONTRAST}",
            "yes" if wide >= 23 else "no",
        ),
        Claim(
            "6, fig. 5a",
            "the range is 8^-1/2 .. 8^2/3 of the illuminance axis",
            f"with the mean at illuminance 1 the upper end is {high:.3f} = "
            f"8^{math.log(high, 8):.3f}, "
            f"not {paper_high:.0f} = 8^2/3; a mean at {mean:.2f} would give "
            f"{mean * j1:.3f} .. {mean * j2:.3f}, which holds the paper's range. The paper does "
            f"not "
            "print the illuminances of figure 3 (b) nor their mean",
            "not reproduced as printed: the width is, the place needs a mean that is not given",
        ),
        Claim(
            "6, fig. 5a",
            "the conventional method does not follow once R saturates (illuminance about 1)",
            "d ln H / d ln I falls from {:.2f} to {:.2f} where R saturates, and is {:.2f} and "
            "{:.2f} "
            "about B's saturation; 1 would be proportional. Below saturation it is not 1 either, "
            "since the device's black shows Jmin (eq 10)".format(*slopes),
            "yes" if slopes[1] < 0.8 * slopes[0] else "no",
        ),
    ]


def kinks(light: NDArray[Any], values: NDArray[Any], count: int) -> list[float]:
    """Where the slope of a curve over ln(light) jumps most."""
    slope = np.diff(values) / np.diff(np.log(light))
    jump = np.abs(np.diff(slope))
    jump[~np.isfinite(jump)] = 0
    found: list[float] = []
    for i in np.argsort(jump)[::-1]:
        if all(abs(math.log(light[i + 1] / f)) > 0.02 for f in found):
            found.append(float(light[i + 1]))
        if len(found) == count:
            break
    return sorted(found)


def hue_claims(data: dict[str, NDArray[Any]]) -> list[Claim]:
    """Figure 5 (b): hue."""
    light = data["illuminance"]
    hue = float(np.degrees(lcor.hue(lcor.rgb_to_lab(COLOUR))))
    lab = lcor.rgb_to_lab(data["new_rgb"])
    coloured = np.asarray(lcor.chroma(lab)) > 1e-3
    drift = float(np.abs(np.degrees(np.asarray(lcor.hue(lab)))[coloured] - hue).max())
    r, g, b = (1 / value for value in COLOUR)
    before = light < 0.99 * g
    bends = kinks(light[before], data["old_hue"][before], 2)
    at = [float(np.interp(x, light, data["old_hue"])) for x in (r, b)]
    close = all(abs(found / want - 1) < 0.005 for found, want in zip(bends, (r, b)))
    return [
        Claim(
            "6, fig. 5b",
            "the correction keeps hue constant under every illuminance",
            f"largest drift {drift:.1e} degrees (float64, chroma above 0.001)",
            "yes" if drift < 1e-6 else "no",
        ),
        Claim(
            "6, fig. 5b",
            "the conventional method turns hue abruptly where R and B saturate",
            f"R = 255 at illuminance {r:.3f}, B = 255 at {b:.3f}; kinks found at "
            f"{bends[0]:.3f} and {bends[1]:.3f}; hue goes from {hue:.1f} to {at[1]:.1f} degrees "
            f"between them. G saturates too, at {g:.2f}, which the paper does not mention",
            "yes" if close else "no",
        ),
    ]


def clipped_turn() -> float:
    """Largest turn of hue when colours out of gamut are clipped instead."""
    rho = float(lcor.lab_to_rgb([float(lcor.rgb_to_lab(COLOUR)[0]), 0.0, 0.0])[0])
    plan = lcor.Plan(CONTRAST, rho, rho, gamut="clip")
    lab = lcor.rgb_to_lab(plan.apply(COLOUR, np.linspace(0.1, 1.9, 20001))[0])
    turn = np.asarray(lcor.hue(lab)) - float(lcor.hue(lcor.rgb_to_lab(COLOUR)))
    return float(np.abs(np.degrees(turn))[np.asarray(lcor.chroma(lab)) > 1e-3].max())


def chroma_claims(data: dict[str, NDArray[Any]]) -> list[Claim]:
    """Figure 5 (c): chroma."""
    light, chroma = data["illuminance"], data["new_chroma"]
    peak, change = int(np.argmax(chroma)), np.diff(chroma)
    r, g, b = (1 / value for value in COLOUR)
    before = light < 0.99 * g
    bends = kinks(light[before], data["old_chroma"][before], 2)
    close = all(abs(found / want - 1) < 0.005 for found, want in zip(bends, (r, b)))
    high = lcor.adapt_range(1.0, 1.0, CONTRAST)[1]
    white = light[(data["new_rgb"] >= 1 - 1e-12).all(axis=1)]
    saturated = light[(data["new_rgb"] >= 1 - 1e-12).any(axis=1)]
    return [
        Claim(
            "6, fig. 5c",
            "chroma falls on both sides of the original lightness (eq 16)",
            f"peak {chroma[peak]:.2f} at illuminance {light[peak]:.3f} of the mean, the "
            f"texture's own "
            f"chroma being {float(lcor.chroma(lcor.rgb_to_lab(COLOUR))):.2f}",
            "yes" if (change[:peak] > -1e-9).all() and (change[peak:] < 1e-9).all() else "no",
        ),
        Claim(
            "6, fig. 5c",
            "the conventional method's chroma changes abruptly where R and B saturate",
            f"kinks found at {bends[0]:.3f} and {bends[1]:.3f}; R = 255 at {r:.3f}, B = 255 at "
            f"{b:.3f}",
            "yes" if close else "no",
        ),
        Claim(
            "6",
            "the correction saturates only where display luminance is that of white",
            f"white from illuminance {float(white.min()):.3f} on (J2 = {high:.3f}); a channel "
            f"reaches "
            f"1 from {float(saturated.min()):.3f} on, where the gamut rule lowers chroma; "
            f"clipping that "
            f"channel instead would turn hue by {clipped_turn():.2f} degrees",
            "yes for lightness; R needs the gamut rule just below white"
            if abs(float(white.min()) / high - 1) < 1e-3
            else "no",
        ),
    ]


def tiles() -> NDArray[Any]:
    """A texture for figure 3: tiles of every hue with a little grain, (120, 160, 3)."""
    random = np.random.default_rng(7)
    lab = np.empty((6, 8, 3))
    angle = random.permutation(48) * (2 * np.pi / 48)
    lab[..., 0] = random.uniform(45, 80, (6, 8))
    lab[..., 1] = 40 * np.cos(angle).reshape(6, 8)
    lab[..., 2] = 40 * np.sin(angle).reshape(6, 8)
    grain = random.normal(0, 0.02, (120, 160, 1))
    flat = np.kron(lcor.lab_to_rgb(lab, "srgb", transfer="srgb"), np.ones((20, 20, 1)))
    return np.clip(flat + grain, 0, 1)


def lamp() -> NDArray[Any]:
    """Illuminance for figure 3: a lamp before a wall, (120, 160)."""
    scene = lcor.Scene()
    wall = scene.add_quad((0, 0.75, 0), (0, -0.75, 0), (1, 0, 0), patches=(120, 160))
    scene.add_point_light((0.35, 0.35, 0.5))
    return lcor.solve_radiosity(scene).irradiance(wall)


def room() -> tuple[lcor.Scene, list[int]]:
    """Table 3: a cubic room, 2500 patches a face, one point light."""
    scene = lcor.Scene()
    faces = [
        ((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.3),
        ((0, 0, 1), (0, 1, 0), (1, 0, 0), 0.8),
        ((0, 0, 0), (0, 1, 0), (0, 0, 1), 0.5),
        ((1, 0, 0), (0, 0, 1), (0, 1, 0), 0.5),
        ((0, 0, 0), (0, 0, 1), (1, 0, 0), 0.5),
        ((0, 1, 0), (1, 0, 0), (0, 0, 1), 0.5),
    ]
    surfaces = [scene.add_quad(o, u, v, rho, patches=(50, 50)) for o, u, v, rho in faces]
    scene.add_point_light((0.3, 0.4, 0.7), 1.0)
    return scene, surfaces


def room_claims() -> list[Claim]:
    """5.4 and figure 4: radiosity of the room, and what eq 19 and the correction make of it."""
    scene, surfaces = room()
    solution = lcor.solve_radiosity(scene, tolerance=1e-3)
    report = solution.report
    light = np.stack([solution.irradiance(s) for s in surfaces])
    texture = np.random.default_rng(1).random((*light.shape, 3)) * 0.9 + 0.05
    before = lcor.rgb_to_lab(texture)
    new = lcor.rgb_to_lab(lcor.correct(texture, light, CONTRAST, rho=0.5))
    mean = lcor.picture_mean(texture, light, 0.5) / 0.5
    old = lcor.rgb_to_lab(lcor.conventional(texture, light / mean, 1.0))
    turns = []
    for after in (new, old):
        coloured = np.minimum(lcor.chroma(before), lcor.chroma(after)) > 1
        turn = np.degrees(np.asarray(lcor.hue(after)) - np.asarray(lcor.hue(before)))
        turns.append(np.abs((turn + 180) % 360 - 180)[coloured])
    return [
        Claim(
            "5.4, table 3",
            "a cubic room of 2500 patches a face with one point light is solved by radiosity",
            f"estimated error {report['error_rms']:.1e} rms, energy defect "
            f"{report['energy_defect']:.0e}; irradiance from {light.min():.2f} to "
            f"{light.max():.2f}, "
            f"a ratio of {light.max() / light.min():.1f}",
            "yes" if report["converged"] else "no",
        ),
        Claim(
            "6, figs 3 and 4",
            "under a room's illuminance hue shifts visibly with eq 19, not with the correction",
            f"random texels on its {light.size} patches: hue turns by {turns[1].max():.0f} "
            f"degrees at "
            f"most and by more than 5 in {100 * float((turns[1] > 5).mean()):.0f} % with eq 19; by "
            f"{turns[0].max():.0e} at most with the correction",
            "yes" if turns[0].max() < 1e-6 < 5 < turns[1].max() else "no",
        ),
    ]


def claims() -> list[Claim]:
    """The whole table."""
    data = fine_sweep()
    parts: list[Callable[[dict[str, NDArray[Any]]], list[Claim]]] = [
        luminance_claims,
        hue_claims,
        chroma_claims,
    ]
    return [contrast(), *(claim for part in parts for claim in part(data)), *room_claims()]


def write_tables(rows: list[Claim], directory: Path) -> None:
    """claims.csv and claims.md."""
    with open(directory / "claims.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(Claim._fields)
        writer.writerows(rows)
    lines = [
        "| where | the paper's claim | measured here | agreement |",
        "| --- | --- | --- | --- |",
    ]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    (directory / "claims.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_figures(directory: Path) -> list[tuple[str, str]]:
    """The figures; returns their names and what they are."""
    from lcor import plots

    scene, surfaces = room()
    floor = lcor.solve_radiosity(scene, tolerance=1e-3).irradiance(surfaces[0])
    seen_from_above = floor.T[::-1]  # x to the right, y up
    figures = [
        ("figure1.png", "adaptation, eq 8", plots.adaptation(CONTRAST)),
        ("figure2.png", "chroma against lightness, eq 16", plots.chroma_rule()),
        (
            "figure3.png",
            "texture, illuminance, eq 19 and the correction, with how they turn hue",
            plots.figure3(tiles(), lamp(), CONTRAST),
        ),
        (
            "figure4-floor.png",
            "illuminance of the room's floor",
            plots.false_colour(
                seen_from_above, "flux / area, lamp of intensity 1", "the room's floor from above"
            ),
        ),
        (
            "figure5.png",
            "luminance, hue and chroma against illuminance",
            plots.figure5(CONTRAST, COLOUR),
        ),
    ]
    for name, _, figure in figures:
        figure.savefig(directory / name)
    return [(name, what) for name, what, _ in figures]


def main(arguments: list[str] | None = None) -> int:
    """The command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m lcor.paper", description=__doc__)
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="made if missing"
    )
    directory: Path = parser.parse_args(arguments).output
    try:
        directory.mkdir(parents=True, exist_ok=True)
        rows = claims()
        write_tables(rows, directory)
        figures = write_figures(directory)
    except (OSError, ImportError) as error:
        print(f"lcor.paper: {error}", file=sys.stderr)
        return 1
    for row in rows:
        print(f"{row.where}: {row.claim}\n    {row.measured}\n    reproduced: {row.agreement}")
    for name, what in [
        *figures,
        ("claims.md", "this table"),
        ("claims.csv", "the same for programs"),
    ]:
        print(f"{directory / name}: {what}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
