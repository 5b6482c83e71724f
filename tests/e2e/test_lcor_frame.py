# SPDX-License-Identifier: MIT
"""What all of lcor's commands share: help, exit codes, errors, JSON, files that appear whole."""

import json
import os
import random
import re
import signal
import subprocess

import pytest
from gltf_scene import Scene, png
from lcor_run import DATA, LCOR, good, lcor, refused, report, write_pfm

COMMANDS = ["correct", "irradiance", "room", "info", "bench", "render", "paper"]


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "in.png"
    path.write_bytes(png(4, 3, bytes(range(36))))
    return path


@pytest.fixture
def light(tmp_path):
    return write_pfm(tmp_path / "light.pfm", [[0.5, 1.0], [1.5, 2.0]])


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_version_and_refuses_unknown_options(command):
    assert good(command, "--help").stdout.startswith(f"usage: lcor {command}")
    assert good(command, "--version").stdout.startswith("lcor ")
    refused(2, command, "--no-such-option", says="--no-such-option")


def test_program_help_lists_every_command():
    text = good("--help").stdout
    assert all(f"  {command} " in text for command in COMMANDS)
    assert good("--version").stdout.startswith("lcor ")
    refused(2, says="which command")
    refused(2, "--frobnicate", says="unknown option")
    refused(2, "frobnicate", says="unknown command")


def test_every_option_of_the_manual_is_one_of_the_program():
    manual = DATA.parent.parent / "cli/lcor.1"
    helps = "".join(good(command, "--help").stdout for command in COMMANDS)
    named = {
        word.replace("\\-", "-") for word in re.findall(r"\\-\\-[a-z\\-]+", manual.read_text())
    }
    assert named and {name for name in named if name not in helps} == set()


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_of_the_program_is_in_the_manual(command):
    manual = (DATA.parent.parent / "cli/lcor.1").read_text().replace("\\-", "-")
    options = re.findall(r"^  (--?[a-z-]+)", good(command, "--help").stdout, re.MULTILINE)
    assert options
    assert [name for name in options if not re.search(rf"{name}(?![a-z-])", manual)] == []


def test_bash_completes_commands_options_and_their_words():
    def completed(*words: str) -> list[str]:
        script = (
            "source \"$1\"; shift; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1));"
            ' _lcor; printf "%s\\n" "${COMPREPLY[@]}"'
        )
        source = DATA.parent.parent / "cli/completions/lcor.bash"
        path = f"{LCOR.parent}:{os.environ['PATH']}"
        run = subprocess.run(
            ["bash", "-c", script, "bash", source, *words],
            capture_output=True,
            text=True,
            env={**os.environ, "PATH": path},
            check=True,
        )
        return run.stdout.split()

    assert completed("lcor", "ren") == ["render"]
    assert completed("lcor", "correct", "--ill") == ["--illuminance"]
    assert completed("lcor", "render", "--reading", "") == ["patch", "texel"]


@pytest.mark.parametrize(
    "code, says, arguments",
    [
        (2, "which light", ["IN"]),
        (2, "where to", ["IN", "--illuminance", "LIGHT"]),
        (2, "which device", ["IN", "--illuminance", "LIGHT", "-o", "OUT"]),
        (
            2,
            "--contrast must be greater than 1",
            ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "1"],
        ),
        (2, "'nan'", ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "nan"]),
        (2, "'0x10'", ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "0x10"]),
        (2, "'1,5'", ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "1,5"]),
        (2, "--reading", ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--reading", "pixel"]),
        (
            2,
            "--mean",
            ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "9", "--mean", "best"],
        ),
        (
            2,
            "--rho",
            ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "9", "--rho", "1.5"],
        ),
        (2, "extension", ["IN", "--illuminance", "LIGHT", "-o", "OUT.xyz", "--contrast", "9"]),
        (2, "left over", ["IN", "IN", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "9"]),
        (2, "wants a value", ["IN", "--illuminance", "LIGHT", "-o"]),
        (3, "No such file", ["GONE", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "9"]),
        (3, "No such file", ["IN", "--illuminance", "GONE", "-o", "OUT", "--contrast", "9"]),
        (3, "cannot read", ["SELF", "--illuminance", "LIGHT", "-o", "OUT", "--contrast", "9"]),
        (7, "GONE", ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--profile", "GONE"]),
        (7, "profile", ["IN", "--illuminance", "LIGHT", "-o", "OUT", "--profile", "SELF"]),
    ],
)
def test_mistakes_give_one_line_a_code_and_no_output(
    tmp_path, picture, light, code, says, arguments
):
    names = {
        "IN": picture,
        "LIGHT": light,
        "OUT": tmp_path / "out.png",
        "OUT.xyz": tmp_path / "out.xyz",
        "GONE": tmp_path / "GONE",
        "SELF": __file__,
    }
    before = set(os.listdir(tmp_path))
    refused(code, "correct", *[names.get(a, a) for a in arguments], says=says)
    assert set(os.listdir(tmp_path)) == before


def test_an_error_is_a_json_document_too(picture):
    run = lcor("correct", picture, "--json")
    document = json.loads(run.stdout)
    assert run.returncode == 2 and document["error"]["code"] == 2
    assert "--illuminance" in document["error"]["text"]


@pytest.mark.parametrize("arguments", [("--json", "info", "gone"), ("gone", "--json")])
def test_json_may_stand_before_the_command_and_after_an_unknown_one(arguments):
    assert json.loads(lcor(*arguments).stdout)["error"]["text"]


def test_quiet_says_nothing(tmp_path):
    run = good("room", "--quiet", "-o", tmp_path / "room.glb")
    assert run.stdout == "" and run.stderr == ""


def test_folder_that_is_not_there_or_not_ours(tmp_path):
    refused(1, "room", "-o", tmp_path / "no/room.glb", says="folder does not exist")
    refused(2, "room", "-o", tmp_path, says="is a folder")
    if os.geteuid() != 0:
        locked = tmp_path / "locked"
        locked.mkdir(mode=0o555)
        refused(4, "room", "-o", locked / "room.glb", says="Permission denied")


def test_output_through_a_link_to_a_device_and_with_its_rights(tmp_path):
    (tmp_path / "real.glb").write_bytes(b"old")
    (tmp_path / "real.glb").chmod(0o640)
    (tmp_path / "link.glb").symlink_to("real.glb")
    good("room", "-o", tmp_path / "link.glb")
    assert (tmp_path / "link.glb").is_symlink()
    assert (tmp_path / "real.glb").read_bytes()[:4] == b"glTF"
    assert (tmp_path / "real.glb").stat().st_mode & 0o777 == 0o640
    run = subprocess.run(
        [LCOR, "room", "--quiet", "-o", "/dev/stdout"], capture_output=True, timeout=60
    )
    assert run.stdout[:4] == b"glTF"
    assert sorted(os.listdir(tmp_path)) == ["link.glb", "real.glb"]


@pytest.mark.parametrize("extension", ["tif", "png", "jpg", "exr", "ppm"])
def test_full_disk_leaves_the_old_file(tmp_path, light, extension):
    out = tmp_path / f"out.{extension}"
    out.write_bytes(b"old")
    large = tmp_path / "large.png"
    large.write_bytes(png(600, 600, random.Random(1).randbytes(3 * 600 * 600)))
    run = subprocess.run(
        [
            "sh",
            "-c",
            'ulimit -f 40; trap "" XFSZ; exec "$0" "$@"',
            LCOR,
            "correct",
            large,
            "--illuminance",
            light,
            "--contrast",
            "9",
            "-o",
            out,
        ],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert run.returncode == 1 and f"cannot write '{out}'" in run.stderr
    assert out.read_bytes() == b"old"
    assert not [name for name in os.listdir(tmp_path) if name.startswith(".lcor-")]


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_run_leaves_nothing(tmp_path, picture, light, kill_at, number, code):
    out = tmp_path / "out.tif"
    out.write_bytes(b"old")
    command = ["correct", picture, "--illuminance", light, "--contrast", "9", "-o", out]
    # Before and after the mode is set and the file is synced, and before it takes its name.
    for step in range(1, 6):
        assert lcor(*command, env=kill_at(step, number)).returncode == code
        assert out.read_bytes() == b"old"
        assert sorted(os.listdir(tmp_path)) == ["in.png", "light.pfm", "out.tif"]
    good(*command, env=kill_at(100, number))


def test_numbers_do_not_follow_the_locale(tmp_path):
    environment = dict(os.environ, LC_ALL="de_DE.UTF-8", LANG="de_DE.UTF-8")
    a, b = tmp_path / "a.glb", tmp_path / "b.glb"
    good("room", "-o", a, "--light", "0.25,0.5,0.75,1.5")
    good("room", "-o", b, "--light", "0.25,0.5,0.75,1.5", env=environment)
    assert a.read_bytes() == b.read_bytes()
    tables = []
    for scene, env in ((a, None), (b, environment)):
        out = scene.with_suffix(".csv")
        good("irradiance", scene, "--patches", out, "--patches", "3", env=env)
        tables.append(out.read_bytes())
    assert tables[0] == tables[1] and tables[0].count(b",") == 55 * 11


def test_info_knows_a_scene_a_picture_and_a_profile(tmp_path, picture):
    scene = report("info", DATA / "scenes/cornell_bevy_orig.glb")
    assert (scene["kind"], scene["triangles"], scene["emitters"]) == ("scene", 36, 1)
    image = report("info", picture)
    assert (image["kind"], image["width"], image["height"], image["samples"]) == (
        "picture",
        4,
        3,
        "uint8",
    )
    profile = tmp_path / "p.cgats"
    profile.write_text(
        "CGATS.17\nNUMBER_OF_FIELDS 5\nBEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B D_VIS\n"
        "END_DATA_FORMAT\nNUMBER_OF_SETS 2\nBEGIN_DATA\n"
        "1 255 255 255 0.07\n2 0 0 0 1.44\nEND_DATA\n"
    )
    values = report("info", profile)
    assert values["kind"] == "profile" and values["contrast"] == pytest.approx(10**1.37)
    assert "contrast" in good("info", profile).stdout
    refused(3, "info", tmp_path / "gone", says="No such file")


def test_info_survives_an_unlit_scene(tmp_path):
    scene = Scene()
    scene.node(mesh=scene.quad(material=scene.material()))
    path = tmp_path / "s.glb"
    path.write_bytes(scene.glb())
    assert report("info", path)["lights"] == 0
    refused(3, "irradiance", path, "--patches", tmp_path / "e.csv", says="--light")
