# SPDX-License-Identifier: MIT
"""The paper's claims, and the figures; skipped where matplotlib is missing."""

import csv
import subprocess
import sys

import lcor
import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="matplotlib is not installed (pip install lcor[plots])")
from lcor import paper, plots


@pytest.fixture(scope="module")
def data():
    return paper.fine_sweep()


def test_luminance_is_proportional_over_the_whole_contrast(data):
    low, high = paper.proportional_range(data["illuminance"], data["new_luminance"])
    assert 23 <= high / low <= 23.4


def test_hue_does_not_drift(data):
    lab = lcor.rgb_to_lab(data["new_rgb"])
    coloured = lcor.chroma(lab) > 1e-3
    hue = np.degrees(lcor.hue(lab))[coloured]
    assert np.ptp(hue) < 1e-6


def test_eq_19_bends_where_channels_saturate(data):
    light = data["illuminance"]
    below = light < 5
    for curve in ("old_hue", "old_chroma"):
        bends = paper.kinks(light[below], data[curve][below], 2)
        np.testing.assert_allclose(bends, [255 / 250, 255 / 150], rtol=0.005)
    below = light < 1.9
    smooth = np.diff(data["new_chroma"][below]) / np.diff(np.log(light[below]))
    peak = np.argmax(data["new_chroma"])
    assert light[peak] == pytest.approx(0.955, abs=0.01) and data["new_chroma"][peak] < 67.1
    assert np.abs(np.diff(smooth)).max() < 200


def test_the_command_writes_every_claim(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "lcor.paper", "-o", str(tmp_path / "new")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "new" / "claims.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 11
    unlike = [row for row in rows if row["agreement"] == "no"]
    assert not unlike
    assert any("not reproduced as printed" in row["agreement"] for row in rows)
    figures = ("1", "2", "3", "4-floor", "5")
    for name in (*(f"figure{number}.png" for number in figures), "claims.md"):
        assert (tmp_path / "new" / name).stat().st_size > 500
        assert name in done.stdout


def test_the_command_says_what_it_could_not_write(tmp_path):
    (tmp_path / "file").write_text("")
    done = subprocess.run(
        [sys.executable, "-m", "lcor.paper", "-o", str(tmp_path / "file")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1


def test_hue_turns_with_eq_19_and_not_with_the_correction():
    tiles, light = paper.tiles(), paper.lamp()
    assert light.max() / light.min() > 4
    new = lcor.correct(tiles, light, 23.4, space="srgb", transfer="srgb")
    old = lcor.conventional(tiles, light / light.mean(), space="srgb", transfer="srgb")
    assert np.abs(plots.hue_change(tiles, new)).max() < 1e-6
    assert np.abs(plots.hue_change(tiles, old)).max() > 10
    assert plots.hue_change([0.5, 0.5, 0.5], [0.5, 0.1, 0.1]) == 0  # grey has no hue
    red, pink = [[0.6, 0.2, 0.2 + d] for d in (-0.01, 0.01)]
    turns = plots.hue_change(red, pink), plots.hue_change(pink, red)
    assert turns[0] == -turns[1] and 0 < abs(turns[0]) < 10


def test_every_plot_draws(tmp_path):
    random = np.random.default_rng(0)
    texture, light = random.random((12, 16, 3)), random.random((12, 16)) + 0.01
    plan = lcor.Plan(23.4, lcor.picture_mean(texture, light))
    profile = lcor.Profile()
    for visual in (0.07, 0.08):
        profile.add(rgb=(255, 255, 255), visual=visual)
        profile.add(rgb=(0, 0, 0), visual=visual + 1.37)
    scene, _ = paper.room()
    figures = {
        "before-after": plots.before_after(texture, plan.apply(texture, light)[0]),
        "figure3": plots.figure3(texture, light),
        "masks": plots.masks(plan, texture, light * 5),
        "false-colour": plots.false_colour(light, "lx"),
        "repeatability": plots.repeatability(profile),
        "convergence": plots.convergence(scene, (0.1, 0.03)),
        "fronts": plots.fronts({"lcor": [(1, 1e-3), (2, 1e-5)], "other": [(3, 1e-3)]}, "s", "dE"),
        "adaptation": plots.adaptation(),
        "chroma": plots.chroma_rule(),
    }
    for name, figure in figures.items():
        figure.savefig(tmp_path / f"{name}.png", dpi=40)
    with pytest.raises(ValueError, match="no pixel is lit"):
        plots.false_colour(np.zeros((2, 2)))
