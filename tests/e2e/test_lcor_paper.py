# SPDX-License-Identifier: MIT
"""The paper's experiments, repeated: what section 6 says must come out."""

import json

import pytest
from lcor_run import good, oiiotool, pixels, refused, table


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper") / "out"
    good("paper", "-o", folder, "--size", "160x120")
    return folder


@pytest.fixture(scope="module")
def measured(folder):
    return json.loads((folder / "paper.json").read_text())


def test_all_experiments_are_there(folder, measured):
    for name in ("figure3a", "figure3b", "figure3c", "figure3d", "figure4a", "figure4b",
                 "figure4a_conventional", "figure4b_conventional"):
        assert "3 channel, uint8 png" in oiiotool("--info", folder / f"{name}.png")
    assert measured["contrast"] == 23.4 and measured["table3"]["patches_a_face"] == 2500
    assert measured["table3"]["solver"]["converged"]


def test_display_luminance_is_proportional_over_the_whole_contrast(measured):
    corrected, conventional = (measured["figure5"][k] for k in ("corrected", "conventional"))
    assert corrected["proportional_ratio"] >= 23.3 > measured["figure5"]["paper_proportional_ratio"]
    assert conventional["proportional_ratio"] < 2
    assert corrected["luminance_kinks"] == []


def test_the_conventional_method_bends_where_red_and_blue_saturate(measured):
    kinks = measured["figure5"]["conventional"]["luminance_kinks"]
    assert kinks == pytest.approx([255 / 250, 255 / 150], rel=0.01)


def test_hue_stays_with_the_correction_only(measured):
    assert measured["figure5"]["corrected"]["hue_drift_max_degrees"] < 0.01
    assert measured["figure5"]["conventional"]["hue_drift_max_degrees"] > 10
    assert measured["figure3"]["corrected"]["hue_drift_max_degrees"] < 0.05
    assert measured["figure3"]["conventional"]["hue_drift_max_degrees"] > 5


def test_the_curve_is_that_of_eq_9(folder, measured):
    rows = table(folder / "figure5.csv")
    low, high = (measured["figure5"][k] for k in ("shown_from", "shown_to"))
    assert high / low == pytest.approx(23.4)
    middle = (high + low) / 2  # the mean: shown as half of Jmax + Jmin
    for row in rows:
        if low < row["illuminance"] < high:
            expected = row["illuminance"] / middle * (1 + 1 / 23.4) / 2
            assert row["H_corrected"] == pytest.approx(expected, rel=1e-4)


def test_illuminance_of_figure_3_falls_from_the_lamp(folder):
    shown = pixels(folder / "figure3b.png")
    side = int(len(shown) ** 0.5)
    assert shown[int(0.4 * side) * side + int(0.35 * side)] == (255, 255, 255)
    assert shown[-1] == min(shown)


def test_refusals(tmp_path):
    refused(2, "paper", says="-o DIR")
    refused(2, "paper", "-o", tmp_path / "x", "--contrast", "1", says="--contrast")
    (tmp_path / "file").write_text("")
    refused(1, "paper", "-o", tmp_path / "file", says="in the way")
