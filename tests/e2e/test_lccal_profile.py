# SPDX-License-Identifier: MIT
"""lccal show, verify, history, export and target."""

import json
import struct
import subprocess

import pytest
from lccal_bench import LCCAL, SOURCE, Emulator, events, keyword, lccal

DEVICE = SOURCE / "tests" / "data" / "device"


def enter(path, *options, dmin="0.07,0.07,0.08", dmax="1.43,1.44,1.45"):
    run = lccal("enter", "--dmin", dmin, "--dmax", dmax, "-o", path, *options)
    assert run.returncode == 0, run.stderr
    return path


def dated(path, date):
    text = path.read_text().splitlines()
    path.write_text("\n".join(f'CREATED "{date}"' if line.startswith("CREATED") else line
                              for line in text) + "\n")
    return path


def history(*paths):
    run = lccal("history", *paths, "--json")
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)["profiles"]


@pytest.fixture
def profile(tmp_path):
    return enter(tmp_path / "p.cgats", "--material", "glossy")


# ---- show

def test_show_tells_what_the_profile_says(profile):
    run = lccal("show", profile, "--readings")
    assert run.returncode == 0
    assert "contrast        23.44 +- " in run.stdout
    assert "MATERIAL: glossy" in run.stdout
    assert "3 white  RGB 255 255 255  D 0.08" in run.stdout


def test_show_speaks_json(profile):
    run = lccal("show", profile, "--readings", "--json")
    told = json.loads(run.stdout)
    assert told["contrast"] == pytest.approx(23.4423)
    assert told["keywords"]["MATERIAL"] == "glossy"
    assert [reading["density"] for reading in told["readings"]] == [
        0.07, 0.07, 0.08, 1.43, 1.44, 1.45]
    assert "readings" not in json.loads(lccal("show", profile, "--json").stdout)


def test_show_reads_other_programs_files():
    run = lccal("show", DEVICE / "TR006.ti3")
    assert run.returncode == 0
    assert "contrast        46.12" in run.stdout


def test_displays_are_told_in_luminances(tmp_path):
    table, profile = tmp_path / "d.csv", tmp_path / "d.cgats"
    table.write_text("R,G,B,X,Y,Z\n255,255,255,114,120,131\n0,0,0,0.15,0.15,0.25\n")
    run = lccal("enter", "--import", table, "--source", "luminance, cd/m2", "-o", profile)
    assert run.returncode == 0, run.stderr
    assert "J_max 120.000, J_min 0.150 cd/m2, contrast 800.00" in run.stderr
    assert "J_max (cd/m2)   120 " in lccal("show", profile).stdout
    assert history(profile)[0]["j_min"] == 0.15
    assert lccal("export", profile, "-o", tmp_path / "d.icc").returncode == 0
    assert (tmp_path / "d.icc").read_bytes()[12:16] == b"mntr"


@pytest.mark.parametrize("command", [["show"], ["verify", "--max-age", "1"], ["history"],
                                     ["export", "-o", "-", "--format", "csv"]])
def test_a_broken_profile_is_refused(tmp_path, profile, command):
    broken = tmp_path / "broken.cgats"
    text = profile.read_bytes()
    for change in (text[:-20], text.replace(b"23.4423", b"24.4423"),
                   text.replace(b"\t1.44\t", b"\t1,44\t"), b"", b"no profile\n"):
        broken.write_bytes(change)
        run = lccal(*command, broken)
        assert run.returncode == 7, run.stderr
        assert "broken.cgats" in run.stderr
        assert len(run.stderr.strip().splitlines()) == 1
    assert lccal(*command, tmp_path / "nowhere").returncode == 7


@pytest.mark.parametrize("change, code", [
    (lambda t: b"\xef\xbb\xbf" + t, 0), (lambda t: t.replace(b"\n", b"\r\n"), 0),
    (lambda t: t[:len(t) // 2], 7), (lambda t: t.replace(b"END_DATA\n", b""), 7),
    (lambda t: b"\xff\xfe" + t, 7), (lambda t: t.replace(b"SETS 6", b"SETS 600000000000000000"), 7),
    (lambda t: t.replace(b"1.44", b"1e999"), 7), (lambda t: t.replace(b"1.44", b"nan"), 7),
    (lambda t: t.replace(b'"white"', b'"' + b"w" * 1000000), 7), (lambda t: t + t, 0),
    (lambda t: t.replace(b"\n", b"\0\n"), 7), (lambda t: b"BEGIN_DATA\n" * 100000, 7),
], ids=["BOM", "CRLF", "half", "no end", "UTF-16", "hostile count", "overflow", "nan", "open quote",
        "twice", "NUL", "nothing but beginnings"])
def test_a_profile_file_is_read_or_refused_and_left_alone(tmp_path, profile, change, code):
    file = tmp_path / "changed.cgats"
    changed = change(profile.read_bytes())
    file.write_bytes(changed)
    for command in (("show",), ("verify", "--max-age", 1), ("export", "-o", tmp_path / "x.json")):
        run = lccal(command[0], file, *command[1:])
        assert run.returncode == code, run.stderr
    assert file.read_bytes() == changed
    assert (tmp_path / "x.json").exists() == (code == 0)


# ---- verify

def test_verify_accepts_a_device_that_stayed(tmp_path, profile):
    other = enter(tmp_path / "q.cgats", dmin="0.08", dmax="1.46")
    run = lccal("verify", profile, "--against", other, "--json")
    assert run.returncode == 0, run.stderr
    (told,) = events(run.stdout)
    assert told["event"] == "verify" and told["code"] == 0
    assert told["d_min_change"] == pytest.approx(0.01)
    assert told["d_max_change"] == pytest.approx(0.02)


@pytest.mark.parametrize("dmin, dmax, words", [("0.07", "1.48", "D_max by 0.04"),
                                               ("0.02", "1.44", "D_min by -0.05")])
def test_verify_finds_a_device_that_changed(tmp_path, profile, dmin, dmax, words):
    other = enter(tmp_path / "q.cgats", dmin=dmin, dmax=dmax)
    run = lccal("verify", profile, "--against", other, "--json")
    assert run.returncode == 8
    assert words in run.stderr
    (told,) = events(run.stdout)
    assert told["event"] == "verify" and told["code"] == 8 and words in told["text"]
    assert abs(told["d_min_change"]) + abs(told["d_max_change"]) > 0.03
    assert lccal("verify", profile, "--against", other, "--tolerance", "0.1").returncode == 0


@pytest.mark.parametrize("first, second", [
    (["--source", "ISO visual, 45/0"], ["--source", "status A, 45/0"]),
    (["--source", "reflection"], ["--source", "transmission"]),
    (["--backing", "white"], ["--backing", "black"]),
])
def test_verify_refuses_to_compare_what_differs_in_kind(tmp_path, first, second):
    a = enter(tmp_path / "a.cgats", *first)
    b = enter(tmp_path / "b.cgats", *second)
    run = lccal("verify", a, "--against", b)
    assert run.returncode == 8
    assert "cannot be compared" in run.stderr


def test_verify_refuses_to_compare_density_with_luminance(tmp_path, profile):
    run = lccal("verify", profile, "--against", DEVICE / "TR006.ti3")
    assert run.returncode == 8
    assert "cannot be compared" in run.stderr


def test_verify_knows_age(profile):
    assert lccal("verify", profile, "--max-age", "1").returncode == 0
    dated(profile, "2020-01-01T00:00:00Z")
    run = lccal("verify", profile, "--max-age", "365")
    assert run.returncode == 8
    assert "days old" in run.stderr
    dated(profile, "2999-01-01T00:00:00Z")
    run = lccal("verify", profile, "--max-age", "365")
    assert run.returncode == 8
    assert "clock" in run.stderr
    dated(profile, "some day")
    assert lccal("verify", profile, "--max-age", "365").returncode == 8


@pytest.mark.parametrize("contrast, code", [("23.44", 0), ("20", 8)])
def test_verify_measures_again(tmp_path, contrast, code):
    profile = tmp_path / "p.cgats"
    with Emulator("--auto-press", 3, "--contrast", "23.44") as device:
        run = lccal("--port", device.port, "--yes", "--readings", 3, "-o", profile)
        assert run.returncode == 0, run.stderr
    before = profile.read_bytes()
    with Emulator("--auto-press", 3, "--contrast", contrast) as device:
        run = lccal("verify", profile, "--port", device.port, "--yes", "--readings", 3)
        assert run.returncode == code, run.stderr
    assert profile.read_bytes() == before


@pytest.mark.parametrize("arguments, words", [
    ([], "verify compares"),
    (["--against", "x", "--port", "y"], "exclude"),
    (["--tolerance", "0", "--against", "x"], "greater than 0"),
    (["--max-age", "-1"], "greater than 0"),
    (["--max-age", "0", "--against", "x"], "greater than 0"),
    (["--tolerance", "a"], "number"),
])
def test_verify_wants_something_to_do(profile, arguments, words):
    run = lccal("verify", profile, *arguments)
    assert run.returncode == 2 and words in run.stderr


# ---- history

def test_history_is_in_the_order_of_dates(tmp_path):
    for name, date, dmax in (("b", "2026-03-01", "1.30"), ("a", "2026-05-01", "1.44"),
                             ("c", "2026-01-01", "1.44")):
        dated(enter(tmp_path / f"{name}.cgats", dmax=dmax), date)
    (tmp_path / "notes.txt").write_text("no profile")
    told = history(tmp_path)
    assert [event["created"] for event in told] == ["2026-01-01", "2026-03-01", "2026-05-01"]
    assert told[0]["change_percent"] == 0
    assert told[1]["change_percent"] == pytest.approx(100 * (10**-0.14 - 1), abs=0.1)
    text = lccal("history", tmp_path).stdout.splitlines()
    assert len(text) == 4 and text[1].startswith("2026-01-01")


def test_history_lists_the_backup(tmp_path, profile):
    enter(profile, dmax="1.30")
    told = history(profile)
    assert {event["path"] for event in told} == {str(profile), f"{profile}~"}


def test_history_of_an_empty_folder(tmp_path):
    assert lccal("history", tmp_path).returncode == 1


# ---- export

def icc_tags(data):
    count = struct.unpack(">I", data[128:132])[0]
    entries = [struct.unpack(">4sII", data[132 + 12 * i:144 + 12 * i]) for i in range(count)]
    return {name.decode(): data[offset:offset + size] for name, offset, size in entries}


@pytest.mark.parametrize("name", ["FOGRA39L.ti3", "TR006.ti3"])
def test_icc_keeps_the_contrast(tmp_path, name):
    output = tmp_path / "d.icc"
    assert lccal("export", DEVICE / name, "-o", output).returncode == 0
    data = output.read_bytes()
    assert len(data) == struct.unpack(">I", data[:4])[0]
    assert data[8:12] == b"\x02\x40\x00\x00" and data[36:40] == b"acsp"
    curve = icc_tags(data)["kTRC"]
    count, first = struct.unpack(">IH", curve[8:14])
    values = struct.unpack(f">{count}H", curve[12:12 + 2 * count])
    expected = {"FOGRA39L.ti3": 41.7238, "TR006.ti3": 46.1158}[name]
    assert 65535 / first == pytest.approx(expected, rel=5e-4)
    assert values[-1] == 65535 and list(values) == sorted(values)


def test_a_colour_management_module_finds_the_contrast(tmp_path, profile):
    image_cms = pytest.importorskip("PIL.ImageCms", reason="pillow with LittleCMS is missing")
    image = pytest.importorskip("PIL.Image")
    output = tmp_path / "d.icc"
    assert lccal("export", profile, "-o", output).returncode == 0
    grey = image_cms.getOpenProfile(str(output))
    lab = image_cms.createProfile("LAB")
    transform = image_cms.buildTransform(grey, lab, "L", "LAB", renderingIntent=1)
    black = image_cms.applyTransform(image.new("L", (1, 1), 0), transform).getpixel((0, 0))[0]
    white = image_cms.applyTransform(image.new("L", (1, 1), 255), transform).getpixel((0, 0))[0]
    assert white == 255
    lightness = 116 * (1 / 23.4423) ** (1 / 3) - 16
    assert black * 100 / 255 == pytest.approx(lightness, abs=0.25)  # 8 bits


def test_json_and_csv_hold_the_readings(tmp_path, profile):
    run = lccal("export", profile, "-o", "-", "--format", "json")
    document = json.loads(run.stdout)
    assert document["contrast"] == pytest.approx(23.4423, rel=1e-5)
    assert document["keywords"]["MATERIAL"] == "glossy"
    assert [reading["density"] for reading in document["readings"]][:3] == [0.07, 0.07, 0.08]
    table = tmp_path / "p.csv"
    assert lccal("export", profile, "-o", table).returncode == 0
    again = tmp_path / "again.cgats"
    assert lccal("enter", "--import", table, "-o", again).returncode == 0
    for name in ("LCOR_CONTRAST", "LCOR_CONTRAST_U95"):
        assert keyword(again, name) == keyword(profile, name)


@pytest.mark.parametrize("arguments", [["-o", "x.png"], [], ["-o", "x", "--format", "pdf"]])
def test_export_wants_a_format(tmp_path, profile, arguments):
    assert lccal("export", profile, *arguments, cwd=tmp_path).returncode == 2
    assert not list(tmp_path.glob("x*"))


def test_export_does_not_overwrite_the_profile(profile):
    before = profile.read_bytes()
    assert lccal("export", profile, "-o", profile, "--format", "csv").returncode == 2
    assert profile.read_bytes() == before


# ---- target

def tiff_fields(data):
    """Tags of a little-endian TIFF's first directory whose values are numbers in place."""
    assert data[:4] == b"II*\0"
    at = struct.unpack("<I", data[4:8])[0]
    fields = {}
    for i in range(struct.unpack("<H", data[at:at + 2])[0]):
        tag, kind, count, value = struct.unpack("<HHII", data[at + 2 + 12 * i:at + 14 + 12 * i])
        fields[tag] = (value & 0xFFFF if kind == 3 and count == 1 else value, kind, count)
    return fields


def test_target_writes_16_bit_tiff_and_pdf(tmp_path):
    run = lccal("target", "-o", tmp_path / "chart", "--dpi", "100")
    if "without libtiff" in run.stderr:
        pytest.skip("lccal was built without libtiff")
    assert run.returncode == 0, run.stderr
    assert "colour management off" in run.stderr
    data = (tmp_path / "chart.tif").read_bytes()
    fields = tiff_fields(data)
    assert fields[256][0] == 827 and fields[257][0] == 1169  # A4 at 100 dpi
    assert fields[277][0] == 3 and fields[262][0] == 2  # RGB
    bits = struct.unpack("<3H", data[fields[258][0]:fields[258][0] + 6])
    assert bits == (16, 16, 16)
    assert 34675 not in fields  # no colour profile
    pdf = (tmp_path / "chart.pdf").read_bytes()
    assert pdf.startswith(b"%PDF-1.4") and pdf.endswith(b"%%EOF\n")
    table = int(pdf.split(b"startxref\n")[1].split()[0])
    assert pdf[table:].startswith(b"xref")
    for i, line in enumerate(pdf[table:].splitlines()[3:8], 1):
        assert pdf[int(line[:10]):].startswith(f"{i} 0 obj".encode())


def test_target_pixels_are_the_levels(tmp_path):
    image = pytest.importorskip("PIL.Image", reason="pillow is missing")
    run = lccal("target", "-o", tmp_path / "chart.tif", "--dpi", "100", "--steps", "1")
    if "without libtiff" in run.stderr:
        pytest.skip("lccal was built without libtiff")
    with image.open(tmp_path / "chart.tif") as chart:
        levels = chart.convert("RGB").getcolors(1 << 24)
    assert {level for _, level in levels} == {(0, 0, 0), (128, 128, 128), (255, 255, 255)}


@pytest.mark.parametrize("ending", [".tif", ".pdf"])
def test_target_writes_what_the_ending_says(tmp_path, ending):
    run = lccal("target", "-o", tmp_path / f"t{ending}", "--page", "letter", "--dpi", "72")
    if "without libtiff" in run.stderr:
        pytest.skip("lccal was built without libtiff")
    assert run.returncode == 0
    assert [path.name for path in tmp_path.iterdir()] == [f"t{ending}"]


@pytest.mark.parametrize("arguments", [["--steps", "29"], ["--dpi", "10"], ["--page", "a5"], ["x"]])
def test_target_refuses_nonsense(tmp_path, arguments):
    assert lccal("target", *arguments, "-o", tmp_path / "t").returncode == 2
    assert not list(tmp_path.iterdir())


# ---- all

@pytest.mark.parametrize("command", ["enter", "show", "verify", "history", "export", "target"])
def test_every_command_explains_itself(command):
    run = lccal(command, "--help")
    assert run.returncode == 0 and f"lccal {command}" in run.stdout and run.stderr == ""
    run = lccal(command, "--no-such-option")
    assert run.returncode == 2 and "--no-such-option" in run.stderr


@pytest.mark.parametrize("command", [["show"], ["show", "--json"], ["history"],
                                     ["export", "-o", "-", "--format", "json"]])
def test_output_that_cannot_be_written_is_told(profile, command):
    with open("/dev/full", "w", encoding="ascii") as full:
        run = subprocess.run([LCCAL, *command, profile], stdout=full, stderr=subprocess.PIPE,
                             check=False)
    assert run.returncode == 1
    assert b"cannot write" in run.stderr
