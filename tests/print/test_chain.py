# SPDX-License-Identifier: MIT
"""A PDF through the filters of a real CUPS, without scheduler and printer: cupsfilter with a server
root of its own."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import raster
from conftest import FILTER

SOURCE = Path(os.environ["LCOR_SOURCE"])
SERVER_BIN, DATA = Path("/usr/lib/cups"), Path("/usr/share/cups")
PDF = """%PDF-1.4
1 0 obj<</Type/Catalog/Pages 2 0 R>>endobj
2 0 obj<</Type/Pages/Kids[3 0 R]/Count 1>>endobj
3 0 obj<</Type/Page/Parent 2 0 R/MediaBox[0 0 595 842]/Contents 4 0 R>>endobj
4 0 obj<</Length {length}>>stream
{content}endstream
endobj
trailer<</Root 1 0 R>>
"""


def needs(*paths):
    missing = [
        str(path)
        for path in paths
        if not (path if isinstance(path, str) else path.exists())
        or (
            isinstance(path, str) and not shutil.which(path, path=os.environ["PATH"] + ":/usr/sbin")
        )
    ]
    if missing:
        pytest.skip("not installed: " + ", ".join(missing))


@pytest.fixture
def server(tmp_path):
    """Folders of a CUPS server in which rastertolcor is installed, a PPD and a PDF."""
    needs("cupsfilter", "ppdc", SERVER_BIN / "filter" / "pdftopdf", DATA / "mime")
    for folder in ("server/lcor", "bin/filter", "data", "tmp"):
        (tmp_path / folder).mkdir(parents=True)
    for item in DATA.iterdir():
        if item.name != "mime":
            (tmp_path / "data" / item.name).symlink_to(item)
    shutil.copytree(DATA / "mime", tmp_path / "data/mime")
    for name in ("lcor.types", "lcor.convs"):
        shutil.copy(SOURCE / "cups" / name, tmp_path / "data/mime")
    for item in (SERVER_BIN / "filter").iterdir():
        (tmp_path / "bin/filter" / item.name).symlink_to(item)
    shutil.copy(FILTER, tmp_path / "bin/filter/rastertolcor")
    (tmp_path / "cups-files.conf").write_text(
        f"ServerRoot {tmp_path}/server\nServerBin {tmp_path}/bin\nDataDir {tmp_path}/data\n"
    )
    subprocess.run(
        ["ppdc", "-d", tmp_path, SOURCE / "cups/lcor.drv"], check=True, capture_output=True
    )
    bars = "".join(
        f"{i / 40:.3f} {0.3 + i / 80:.3f} 0.4 rg 60 {60 + 18 * i} 475 18 re f\n" for i in range(40)
    )
    (tmp_path / "page.pdf").write_text(PDF.format(length=len(bars), content=bars))
    light = np.linspace(0.4, 1.8, 64, dtype="<f4")[None].repeat(2, 0)
    (tmp_path / "server/lcor/light.pfm").write_bytes(b"Pf\n64 2\n-1\n" + light.tobytes())
    return tmp_path


def cupsfilter(server, target, *options):
    command = [
        "cupsfilter",
        "-c",
        server / "cups-files.conf",
        "-p",
        server / "lcor-pwg.ppd",
        "-m",
        target,
    ]
    if target.startswith("printer/"):
        command.append("-e")
    for option in ("Resolution=150dpi", *options):
        command += ["-o", option]
    env = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
    done = subprocess.run(
        [*command, server / "page.pdf"],
        capture_output=True,
        check=False,
        timeout=120,
        env=env | {"PATH": env["PATH"] + ":/usr/sbin", "TMPDIR": str(server / "tmp")},
    )
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout, done.stderr.decode(errors="replace")


@pytest.mark.parametrize("renderer", ["gstoraster", "pdftoraster"])
@pytest.mark.parametrize("target", ["printer/paper", "application/vnd.lcor-raster"])
def test_a_pdf_comes_out_corrected(server, renderer, target):
    needs(SERVER_BIN / "filter" / renderer, *(["gs"] if renderer == "gstoraster" else []))
    for convs in (server / "data/mime").glob(
        "cupsfilters-*.convs"
    ):  # leave one way from PDF to raster
        if renderer not in convs.read_text():
            convs.unlink()
    options = ("lcor-illuminance=light.pfm", "lcor-contrast=15.7", "LcorReading=Texel")
    data, log = cupsfilter(server, target, *options)
    assert f"{renderer} (PID" in log and "rastertolcor (PID" in log
    assert ("PAGE: 1 1" in log) or target != "printer/paper"
    (page,) = raster.read(data)
    assert raster.MARK in page.strings.values() and page.pixels.shape[:2] == (1754, 1240)
    assert data[:4] == (b"RaS2" if target == "printer/paper" else b"3SaR")

    plain, _ = cupsfilter(server, target, "LcorCorrection=Off")
    (before,) = raster.read(plain)
    assert raster.MARK not in before.strings.values()
    by_hand = subprocess.run(
        [
            FILTER,
            "1",
            "u",
            "t",
            "1",
            " ".join(options[1:]).replace("LcorR", "lcor-r").lower()
            + f" lcor-illuminance={server}/server/lcor/light.pfm",
        ],
        input=plain,
        capture_output=True,
        check=True,
    )
    assert by_hand.stdout == data
    # The light falls off to the left: the same bar comes out darker there, and paper does too.
    row = page.pixels[900].astype(int)
    assert (
        row[200].sum() < row[1000].sum() - 30
        and np.ptp(before.pixels[900, 150:1100].astype(int), axis=0).max() == 0
    )
    assert list((server / "tmp").iterdir()) == []


@pytest.mark.parametrize(
    ("mode", "space"), [("AdobeRGB", raster.ADOBERGB), ("Gray", raster.SGRAY), ("Black", raster.K)]
)
def test_other_colour_modes_of_the_ppd(server, mode, space):
    needs(SERVER_BIN / "filter/gstoraster", "gs")
    data, _ = cupsfilter(
        server, "printer/paper", f"ColorModel={mode}", "lcor-illuminance=light.pfm"
    )
    (page,) = raster.read(data)
    assert page.space == space and raster.MARK in page.strings.values()


def test_a_job_that_names_a_bad_file_fails_with_its_reason(server):
    needs(SERVER_BIN / "filter/gstoraster", "gs")
    with pytest.raises(
        AssertionError, match="ERROR: lcor-profile=/etc/hostname: a job names a file of"
    ):
        cupsfilter(server, "printer/paper", "lcor-profile=/etc/hostname")


def test_the_ppd_is_one_cups_accepts(server):
    needs("cupstestppd")
    shown = subprocess.run(
        ["cupstestppd", "-W", "filters", server / "lcor-pwg.ppd"], capture_output=True, check=False
    )
    assert shown.returncode == 0 and b"FAIL" not in shown.stdout, shown.stdout.decode()
