# SPDX-License-Identifier: MIT
"""Every instrument, from its wire to the profile."""

import json
import shutil
import subprocess
import sys

import pytest
from lccal_bench import (
    DEADLINE,
    LCCAL,
    PATIENCE,
    Emulator,
    environment,
    events,
    in_time,
    keyword,
    lccal,
    rows,
    together,
)

PRESETS = ["heiland-trd2", "xrite-400", "xrite-photo", "xrite-39x", "xrite-500", "technet",
           "technet-adv", "tobias-tbx", "macbeth-900", "generic"]


def densities(path):
    return [float(row[-2]) for row in rows(path)]


def measure(profile, *emulator, instrument, readings=2, timeout=PATIENCE):
    with Emulator("--auto-press", readings, *emulator) as device:
        return lccal("--port", device.port, "--instrument", instrument, "--yes", "--readings",
                     readings, "--timeout", timeout, "-o", profile)


@pytest.mark.parametrize("preset", PRESETS)
def test_line_preset_reads_its_own_lines(tmp_path, preset):
    profile = tmp_path / "p.cgats"
    run = measure(profile, "--model", f"line:{preset}", instrument=f"line:{preset}")
    assert run.returncode == 0, run.stderr
    assert densities(profile) == [0.07, 0.07, 1.44, 1.44]
    # Two decimals cannot tell c better than about 2 %.
    assert float(keyword(profile, "LCOR_CONTRAST_U95")) > 0.2


@pytest.mark.parametrize("preset, fault", [
    ("heiland-trd2", "standby"), ("heiland-trd2", "relative"), ("tobias-tbx", "relative"),
    ("xrite-400", "standby"), ("xrite-400", "relative"), ("xrite-400", "cr-only"),
    ("xrite-400", "split"), ("xrite-400", "no-point"), ("xrite-500", "cr-only"),
    ("xrite-39x", "garbage-before"), ("xrite-39x", "garbage-after"), ("xrite-400", "chunk=1"),
])
def test_line_that_is_no_reading_is_waited_out(tmp_path, preset, fault):
    profile = tmp_path / "p.cgats"
    run = measure(profile, "--model", f"line:{preset}", "--fault", fault,
                  instrument=f"line:{preset}")
    assert run.returncode == 0, run.stderr
    assert densities(profile) == [0.07, 0.07, 1.44, 1.44]


NO_READINGS = [(preset, fault) for preset in PRESETS for fault in ("damaged", "garbage-inside")]
NO_READINGS.append(("xrite-400", "colour-only"))  # nothing of the visual filter


@pytest.fixture(scope="module")
def unread(tmp_path_factory):
    """All of them at once, since each waits for a reading that never comes."""
    def end(case, folder):
        preset, fault = case
        profile = folder / "p.cgats"

        def wait(seconds):
            return measure(profile, "--model", f"line:{preset}", "--fault", fault,
                           instrument=f"line:{preset}", readings=1, timeout=seconds)

        return in_time(wait, "but no reading"), profile

    return together(end, NO_READINGS, tmp_path_factory)


@pytest.mark.parametrize("case", NO_READINGS, ids="-".join)
def test_damaged_line_is_no_reading(unread, case):
    run, profile = unread[case]
    assert run.returncode == 5, run.stderr
    assert "but no reading" in run.stderr
    assert not profile.exists()


def test_line_options_change_the_preset(tmp_path):
    profile = tmp_path / "p.cgats"
    run = measure(profile, "--model", "line:xrite-400", readings=1,
                  instrument="line:xrite-400,baud=9600,frame=7E1,channel=C,dtr=off,flow=xonxoff")
    assert run.returncode == 6, run.stderr  # cyan is 0.05 on both patches
    assert "read the same" in run.stderr


def test_colour_densities_are_kept(tmp_path):
    profile = tmp_path / "p.cgats"
    run = measure(profile, "--model", "line:xrite-400", instrument="line:xrite-400")
    assert run.returncode == 0, run.stderr
    assert [float(text) for text in rows(profile)[0][5:9]] == [0.05, 0.06, 0.07, 0.07]


def test_transmission_is_told_from_reflection(tmp_path):
    profile = tmp_path / "p.cgats"
    run = measure(profile, "--mode", "T", "--dmax", 3.5, instrument="printalyzer")
    assert run.returncode == 0, run.stderr
    assert keyword(profile, "MEASUREMENT_SOURCE").startswith("transmission")


@pytest.mark.parametrize("instrument", ["auto", "xrite-rci"])
def test_rci_measures_by_itself(tmp_path, instrument):
    profile = tmp_path / "p.cgats"
    run = measure(profile, "--model", "xrite-rci", instrument=instrument)
    assert run.returncode == 0, run.stderr
    assert densities(profile) == pytest.approx([0.07] * 2 + [1.4392] * 2, abs=1e-3)
    assert keyword(profile, "INSTRUMENTATION") == "X-Rite DTP41 1.2 0203"


# ---- USB HID: unmodified hidapi on a device that umockdev emulates ----


def system_python():
    """A Python that has umockdev's bindings; the one that runs the tests need not."""
    for python in (sys.executable, "/usr/bin/python3"):
        probe = [python, "-c", "import gi; gi.require_version('UMockdev', '1.0')"]
        if subprocess.run(probe, capture_output=True, check=False).returncode == 0:
            return python
    return None


def on_usb(*arguments, emulator=()):
    """Run a command with an emulated ColorHug2 plugged in."""
    wrapper, python = shutil.which("umockdev-wrapper"), system_python()
    if not wrapper or not python:
        pytest.skip("umockdev-wrapper or gir1.2-umockdev-1.0 with python3-gi is not installed")
    env = environment() | {"ASAN_OPTIONS": "verify_asan_link_order=0:detect_leaks=0"}
    command = [wrapper, python, "-m", "lcor.emulator", "--model", "colorhug2", *emulator, "--",
               LCCAL, *arguments]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=DEADLINE,
                         env=env, check=False)
    if run.returncode == 77:
        pytest.skip(run.stderr)
    if run.returncode == 2 and "built without USB HID" in run.stderr:
        pytest.skip("lccal was built without hidapi")
    return run


def colorhug(profile, *emulator, port="hid:273f:1004", instrument="auto", timeout=PATIENCE):
    return on_usb("--port", port, "--instrument", instrument, "--yes", "--readings", 2,
                  "--timeout", timeout, "--json", "-o", profile,
                  emulator=("--auto-press", 2, *emulator))


@pytest.mark.parametrize("port", ["hid:273f:1004", "hid:273F:1004", "/dev/hidraw0"])
def test_colorhug_measures_a_display(tmp_path, port):
    profile = tmp_path / "p.cgats"
    run = colorhug(profile, port=port)
    assert run.returncode == 0, run.stderr
    result = events(run.stdout)[-1]
    assert result["j_max"] == pytest.approx(160.0 * 10**-0.07, rel=1e-5)
    assert result["contrast"] == pytest.approx(23.4, abs=1e-3)
    assert float(keyword(profile, "LCOR_CONTRAST")) == pytest.approx(23.4, abs=1e-3)
    assert keyword(profile, "INSTRUMENTATION") == "Hughski ColorHug2, serial 4711, firmware 2.0.7"
    assert keyword(profile, "MEASUREMENT_SOURCE") == "luminance, cd/m2"


@pytest.mark.parametrize("fault", ["error-once=18", "short", "stale"])
def test_colorhug_fault_is_survived(tmp_path, fault):
    run = colorhug(tmp_path / "p.cgats", "--fault", fault)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("fault, words", [
    ("error=12", "wants to be calibrated"), ("error=4", "too dark"), ("error=15", "too bright"),
    ("error=18", "error 18"), ("error=26", "error 26"), ("unplug", "was unplugged"),
])
def test_colorhug_fault_ends_the_measurement(tmp_path, fault, words):
    run = colorhug(tmp_path / "p.cgats", "--fault", fault)
    assert run.returncode == 5, run.stderr
    assert words in run.stderr
    assert not (tmp_path / "p.cgats").exists()


def test_colorhug_that_stays_silent(tmp_path):
    run = colorhug(tmp_path / "p.cgats", "--fault", "silence", instrument="colorhug2",
                   timeout=0.2)
    assert run.returncode == 5
    assert "stayed silent" in run.stderr


def test_hid_port_that_is_not_there(tmp_path):
    for port in ("hid:273f:1005", "hid:273f:1004:wrong", "/dev/hidraw7"):
        run = colorhug(tmp_path / "p.cgats", port=port)
        assert run.returncode == 3, run.stderr


def test_instrument_that_is_plugged_in_needs_no_port(tmp_path):
    profile = tmp_path / "p.cgats"
    run = on_usb("--yes", "--readings", 1, "-o", profile, emulator=("--auto-press", 1))
    assert run.returncode == 0, run.stderr
    assert keyword(profile, "INSTRUMENTATION").startswith("Hughski ColorHug2")


def test_list_shows_what_is_plugged_in():
    run = on_usb("list", "--json")
    assert run.returncode == 0, run.stderr
    (device,) = json.loads(run.stdout)["devices"]
    assert device["port"] == "hid:273f:1004"
    assert device["instrument"] == "colorhug2"
    assert device["obstacle"] == ""


def test_doctor_finds_the_plugged_in_instrument_usable():
    run = on_usb("doctor", "--json")
    assert run.returncode == 0, run.stdout
    checks = [check for check in json.loads(run.stdout)["checks"]
              if check["subject"] != "udev rules"]
    assert len(checks) == 3 and all(check["good"] for check in checks)
