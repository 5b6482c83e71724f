# SPDX-License-Identifier: MIT
"""Every file of examples/ runs as its first lines say."""

import os
import pickle
import re
import shutil
import subprocess
import sys
from pathlib import Path

import lcor
import numpy as np
import pytest
from conftest import check

Image = pytest.importorskip("PIL.Image", reason="Pillow is not installed")


@pytest.fixture
def environment():
    return {**os.environ, "PATH": f"{os.environ.get('LCOR_BINDIR', '')}:{os.environ['PATH']}"}


@pytest.fixture
def run(source, tmp_path, environment):
    """Run an example in an empty folder; returns what it printed."""

    def call(name, *arguments):
        program = [sys.executable] if name.endswith(".py") else ["bash"]
        done = subprocess.run(
            [*program, str(source / "examples" / name), *map(str, arguments)],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=240,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


@pytest.fixture
def port(environment):
    """A pseudo-terminal with an emulated densitometer behind it."""
    if not shutil.which("lccal", path=environment["PATH"]):
        pytest.skip("lccal is not built")
    command = [sys.executable, "-m", "lcor.emulator", "--model", "printalyzer"]
    with subprocess.Popen(
        [*command, "--contrast", "23.4", "--auto-press", "5", "--once"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
    ) as emulator:
        yield emulator.stdout.readline().strip()
        emulator.terminate()


@pytest.fixture
def photo(tmp_path):
    y, x = np.mgrid[0:60, 0:80]
    waves = np.stack([np.sin(x / 9), np.cos(y / 7), np.sin((x + y) / 11)], axis=-1)
    path = tmp_path / "photo.jpg"
    Image.fromarray(np.uint8(127 + 100 * waves)).save(path, quality=95)
    return path


def blocks(text, language):
    """The code of a page, one text a block."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def test_the_readme_does_what_it_says(source, port, photo, tmp_path, environment):
    if not shutil.which("lcor", path=environment["PATH"]):
        pytest.skip("lcor is not built")
    tour = (source / "README.md").read_text().split("## Five minutes")[1]
    commands, (script,) = blocks(tour, "sh"), blocks(tour, "python")
    assert len(commands) == 3 and "/dev/ttyACM0" in commands[0]
    emulated = "".join(commands).replace("--port /dev/ttyACM0", f"--yes --port {port}")
    check(["bash", "-euc", emulated], cwd=tmp_path, env=environment)
    check([sys.executable, "-c", script], cwd=tmp_path, env=environment)
    for name in re.findall(r"-o (\S+)|=(light\.exr)|save\(\"(.*?)\"", tour):
        assert (tmp_path / "".join(name)).stat().st_size > 100
    wallpaper = np.asarray(Image.open(tmp_path / "wallpaper.png"))
    assert wallpaper.shape == (200, 300, 3) and np.ptp(wallpaper) > 100


def test_a_job_array_gives_the_bytes_of_one_machine(source, tmp_path, monkeypatch):
    measure, merge, apply = blocks((source / "docs/cluster.md").read_text(), "python")
    monkeypatch.chdir(tmp_path)
    random = np.random.default_rng(0)
    picture, light = random.random((40, 30, 3)), random.random((40, 30))
    tiles = [slice(0, 7), slice(7, 40)]
    names = {"lcor": lcor, "pickle": pickle, "Path": Path, "contrast": 23.4}
    for job, rows in enumerate(tiles):
        exec(measure, {**names, "job": job, "tile": picture[rows], "light": light[rows]})
    exec(merge, names)
    whole = lcor.Mean().add_picture(picture, light, reading="texel")
    assert names["r_mean"] == whole.get() and names["total"].error() == whole.error() < 1e-4
    expected = lcor.correct(picture, light, 23.4, reading="texel", r_mean=names["r_mean"])
    for rows in tiles:
        found = {**names, "tile": picture[rows], "light": light[rows]}
        exec(apply, found)
        np.testing.assert_array_equal(found["out"], expected[rows])


def test_photograph(run, port, photo, tmp_path):
    text = run("photograph.py", photo, port, "out.png")
    assert "contrast of 23.4" in text
    picture = np.asarray(Image.open(tmp_path / "out.png"))
    assert picture.shape == (60, 80, 3)
    assert picture[:20, :20].mean() > picture[-20:, -20:].mean() + 20


def test_room(run, tmp_path):
    text = run("room.py", "pictures")
    for name in ("side", "above"):
        picture = np.asarray(Image.open(tmp_path / "pictures" / f"{name}.png"))
        assert picture.shape == (240, 320, 3) and np.ptp(picture) > 100
        assert f"{name}.png" in text


def test_frames(run, tmp_path):
    pytest.importorskip("distributed", reason="distributed is not installed")
    random = np.random.default_rng(0)
    frames = random.integers(0, 256, (3, 24, 32, 3), dtype=np.uint8)
    light = random.random((3, 24, 32))
    (tmp_path / "film").mkdir()
    for i, frame in enumerate(frames):
        Image.fromarray(frame).save(tmp_path / "film" / f"{i}.png")
    np.save(tmp_path / "light.npy", light)
    run("frames.py", "film", "light.npy", "out")
    options = {"reading": "texel", "space": "srgb", "transfer": "srgb"}
    expected = lcor.correct(frames, light, 23.4, **options)
    for i in range(3):
        got = np.asarray(Image.open(tmp_path / "out" / f"{i}.png"))
        np.testing.assert_array_equal(got, expected[i])


def test_gltf_to_print(run, port, tmp_path, environment):
    if not shutil.which("lcor", path=environment["PATH"]):
        pytest.skip("lcor is not built")
    room = ["lcor", "room", "--quiet", "-o", str(tmp_path / "room.glb")]
    subprocess.run(room, env=environment, check=True)
    run("gltf_to_print.sh", "room.glb", port, "out")
    new, old = (np.asarray(Image.open(tmp_path / "out" / f"{n}.png")) for n in ("print", "eq19"))
    assert new.shape == old.shape == (240, 320, 3) and (new != old).any()
