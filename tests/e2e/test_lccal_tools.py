# SPDX-License-Identifier: MIT
"""lccal list, doctor and device."""

import os
import re
import time
import tty

import pytest
from lccal_bench import SOURCE, Emulator, Session, lccal


def test_list_and_doctor_are_quick_beside_dead_ports():
    with Emulator("--fault", "silence") as device:
        for arguments in (("list", "--all"), ("doctor",), ("doctor", "--port", device.port)):
            elapsed = []
            while not elapsed or (elapsed[-1] >= 2.0 and len(elapsed) < 20):  # a busy machine
                before = time.monotonic()
                run = lccal(*arguments)
                elapsed.append(time.monotonic() - before)
                assert run.returncode in (0, 3), run.stderr
            assert elapsed[-1] < 2.0, "it waited for a dead port"
        assert not device.spoken_to.is_set()


def test_doctor_of_a_port_that_is_not_there():
    run = lccal("doctor", "--port", "/dev/ttyNONE")
    assert run.returncode == 3
    assert "no such port" in run.stdout


def test_doctor_of_something_that_is_no_port():
    run = lccal("doctor", "--port", "/dev/null")
    assert run.returncode == 3
    assert "no serial port" in run.stdout


def test_rules_file_is_what_doctor_prints():
    run = lccal("doctor", "--rules")
    assert run.returncode == 0
    assert run.stdout == (SOURCE / "calib" / "69-lccal.rules").read_text()


def test_device_tells_identity_and_calibration():
    with Emulator() as device:
        run = lccal("device", "--port", device.port)
    assert run.returncode == 0, run.stderr
    facts = dict(line.split(": ", 1) for line in run.stdout.splitlines())
    assert facts["serial"] == "0123456789ABCDEF01234567"
    assert facts["firmware"] == "v1.1.0"
    assert facts["build"] == "2023-06-13 10:25"
    assert facts["temperature"] == "24.5C"
    assert facts["calibration_reflection"] == "0.0800/0.320100 1.5000/0.012300"


def test_device_is_saved_and_compared(tmp_path):
    saved = tmp_path / "device.txt"
    with Emulator() as device:
        assert lccal("device", "--port", device.port, "--save", saved).returncode == 0
        assert lccal("device", "--port", device.port, "--compare", saved).returncode == 0
        text = saved.read_text()
        assert f"calibration_unchanged_since: {time.strftime('%Y', time.gmtime())}" in text
        saved.write_text(text.replace("1.5000/0.012300", "1.5000/0.012200"))
        run = lccal("device", "--port", device.port, "--compare", saved)
        assert run.returncode == 8
        assert "calibration_reflection" in run.stderr
        run = lccal("device", "--port", device.port, "--compare", tmp_path / "none")
        assert run.returncode == 1


def test_age_of_the_calibration_goes_back_to_when_it_was_first_seen(tmp_path):
    saved = tmp_path / "device.txt"
    with Emulator() as device:
        assert lccal("device", "--port", device.port, "--save", saved).returncode == 0
        lines = saved.read_text().splitlines()
        lines[-1] = "calibration_unchanged_since: 2020-01-02"
        saved.write_text("\n".join(lines) + "\n")
        assert lccal("device", "--port", device.port, "--save", saved).returncode == 0
        assert saved.read_text().endswith("calibration_unchanged_since: 2020-01-02\n")
        saved.write_text(saved.read_text().replace("1.5000/0.012300", "1.5000/0.012200"))
        assert lccal("device", "--port", device.port, "--save", saved).returncode == 0
        assert "2020-01-02" not in saved.read_text()


def test_recalibration_needs_a_place_for_the_old_values(tmp_path):
    with Emulator() as device:
        run = lccal("device", "--port", device.port, "--recalibrate")
    assert run.returncode == 2
    assert "--save" in run.stderr


def test_recalibration_keeps_the_old_values_first(tmp_path):
    saved = tmp_path / "device.txt"
    with Emulator() as device, Session("device", "--port", device.port, "--recalibrate",
                                       "--save", saved) as session:
        session.until("prompt", patch="calibrate")
        assert "calibration_reflection: 0.0800/0.320100" in saved.read_text()
        session.answer()
        assert session.end() == 8
    assert "same as before" in session.errors


def test_instrument_that_is_not_known_has_no_device():
    with Emulator("--fault", "silence") as device:
        run = lccal("device", "--port", device.port, "--instrument", "printalyzer", "--timeout",
                    0.1)
    assert run.returncode == 5


def test_emulator_answers_on_a_serial_port_too():
    pytest.importorskip("serial", reason="pyserial is not installed")
    master, slave = os.openpty()
    tty.setraw(slave)
    with Emulator("--port", os.ttyname(slave), "--auto-press", 1) as device:
        assert device.port == os.ttyname(slave)
        os.write(master, b"GS V\r\n")
        reply = b""
        while not reply.endswith(b"\n"):
            reply += os.read(master, 100)
        device.unplug()
    assert reply == b'GS V,"Printalyzer Densitometer","v1.1.0"\r\n'
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize("command", ["measure", "list", "doctor", "device", "enter", "show",
                                     "verify", "history", "export", "target"])
def test_manual_has_every_option(command):
    manual = (SOURCE / "calib" / "lccal.1").read_text().replace("\\-", "-")
    options = re.findall(r"--[a-z-]+", lccal(command, "--help").stdout)
    assert options and [option for option in options if option not in manual] == []


@pytest.mark.parametrize("command", [(), ("list",), ("doctor",), ("device",)])
def test_help_and_version(command):
    run = lccal(*command, "--help")
    assert run.returncode == 0 and run.stdout.startswith("lccal")
    assert run.stderr == ""
    run = lccal(*command, "--version")
    assert run.returncode == 0 and run.stdout.startswith("lccal ")
