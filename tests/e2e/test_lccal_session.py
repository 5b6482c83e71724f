# SPDX-License-Identifier: MIT
"""A measurement from the first prompt to the stored profile."""

import math

import pytest
from lccal_bench import Emulator, Session, comma_environment, events, keyword, lccal, rows


def contrast(path):
    return float(keyword(path, "LCOR_CONTRAST"))


def test_contrast_is_what_the_print_has(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 5, "--contrast", 23.4) as device:
        run = lccal("--port", device.port, "--yes", "-o", profile)
    assert run.returncode == 0, run.stderr
    assert run.stdout == ""
    assert contrast(profile) == pytest.approx(23.4, abs=1e-4)
    assert keyword(profile, "INSTRUMENTATION") == (
        "Dektronics Printalyzer Densitometer, serial 0123456789ABCDEF01234567, firmware v1.1.0"
    )
    assert len(rows(profile)) == 10
    assert [path.name for path in tmp_path.iterdir()] == ["p.cgats"]


def test_extended_format_gives_more_digits_than_the_display(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 1, "--dmin", 0.0712, "--dmax", 1.4387) as device:
        run = lccal("--port", device.port, "--yes", "--readings", 1, "-o", profile)
    assert run.returncode == 0, run.stderr
    assert float(rows(profile)[0][5]) == pytest.approx(0.0712, abs=1e-6)


def test_equal_readings_are_known_no_better_than_the_instrument_resolves(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 5) as device:
        run = lccal("--port", device.port, "--yes", "-o", profile)
    assert run.returncode == 0, run.stderr
    # Two patches, each rounded to 0.001 D: u = 0.001 / sqrt(12) of each.
    u95 = 1.96 * 23.4 * math.log(10) * 0.001 * math.sqrt(2 / 12)
    assert float(keyword(profile, "LCOR_CONTRAST_U95")) == pytest.approx(u95, rel=1e-3)


def test_black_first_is_recognised(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 2, "--order", "bw") as device:
        run = lccal("--port", device.port, "--yes", "--readings", 2, "-o", profile)
    assert run.returncode == 0, run.stderr
    assert [row[1] for row in rows(profile)] == ["black", "black", "white", "white"]
    assert contrast(profile) == pytest.approx(23.4, abs=1e-4)


def test_white_is_asked_for_when_black_came_first(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "--readings", 2,
                                       "-o", profile) as session:
        # black for white, mixed black, black, black again instead of white, white
        for pressed in ((1.44, 0.07), (1.44, 1.44), (1.44, 1.44), (0.07, 0.07)):
            session.until("prompt", patch="white")
            session.answer()
            session.until("ready")
            device.press(*pressed)
        assert session.end() == 0, session.errors
    told = [(event["patch"], event["density"]) for event in session.seen
            if event["event"] == "reading"]
    assert told == [("black", 1.44), ("black", 0.07), ("black", 1.44), ("black", 1.44),
                    ("white", 1.44), ("white", 1.44), ("white", 0.07), ("white", 0.07)]
    assert [(row[1], row[-1]) for row in rows(profile) if row[-1] == "0"] == [
        ("black", "0"), ("black", "0"), ("white", "0"), ("white", "0")]
    assert contrast(profile) == pytest.approx(10**1.37, rel=1e-6)


def test_first_patch_is_measured_again_whatever_it_was(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "--readings", 1,
                                       "-o", profile) as session:
        for asked, answer, density in (("white", "", 1.4), ("white", "r", None),
                                       ("white", "", 0.07), ("black", "", 1.44)):
            session.until("prompt", patch=asked)
            session.answer(answer)
            if density is not None:
                session.until("ready")
                device.press(density)
        assert session.end() == 0, session.errors
    assert [(row[1], float(row[5]), row[-1]) for row in rows(profile)] == [
        ("black", pytest.approx(1.4), "1"), ("white", pytest.approx(0.07), "0"),
        ("black", pytest.approx(1.44), "0")]


def test_outlier_is_kept_but_marked_and_the_median_stands(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "-o", profile) as session:
        for patch, densities in (("white", (0.07, 0.07, 0.17, 0.07, 0.07)),
                                 ("black", (1.44, 1.44, 1.44, 1.44, 1.44))):
            session.until("prompt", patch=patch)
            session.answer()
            session.until("ready")
            device.press(*densities)
        assert session.end() == 0, session.errors
    assert [row[-1] for row in rows(profile)] == ["0", "0", "1"] + ["0"] * 7
    assert contrast(profile) == pytest.approx(10**1.37, rel=1e-6)


def test_guided_session_asks_again_for_a_bad_patch(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "--readings", 2,
                                       "-o", profile) as session:
        presses = iter([(0.07, 1.44), (0.07, 0.07), (0.07, 0.07), (1.44, 1.44)])
        patches = []
        for pressed in presses:
            patches.append(session.until("prompt")["patch"])
            session.answer()
            session.until("ready")
            device.press(*pressed)
        assert session.end() == 0, session.errors
    # mixed white, white, black that was white, black
    assert patches == ["white", "white", "black", "black"]
    assert [row[-1] for row in rows(profile)] == ["1", "1", "0", "0", "1", "1", "0", "0"]


def test_patch_before_can_be_measured_again(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "--readings", 1,
                                       "-o", profile) as session:
        for patch, answer, density in (("white", "", 0.5), ("black", "r", None),
                                       ("white", "", 0.07), ("black", "", 1.44)):
            session.until("prompt", patch=patch)
            session.answer(answer)
            if density is not None:
                session.until("ready")
                device.press(density)
        assert session.end() == 0, session.errors
    assert [(row[1], row[-1]) for row in rows(profile)] == [
        ("white", "1"), ("white", "0"), ("black", "0")]


def test_stale_reading_before_the_prompt_is_not_taken(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "--readings", 1,
                                       "-o", profile) as session:
        session.until("prompt", patch="white")
        device.press(0.9)
        session.answer()
        session.until("ready")
        device.press(0.07)
        session.until("prompt", patch="black")
        device.press(0.8)
        session.answer()
        session.until("ready")
        device.press(1.44)
        assert session.end() == 0, session.errors
    assert [float(row[5]) for row in rows(profile)] == pytest.approx([0.07, 1.44], abs=1e-6)


def test_interrupted_measurement_is_resumed(tmp_path):
    profile = tmp_path / "p.cgats"
    journal = tmp_path / "p.cgats.journal"
    options = ("--readings", 3, "-o", profile)
    with Emulator() as device:
        with Session("--port", device.port, *options) as session:
            session.until("prompt", patch="white")
            session.answer()
            session.until("ready")
            device.press(0.07, 0.07, 0.07)
            session.until("prompt", patch="black")
            session.answer()
            session.until("ready")
            device.press(1.44)
            session.until("reading", patch="black", number=1)
            session.process.kill()  # as a power cut would
            session.process.wait()
        assert not profile.exists()
        assert len(journal.read_text().splitlines()) == 5
        with Session("--port", device.port, "--resume", *options) as session:
            session.until("reading", patch="black", number=1)
            device.press(1.44, 1.44)
            assert session.end() == 0, session.errors
    assert [float(row[5]) for row in rows(profile)] == pytest.approx([0.07] * 3 + [1.44] * 3)
    assert not journal.exists()


def test_journal_of_other_options_is_not_taken_up(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device:
        with Session("--port", device.port, "--readings", 2, "-o", profile) as session:
            session.until("prompt", patch="white")
            session.answer()
            session.until("ready")
            device.press(0.07)
            session.until("reading")
            session.process.kill()
            session.process.wait()
        before = (tmp_path / "p.cgats.journal").read_bytes()
        run = lccal("--port", device.port, "--resume", "--yes", "--readings", 3, "-o", profile)
        assert run.returncode == 2
        assert "no journal of this instrument" in run.stderr
        assert (tmp_path / "p.cgats.journal").read_bytes() == before
        run = lccal("--port", device.port, "--resume", "--yes", "-o", tmp_path / "other.cgats")
        assert run.returncode == 2


def test_nine_positions_tell_how_even_the_patch_is(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 9, "--noise", 0.005) as device:
        run = lccal("--port", device.port, "--yes", "--json", "--positions", 9, "-o", profile)
    assert run.returncode == 0, run.stderr
    evenness = [event for event in events(run.stdout) if event["event"] == "evenness"]
    assert [event["patch"] for event in evenness] == ["white", "black"]
    assert all(0.0 < event["highest"] - event["lowest"] < 0.05 for event in evenness)
    assert "position 9: bottom right" in run.stderr


def test_grey_ramp_becomes_part_of_the_profile(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 2, "--steps", "0.25,0.55,0.95") as device:
        run = lccal("--port", device.port, "--yes", "--readings", 2, "--ramp", 3, "-o", profile)
    assert run.returncode == 0, run.stderr
    grey = [(row[1], int(row[2]), float(row[5])) for row in rows(profile)[4::2]]
    assert [entry[:2] for entry in grey] == [("grey 191", 191), ("grey 128", 128), ("grey 64", 64)]
    assert [entry[2] for entry in grey] == pytest.approx([0.25, 0.55, 0.95], abs=1e-6)


def test_grey_ramp_out_of_order_is_rejected(tmp_path):
    with Emulator("--auto-press", 2, "--steps", "0.55,0.25") as device:
        run = lccal("--port", device.port, "--yes", "--readings", 2, "--ramp", 2,
                    "-o", tmp_path / "p.cgats")
    assert run.returncode == 6
    assert "light to dark" in run.stderr


def test_measuring_goes_on_until_the_contrast_is_known_well_enough(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator() as device, Session("--port", device.port, "--readings", 3, "--precision", 4,
                                       "-o", profile) as session:
        rounds = [(0.07, 0.07, 0.071), (1.40, 1.44, 1.42), (1.42, 1.42, 1.42)]
        patches = []
        for densities in rounds:
            patches.append(session.until("prompt")["patch"])
            session.answer()
            session.until("ready")
            device.press(*densities)
        assert session.end() == 0, session.errors
    assert patches == ["white", "black", "black"]
    result = session.seen[-1]
    assert result["event"] == "result"
    assert result["contrast_u95"] / result["contrast"] <= 0.04


def test_events_are_one_object_a_line_and_prompts_stay_on_stderr(tmp_path):
    with Emulator("--auto-press", 1) as device:
        run = lccal("--port", device.port, "--yes", "--json", "--readings", 1,
                    "-o", tmp_path / "p.cgats")
    names = [event["event"] for event in events(run.stdout)]
    assert names == ["instrument", "reading", "reading", "result"]
    result = events(run.stdout)[-1]
    assert result["contrast"] == pytest.approx(23.4, abs=1e-3)
    assert result["d_max"] - result["d_min"] == pytest.approx(math.log10(23.4), abs=2e-4)
    assert "white" in run.stderr


def test_print_is_described_in_the_profile(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 1) as device:
        run = lccal("--port", device.port, "--yes", "--readings", 1, "-o", profile,
                    "--material", "baryta 310 g", "--backing", "black", "--conditions", "1440 dpi")
    assert run.returncode == 0, run.stderr
    assert keyword(profile, "MATERIAL") == "baryta 310 g"
    assert keyword(profile, "SAMPLE_BACKING") == "black"
    assert keyword(profile, "PRINT_CONDITIONS") == "1440 dpi"


def test_recording_replays_to_the_same_profile(tmp_path):
    script, first, second = tmp_path / "s.script", tmp_path / "1.cgats", tmp_path / "2.cgats"
    with Emulator("--auto-press", 2, "--noise", 0.004, "--seed", 7) as device:
        run = lccal("--port", device.port, "--yes", "--readings", 2, "--record", script,
                    "-o", first)
    assert run.returncode == 0, run.stderr
    run = lccal("--port", f"script:{script}", "--yes", "--readings", 2, "-o", second)
    assert run.returncode == 0, run.stderr
    assert rows(first) == rows(second)


def test_comma_locale_changes_nothing(tmp_path):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 1) as device:
        run = lccal("--port", device.port, "--yes", "--readings", 1, "-o", profile, "--json",
                    env=comma_environment(tmp_path))
    assert run.returncode == 0, run.stderr
    assert contrast(profile) == pytest.approx(23.4, abs=1e-4)
    assert events(run.stdout)[-1]["contrast"] == pytest.approx(23.4, abs=1e-3)
