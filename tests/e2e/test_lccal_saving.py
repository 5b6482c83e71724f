# SPDX-License-Identifier: MIT
"""Storing the profile: a crash at any step leaves the old or the new one whole, and a full disk
leaves the old one."""

import os
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from lccal_bench import Emulator, environment, keyword, lccal

EARLIER = b"CGATS.17\nan earlier profile\n"


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    """A recorded measurement, so that no emulator is needed to come to the saving."""
    path = tmp_path_factory.mktemp("script") / "m.script"
    with Emulator("--auto-press", 1) as device:
        run = lccal("--port", device.port, "--yes", "--readings", 1, "--record", path,
                    "-o", path.with_suffix(".cgats"))
    assert run.returncode == 0, run.stderr
    return path


def measure(script, profile, **options):
    return lccal("--port", f"script:{script}", "--yes", "--readings", 1, "-o", profile, **options)


def test_killed_at_each_step_of_saving(tmp_path, script, kill_at):
    survived = set()
    for step in range(1, 100):
        profile = tmp_path / f"{step}.cgats"
        profile.write_bytes(EARLIER)
        run = measure(script, profile, env=kill_at(step))
        if profile.read_bytes() == EARLIER:
            survived.add("old")
        else:
            assert keyword(profile, "LCOR_CONTRAST"), "neither the old profile nor the new one"
            assert profile.read_text().endswith("END_DATA\n")
            assert Path(f"{profile}~").read_bytes() == EARLIER
            survived.add("new")
        if run.returncode == 0:
            break
        assert run.returncode == -9
        assert "contrast" not in run.stderr, "success was told before the profile was safe"
    else:
        pytest.fail("lccal never came to its end")
    assert step > 12, "the saving has more steps than were tried"
    assert survived == {"old", "new"}


def test_backup_is_the_profile_before(tmp_path, script):
    profile = tmp_path / "p.cgats"
    profile.write_bytes(EARLIER)
    assert measure(script, profile).returncode == 0
    first = profile.read_bytes()
    assert Path(f"{profile}~").read_bytes() == EARLIER
    assert measure(script, profile).returncode == 0
    assert Path(f"{profile}~").read_bytes() == first


def test_stored_profile_has_the_rights_of_any_new_file(tmp_path, script):
    profile = tmp_path / "p.cgats"
    mask = os.umask(0o027)
    try:
        assert measure(script, profile).returncode == 0
    finally:
        os.umask(mask)
    assert profile.stat().st_mode & 0o777 == 0o640


def test_what_a_link_leads_to_is_written_with_its_rights(tmp_path, script):
    profile, link, device = tmp_path / "p.cgats", tmp_path / "link", tmp_path / "device"
    profile.write_bytes(EARLIER)
    profile.chmod(0o600)
    link.symlink_to(profile)
    device.symlink_to("/dev/null")
    for output in (link, device):
        assert measure(script, output).returncode == 0
        assert output.is_symlink()
    assert profile.read_bytes() != EARLIER and profile.stat().st_mode & 0o777 == 0o600


def test_a_folder_is_refused_before_measuring(tmp_path, script):
    run = measure(script, tmp_path)
    assert run.returncode == 2 and "is a folder" in run.stderr
    assert list(tmp_path.parent.glob("*.journal")) == []


def test_disk_full_while_saving(tmp_path, script):
    profile = tmp_path / "disk" / "p.cgats"
    profile.parent.mkdir()
    # A file system of its own with room for the journal and the old profile only.
    command = (
        f"mount -t tmpfs -o size=16k tmpfs {profile.parent} || exit 77; "
        f"printf 'CGATS.17\\nan earlier profile\\n' > {profile}; "
        f"dd if=/dev/zero of={profile.parent}/filler bs=4096 count=2 2>/dev/null; "
        f"\"$0\" \"$@\"; code=$?; cat {profile}; ls {profile.parent} >&2; exit $code"
    )
    from lccal_bench import LCCAL

    run = subprocess.run(
        ["unshare", "-rm", "sh", "-c", command, LCCAL, "--port", f"script:{script}", "--yes",
         "--readings", "1", "--quiet", "-o", profile],
        capture_output=True, text=True, check=False, env=environment(),
    )
    if run.returncode == 77 or "unshare" in run.stderr:
        pytest.skip(f"no file system of its own can be mounted here: {run.stderr.strip()}")
    assert run.returncode == 1, run.stderr
    assert "No space left" in run.stderr and "free some space" in run.stderr
    assert run.stdout.encode() == EARLIER
    assert run.stderr.split("\n")[-4:-1] == ["filler", "p.cgats", "p.cgats.journal"]


def test_file_size_limit_is_an_error_not_a_crash(tmp_path, script):
    profile = tmp_path / "p.cgats"
    profile.write_bytes(EARLIER)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))

    run = measure(script, profile, preexec_fn=limit)
    assert run.returncode == 1
    assert "File too large" in run.stderr
    assert profile.read_bytes() == EARLIER
    assert {path.name for path in tmp_path.iterdir()} == {"p.cgats", "p.cgats.journal"}


def test_folder_is_missing(tmp_path, script):
    run = measure(script, tmp_path / "none" / "p.cgats")
    assert run.returncode == 1
    assert "none/p.cgats" in run.stderr and "No such file" in run.stderr


def test_folder_may_not_be_written(script):
    if os.geteuid() != 0:
        pytest.skip("only root can take a permission away here")
    with tempfile.TemporaryDirectory() as name:  # pytest's folders are for their owner alone
        open_to_all = Path(name)
        open_to_all.chmod(0o755)
        folder = open_to_all / "locked"
        folder.mkdir(mode=0o555)
        script = shutil.copy(script, open_to_all / "m.script")
        run = measure(script, folder / "p.cgats", user=65534, group=65534)
    assert run.returncode == 4, run.stderr
    assert "Permission denied" in run.stderr and "-o" in run.stderr
