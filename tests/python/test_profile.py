# SPDX-License-Identifier: MIT
import copy
import os
import pickle

import lcor
import pytest


@pytest.fixture
def profile():
    profile = lcor.Profile()
    for white, black in [(0.07, 1.44), (0.08, 1.43), (0.07, 1.45)]:
        profile.add(rgb=(255, 255, 255), visual=white, name="white")
        profile.add(rgb=(0, 0, 0), visual=black)
    profile.set_keyword("MATERIAL", "glossy paper")
    return profile


def test_contrast_follows_from_the_readings(profile):
    result = profile.evaluate()
    assert (result["d_min"], result["d_max"]) == (0.07, 1.44)
    assert profile.contrast == pytest.approx(lcor.contrast_from_density(1.44, 0.07))
    assert profile.contrast_u95 > 0 and (result["n_min"], result["n_max"]) == (3, 3)


def test_text_comes_back_the_same(profile, tmp_path):
    path = tmp_path / "printer.cgats"
    profile.save(path)
    again = lcor.Profile.load(path)
    assert again.format() == profile.format() == path.read_bytes()
    assert again.contrast == profile.contrast
    assert again.keywords["MATERIAL"] == "glossy paper"
    assert [r.visual for r in again.readings] == [r.visual for r in profile.readings]
    assert again.readings[0].rgb == (255, 255, 255) and again.readings[0].name == "white"
    assert again.readings[0].xyz is None and not again.readings[0].rejected
    assert os.listdir(tmp_path) == ["printer.cgats"]


def test_profiles_travel(profile):
    for again in (pickle.loads(pickle.dumps(profile)), copy.deepcopy(profile)):
        assert again.format() == profile.format() and again.black == profile.black


def test_a_failed_save_leaves_the_old_file(profile, tmp_path):
    path = tmp_path / "printer.cgats"
    path.write_text("old")
    with pytest.raises(ValueError):
        lcor.Profile().save(path)
    assert path.read_text() == "old" and os.listdir(tmp_path) == ["printer.cgats"]


def test_save_writes_what_a_link_leads_to(profile, tmp_path):
    path = tmp_path / "printer.cgats"
    path.write_text("old")
    for name, target in (("link", path), ("device", os.devnull)):
        (tmp_path / name).symlink_to(target)
        profile.save(tmp_path / name)
        assert (tmp_path / name).is_symlink()
    assert path.read_bytes() == profile.format()
    with pytest.raises(FileNotFoundError) as raised:
        profile.save(tmp_path / "none" / "p.cgats")
    assert raised.value.filename == str(tmp_path / "none" / "p.cgats")


def test_rejected_readings_take_no_part(profile):
    profile.add(rgb=(0, 0, 0), visual=3.0)
    profile.reject(6)
    assert profile.readings[6].rejected
    assert profile.evaluate()["n_max"] == 3
    profile.reject(6, False)
    assert profile.evaluate()["n_max"] == 4


def test_grey_ramps_give_a_tone_curve(profile):
    with pytest.raises(ValueError):
        profile.tone_curve(16)
    for level in (64, 128, 192):
        profile.add(rgb=(level,) * 3, visual=1.44 - 1.37 * level / 255)
    assert profile.grey_levels == 3
    curve = profile.tone_curve(16)
    assert curve[0] == 0 and curve[-1] == 1 and (curve[1:] >= curve[:-1]).all()
    lcor.Plan(profile.contrast, 0.5, tone_curve=curve)


def test_measurements_of_other_programs(source):
    path = source / "tests/data/device/FOGRA39L.ti3"
    profile = lcor.Profile.load(path, black="darkest")
    assert profile.contrast > 10 and profile.black == "darkest"


@pytest.mark.parametrize(
    "text, error", [("", lcor.FormatError), ("CGATS.17\nnothing\n", lcor.FormatError)]
)
def test_broken_texts_are_refused(tmp_path, text, error):
    path = tmp_path / "broken.cgats"
    path.write_text(text)
    with pytest.raises(error, match=r"broken\.cgats: "):
        lcor.Profile.load(path)
    assert issubclass(error, ValueError)


def test_bad_readings_are_refused(profile):
    with pytest.raises(ValueError):
        profile.add(rgb=(0, 0, 0))
    with pytest.raises(ValueError, match="rgb takes 3 numbers"):
        profile.add(rgb=(0, 0), visual=1.0)
    with pytest.raises(ValueError):
        profile.add(rgb=(0, 0, 0), visual=float("nan"))
    with pytest.raises(ValueError, match="LCOR"):
        profile.set_keyword("LCOR_CONTRAST", "1")
    with pytest.raises(FileNotFoundError):
        lcor.Profile.load("no such file")
