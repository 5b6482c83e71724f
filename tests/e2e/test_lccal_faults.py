# SPDX-License-Identifier: MIT
"""Everything that goes wrong ends in the right exit code, one clear line and the earlier profile
as it was, byte for byte."""

import os
import signal

import pytest
from lccal_bench import (
    DEADLINE,
    PATIENCE,
    Emulator,
    Session,
    events,
    in_time,
    lccal,
    rows,
    together,
)

EARLIER = b"CGATS.17\nnot a profile, but nothing may touch it\n"


def earlier_profile(folder):
    path = folder / "p.cgats"
    path.write_bytes(EARLIER)
    return path


@pytest.fixture
def profile(tmp_path):
    return earlier_profile(tmp_path)


def measure(profile, *emulator, readings=2, timeout=PATIENCE, options=()):
    """lccal --yes against an emulator that presses by itself."""
    with Emulator("--auto-press", readings, *emulator) as device:
        return lccal("--port", device.port, "--yes", "--readings", readings, "--timeout", timeout,
                     "-o", profile, *options)


def assert_failed(run, code, profile, words):
    assert run.returncode == code, run.stderr
    lines = [line for line in run.stderr.splitlines() if line.startswith("lccal: ")]
    errors = [line for line in lines if not line.startswith("lccal: warning")]
    assert len(errors) == 1, run.stderr
    assert words in errors[0]
    assert profile.read_bytes() == EARLIER
    litter = {path.name for path in profile.parent.iterdir()} - {"p.cgats", "p.cgats.journal"}
    assert not litter


SERIAL_FAULTS = [
    ("silence", "does not answer"),
    ("slow=1000", "does not answer"),
    ("cut=1", "but no reading"),
    ("cut=7", "but no reading"),
    ("cut=20", "but no reading"),
    ("cut=43", "but no reading"),
    ("garbage-inside", "does not answer"),
    ("flood", "but no reading"),
    ("wrong-echo", "does not answer"),
    ("nak=all", "answered GS V with 'NAK'"),
    ("err=all", "answered GS V with 'ERR'"),
    ("uncalibrated", "wants to be calibrated"),
    ("unplug-idle", "was unplugged"),
    ("unplug-mid", "was unplugged"),
]
RCI_FAULTS = [
    ("error=28", "wants to be calibrated"),
    ("error=27", "could not read the patch"),
    ("error=31", "error 31"),
    ("error=11", "error 11"),
    ("no-status", "stayed silent"),
    ("silence", "stayed silent"),
    ("garbage-before", "no X Y Z in percent"),
    ("garbage-inside", "does not talk like X-Rite DTP41"),
    ("unplug-idle", "was unplugged"),
    ("unplug-mid", "was unplugged"),
    ("cut=5", "does not talk like X-Rite DTP41"),
]
ENDING_FAULTS = {
    **{("printalyzer", fault): words for fault, words in SERIAL_FAULTS},
    **{("xrite-rci", fault): words for fault, words in RCI_FAULTS},
    ("auto", "silence"): "nothing known answers",
}


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """All of them at once, since most wait for something that never comes."""
    def end(case, folder):
        instrument, fault = case
        profile = earlier_profile(folder)
        model = "printalyzer" if instrument == "auto" else instrument

        def wait(seconds):
            return measure(profile, "--model", model, "--fault", fault, timeout=seconds,
                           options=("--instrument", instrument))

        if fault == "silence":
            return wait(0.2), profile  # nothing comes, however long one waits
        return in_time(wait, ENDING_FAULTS[case]), profile

    return together(end, ENDING_FAULTS, tmp_path_factory)


@pytest.mark.parametrize("case", ENDING_FAULTS, ids="-".join)
def test_fault_ends_the_measurement(ended, case):
    run, profile = ended[case]
    assert_failed(run, 5, profile, ENDING_FAULTS[case])


@pytest.fixture(scope="module")
def dialogue(tmp_path_factory):
    """A measurement as --record writes it, line by line."""
    path = tmp_path_factory.mktemp("dialogue") / "m.script"
    run = measure(path.with_suffix(".cgats"), readings=1, options=("--record", path))
    assert run.returncode == 0, run.stderr
    return path.read_bytes().splitlines(keepends=True)


@pytest.mark.parametrize("answer", [b"GS V,", b"SM FORMAT,", b"R+"])
def test_reply_cut_at_every_byte_ends_the_measurement(profile, dialogue, answer):
    line = next(i for i, text in enumerate(dialogue) if text.split(b" ", 2)[2].startswith(answer))
    reply = dialogue[line].rstrip(b"\n")
    script = profile.parent / "script"
    start = len(b" ".join(reply.split(b" ")[:2])) + 1
    for cut in range(start + 1, reply.rindex(b"^M^J") + 1):
        script.write_bytes(b"".join(dialogue[:line]) + reply[:cut] + b"\n")
        run = lccal("--port", f"script:{script}", "--instrument", "printalyzer", "--yes",
                    "--readings", 1, "--timeout", 2, "-o", profile)
        script.unlink()
        assert_failed(run, 5, profile, "script:")


@pytest.mark.parametrize("fault", ["slow=0.05", "chunk=1", "chunk=3", "garbage-before",
                                   "garbage-after", "nak", "err", "basic", "cr-only", "stale"])
def test_fault_is_survived(profile, fault):
    run = measure(profile, "--fault", fault)
    assert run.returncode == 0, run.stderr
    assert [float(row[5]) for row in rows(profile)] == pytest.approx([0.07] * 2 + [1.44] * 2,
                                                                     abs=0.0011)
    assert (profile.parent / "p.cgats~").read_bytes() == EARLIER


def test_readings_between_command_and_reply_are_not_lost_with_yes(profile):
    """They are readings as they come, here of a third patch, and so mix with white."""
    run = measure(profile, "--fault", "chatter", readings=9)
    assert_failed(run, 6, profile, "mixed")


def test_readings_between_command_and_reply_are_before_the_prompt(profile):
    with Emulator("--fault", "chatter") as device, Session("--port", device.port, "--readings", 1,
                                                           "-o", profile) as session:
        for density in (0.07, 1.44):
            session.until("prompt")
            session.answer()
            session.until("ready")
            device.press(density)
        assert session.end() == 0, session.errors
    assert [float(row[5]) for row in rows(profile)] == pytest.approx([0.07, 1.44], abs=1e-6)


READING_FAULTS = [
    ("identical", ("--order", "ww"), "read the same"),
    ("mixed", ("--order", "wbwb", "--auto-press", 1), "mixed"),
    ("drifting", ("--drift", 0.02), "same direction"),
    ("out of range", ("--model", "line:xrite-400", "--dmax", 9.5), "no density"),
    ("negative", ("--model", "line:xrite-39x", "--dmin", -0.5), "no density"),
]


@pytest.mark.parametrize("emulator, words", [entry[1:] for entry in READING_FAULTS],
                         ids=[entry[0] for entry in READING_FAULTS])
def test_readings_are_rejected(profile, emulator, words):
    options = ()
    if "--model" in emulator:
        options = ("--instrument", emulator[1])
    run = measure(profile, *emulator, readings=4, options=options)
    assert_failed(run, 6, profile, words)


def test_reading_at_the_end_of_the_range_is_warned_of(profile):
    run = measure(profile, "--dmax", 2.5)
    assert run.returncode == 0, run.stderr
    assert "end of the instrument's range" in run.stderr


@pytest.mark.parametrize("fault", ["error-once=27", "error-once=A1", "two-decimals", "chunk=1",
                                   "garbage-after"])
def test_rci_fault_is_survived(profile, fault):
    run = measure(profile, "--model", "xrite-rci", "--fault", fault,
                  options=("--instrument", "xrite-rci"))
    assert run.returncode == 0, run.stderr
    assert [float(row[5]) for row in rows(profile)] == pytest.approx([0.07] * 2 + [1.4392] * 2,
                                                                     abs=0.002)


def test_two_programs_on_one_port(profile, tmp_path_factory):
    with Emulator() as device, Session("--port", device.port, "-o",
                                       tmp_path_factory.mktemp("first") / "p.cgats") as first:
        first.until("prompt", patch="white")
        run = lccal("--port", device.port, "--yes", "-o", profile)
        assert_failed(run, 4, profile, "in use by another program")
        doctor = lccal("doctor", "--port", device.port)
        assert doctor.returncode == 4
        # The first one goes on unharmed.
        for density in (0.07,) * 5 + (1.44,) * 5:
            if first.seen[-1]["event"] == "prompt":
                first.answer()
                first.until("ready")
            device.press(density)
            first.until("reading")
            if first.seen[-1]["number"] == 5 and first.seen[-1]["patch"] == "white":
                first.until("prompt")
        assert first.end() == 0, first.errors


def test_port_that_is_not_there(profile):
    assert_failed(lccal("--port", "/dev/ttyNONE", "--yes", "-o", profile), 3, profile, "no port")


def test_port_that_is_no_port(profile):
    assert_failed(lccal("--port", profile, "--yes", "-o", profile), 3, profile, "not a serial port")


def test_port_without_permission(profile):
    somebody = {"user": 65534, "group": 65534} if os.geteuid() == 0 else {}
    with Emulator() as device:
        os.chmod(device.port, 0)
        run = lccal("--port", device.port, "--yes", "-o", profile, **somebody)
        assert_failed(run, 4, profile, "no permission")
        doctor = lccal("doctor", "--port", device.port, **somebody)
    assert doctor.returncode == 4
    assert "udev rules" in doctor.stdout


def test_unplugged_while_the_prompt_waits(profile):
    with Emulator() as device, Session("--port", device.port, "-o", profile) as session:
        session.until("prompt", patch="white")
        device.unplug()
        session.answer()
        assert session.end() == 5
    assert "was unplugged" in session.errors
    assert profile.read_bytes() == EARLIER


@pytest.mark.parametrize("patch", ["white", "black"])
@pytest.mark.parametrize("moment", ["prompt", "ready"])
def test_interrupted_at_each_prompt(profile, patch, moment):
    with Emulator() as device, Session("--port", device.port, "--readings", 1,
                                       "-o", profile) as session:
        if patch == "black":
            session.until("prompt", patch="white")
            session.answer()
            session.until("ready")
            device.press(0.07)
        session.until("prompt", patch=patch)
        if moment == "ready":
            session.answer()
            session.until("ready")
        session.interrupt()
        assert session.end() == 130
    assert profile.read_bytes() == EARLIER
    assert session.seen[-1] == {"event": "error", "code": 130, "text": session.seen[-1]["text"]}
    assert (profile.parent / "p.cgats.journal").exists() == (patch == "black")


def test_interrupted_when_asked_to_read_again(profile):
    with Emulator("--model", "xrite-rci", "--fault", "error=28") as device, Session(
            "--port", device.port, "--instrument", "xrite-rci", "-o", profile) as session:
        session.until("prompt", patch="white")
        session.answer()
        session.until("prompt", patch="again")
        session.interrupt()
        assert session.end() == 130
    assert profile.read_bytes() == EARLIER


@pytest.mark.parametrize("patch", ["white", "black"])
def test_interrupted_while_verifying(tmp_path, patch):
    profile = tmp_path / "p.cgats"
    assert lccal("enter", "--dmin", "0.07", "--dmax", "1.44", "-o", profile).returncode == 0
    before = profile.read_bytes()
    with Emulator() as device, Session("verify", profile, "--port", device.port, "--readings",
                                       1) as session:
        session.until("prompt", patch="white")
        if patch == "black":
            session.answer()
            session.until("ready")
            device.press(0.07)
            session.until("prompt", patch="black")
        session.interrupt()
        assert session.end() == 130
    assert profile.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["p.cgats"]


def test_interrupted_while_recalibrating(tmp_path):
    saved = tmp_path / "device.txt"
    with Emulator() as device, Session("device", "--port", device.port, "--recalibrate",
                                       "--save", saved) as session:
        session.until("prompt", patch="calibrate")
        before = saved.read_bytes()
        session.interrupt()
        assert session.end() == 130
    assert saved.read_bytes() == before


def test_interrupted_before_the_instrument_answered(profile):
    with Emulator("--fault", "silence") as device, Session("--port", device.port, "-o",
                                                           profile) as session:
        assert device.spoken_to.wait(DEADLINE)
        session.process.send_signal(signal.SIGTERM)
        assert session.end() == 130
    assert profile.read_bytes() == EARLIER


@pytest.mark.parametrize("patch", ["white", "black"])
def test_quit_at_each_prompt(profile, patch):
    with Emulator() as device, Session("--port", device.port, "--readings", 1,
                                       "-o", profile) as session:
        if patch == "black":
            session.until("prompt", patch="white")
            session.answer()
            session.until("ready")
            device.press(0.07)
        session.until("prompt", patch=patch)
        session.answer("q")
        assert session.end() == 130
    assert profile.read_bytes() == EARLIER


def test_nobody_answers_the_prompt(profile):
    with Emulator() as device:
        run = lccal("--port", device.port, "-o", profile)
    assert_failed(run, 2, profile, "use --yes")


@pytest.mark.parametrize("arguments, words", [
    (("--bogus",), "unknown option"),
    (("--readings", "0"), "whole number"),
    (("--readings", "1.5"), "whole number"),
    (("--readings", "1001"), "1 to 1000"),
    (("--timeout", "nan"), "a number"),
    (("--timeout", "-1"), "--timeout"),
    (("--precision", "2", "--yes"), "--precision"),
    (("--positions", "4"), "--positions"),
    (("--ramp", "65"), "--ramp"),
    (("--port", "script:/dev/null", "--material", 'a "b"'), "MATERIAL"),
    (("--port",), "wants a value"),
    (("--yes=1",), "takes no value"),
    (("frobnicate",), "no subcommand"),
    (("--port", "script:/dev/null", "--instrument", "nonesuch"), "no instrument"),
    (("--port", "script:/dev/null", "--instrument", "line:nonesuch"), "no line preset"),
    (("--port", "script:/dev/null", "--instrument", "line:generic,baud=x"), "does not set up"),
    (("--port", "script:/dev/null", "--instrument", "line:generic,scale=-1"), "does not set up"),
], ids=lambda value: " ".join(value) if isinstance(value, tuple) else "")
def test_command_line_is_wrong(profile, arguments, words):
    assert_failed(lccal(*arguments, "-o", profile) if arguments != ("--port",)
                  else lccal("-o", profile, "--port"), 2, profile, words)


def test_errors_are_events_too(profile):
    run = lccal("--port", "/dev/ttyNONE", "--json", "-o", profile)
    (event,) = events(run.stdout)
    assert event["event"] == "error" and event["code"] == 3
    assert run.stderr == f"lccal: {event['text']}\n"


@pytest.mark.parametrize("arguments", [("--bogus", "--json"), ("--readings", "0", "--json"),
                                       ("verify", "--tolerance", "x", "--json"),
                                       ("--json", "--material", "--json", "frobnicate")])
def test_errors_are_events_wherever_json_stands(arguments):
    run = lccal(*arguments)
    (event,) = events(run.stdout)
    assert event["event"] == "error" and event["code"] == run.returncode == 2


def test_json_that_is_the_value_of_an_option_asks_for_nothing():
    run = lccal("--material", "--json", "--bogus")
    assert run.returncode == 2 and run.stdout == ""


def test_nobody_presses(profile):
    with Emulator() as device:
        run = lccal("--port", device.port, "--yes", "--timeout", 0.2, "-o", profile)
    assert_failed(run, 5, profile, "sent nothing within 1 s; press the instrument's button")
