# SPDX-License-Identifier: MIT
"""lccal enter: densities typed in, or measured by other programs."""

import random

import pytest
from lccal_bench import SOURCE, Session, comma_environment, events, keyword, lccal, rows

DEVICE = SOURCE / "tests" / "data" / "device"


def contrast(path):
    return float(keyword(path, "LCOR_CONTRAST"))


def assert_refused(run, code, words, output):
    assert run.returncode == code, run.stderr
    assert words in run.stderr
    assert len(run.stderr.strip().splitlines()) == 1
    assert not output.exists()


@pytest.mark.parametrize("name, black, expected", [
    ("FOGRA39L.ti3", "k", 41.72), ("TR006.ti3", "k", 46.12), ("FOGRA39L.ti3", "darkest", 100.7),
    ("TR006.ti3", "darkest", 116.83),
])
def test_printing_conditions_give_their_contrast(tmp_path, name, black, expected):
    output = tmp_path / "p.cgats"
    run = lccal("enter", "--import", DEVICE / name, "--black", black, "-o", output, "--json")
    assert run.returncode == 0, run.stderr
    assert contrast(output) == pytest.approx(expected, abs=0.05 if expected > 100 else 0.005)
    result = events(run.stdout)[-1]
    assert result["event"] == "result"
    assert result["contrast"] == pytest.approx(contrast(output), abs=1e-3)
    assert keyword(output, "IMPORTED_FROM") == name
    assert len(rows(output)) == 1617


def test_black_is_k_100_unless_told(tmp_path):
    output = tmp_path / "p.cgats"
    assert lccal("enter", "--import", DEVICE / "FOGRA39L.ti3", "-o", output).returncode == 0
    assert contrast(output) == pytest.approx(41.72, abs=0.005)
    assert keyword(output, "LCOR_BLACK") == "FULL"


def test_a_profile_is_imported_as_what_it_says(tmp_path):
    first, second = tmp_path / "a.cgats", tmp_path / "b.cgats"
    run = lccal("enter", "--import", DEVICE / "FOGRA39L.ti3", "--black", "darkest", "-o", first)
    assert run.returncode == 0
    assert lccal("enter", "--import", first, "-o", second).returncode == 0
    assert keyword(second, "LCOR_BLACK") == "DARKEST"
    assert contrast(second) == contrast(first)


def variants(text):
    """The same measurements as other programs might have written them."""
    head, data = text.split(b"BEGIN_DATA\r\n")
    yield "lf", text.replace(b"\r\n", b"\n")
    yield "cr", text.replace(b"\r\n", b"\r")
    yield "bom", b"\xef\xbb\xbf" + text
    yield "cgats17", text.replace(b"CTI3", b"CGATS.17", 1)
    yield "it87", text.replace(b"CTI3", b"IT8.7/1", 1)
    yield "no identifier", text.replace(b"CTI3\r\n", b"", 1)
    yield "no END_DATA_FORMAT", text.replace(b"END_DATA_FORMAT\r\n", b"")
    yield "no NUMBER_OF_SETS", text.replace(b"NUMBER_OF_SETS 1617\r\n", b"")
    yield "fewer sets", text.replace(b"SETS 1617", b"SETS 1700")
    yield "more sets", text.replace(b"SETS 1617", b"SETS 16")
    yield "hostile sets", text.replace(b"SETS 1617", b"SETS 4294967297000000000000")
    yield "hostile fields", text.replace(b"FIELDS 11", b"FIELDS 18446744073709551615")
    yield "latin-1", text.replace(b"Fogra,", b"M\xfcller & S\xf6hne,")
    yield "comments", text.replace(b"CREATED", b"# \"note\r\nCREATED").replace(
        b'KEYWORD "COLOR_REP"', b'KEYWORD "COLOR_REP" # trailing words')
    yield "tabs", head + b"BEGIN_DATA\r\n" + b"\n".join(
        b"\t".join(line.split()) for line in data.splitlines())


def test_ways_of_writing_do_not_matter(tmp_path):
    text = (DEVICE / "FOGRA39L.ti3").read_bytes()
    for name, variant in variants(text):
        source, output = tmp_path / "m.ti3", tmp_path / "p.cgats"
        source.write_bytes(variant)
        run = lccal("enter", "--import", source, "-o", output)
        assert run.returncode == 0, f"{name}: {run.stderr}"
        assert contrast(output) == pytest.approx(41.72, abs=0.005), name


def change_column(text, name, change):
    lines = text.decode("latin-1").splitlines()
    start, end = lines.index("BEGIN_DATA") + 1, lines.index("END_DATA")
    column = lines[lines.index("BEGIN_DATA_FORMAT") + 1].split().index(name)
    for i in range(start, end):
        fields = lines[i].split()
        fields[column] = change(fields[column])
        lines[i] = " ".join(fields)
    return "\n".join(lines).encode("latin-1")


@pytest.mark.parametrize("change, words", [
    (lambda t: t.replace(b"XYZ_X XYZ_Y XYZ_Z LAB_L", b"XYZ_Y XYZ_X XYZ_Z LAB_L"), "contradict"),
    (lambda t: t.replace(b"XYZ_X XYZ_Y XYZ_Z LAB_L LAB_A LAB_B",
                         b"LAB_L LAB_A LAB_B XYZ_X XYZ_Y XYZ_Z"), "XYZ_Y"),
    (lambda t: t.replace(b"XYZ_X XYZ_Y XYZ_Z LAB_L LAB_A LAB_B",
                         b"D_RED D_GREEN D_BLUE D_VIS OTHER MORE"), "no density"),
    (lambda t: t.replace(b"XYZ_X XYZ_Y XYZ_Z LAB_L LAB_A LAB_B",
                         b"D_RED D_GREEN D_BLUE A B C"), "line"),
    (
        lambda t: t.replace(b"XYZ_X XYZ_Y XYZ_Z LAB_L LAB_A LAB_B", b"A B C D E F"),
        "no column D_VIS",
    ),
    (lambda t: t.replace(b"CMYK_C CMYK_M CMYK_Y CMYK_K", b"A B C D"), "which patch is black"),
    (lambda t: t.replace(b"CMYK_C CMYK_M CMYK_Y CMYK_K", b"CMYK_K CMYK_M CMYK_Y CMYK_C"),
     "strong colour"),
    (lambda t: t.replace(b"CMYK_C CMYK_M CMYK_Y CMYK_K", b"CMYK_C CMYK_K CMYK_Y CMYK_M"),
     "strong colour"),
    (lambda t: t.replace(b"CMYK_C CMYK_M CMYK_Y CMYK_K", b"CMYK_C CMYK_M CMYK_K CMYK_Y"),
     "strong colour"),
    (lambda t: t.replace(b" XYZ_Y ", b" Y "), "some are missing"),
    (lambda t: change_column(t, "XYZ_Y", lambda y: "-" + y), "XYZ_Y"),
    (lambda t: change_column(t, "XYZ_Y", lambda y: y.replace(".", ",")), "comma"),
    (lambda t: change_column(t, "XYZ_Y", lambda y: "nan"), "not a number"),
    (lambda t: change_column(t, "CMYK_K", lambda k: "0"), "black"),
    (lambda t: change_column(t, "CMYK_K", lambda k: str(100 - float(k))), ""),
    (lambda t: t.replace(b"2.02    2.10    1.73", b"2.02    2.10"), "10 fields"),
    (lambda t: t.replace(b"END_DATA\r\n", b""), "cut short"),
    (lambda t: t.decode("latin-1").encode("utf-16"), "UTF-16"),
    (lambda t: b"", "empty"),
    (lambda t: b"\x00" * 100, "line 1"),
    (lambda t: b"\x7fELF" + bytes(range(256)) * 4, "line"),
])
def test_mislabelled_and_broken_files_are_refused(tmp_path, change, words):
    source, output = tmp_path / "m.ti3", tmp_path / "p.cgats"
    source.write_bytes(change((DEVICE / "FOGRA39L.ti3").read_bytes()))
    assert_refused(lccal("enter", "--import", source, "-o", output), 7, words, output)


def test_luminance_from_0_to_1_is_understood(tmp_path):
    text = (DEVICE / "FOGRA39L.ti3").read_bytes()
    for name in ("XYZ_X", "XYZ_Y", "XYZ_Z"):
        text = change_column(text, name, lambda value: f"{float(value) / 100:.6f}")
    source, output = tmp_path / "m.ti3", tmp_path / "p.cgats"
    source.write_bytes(text)
    assert lccal("enter", "--import", source, "-o", output).returncode == 0
    assert contrast(output) == pytest.approx(41.72, abs=0.005)


def test_a_file_cut_anywhere_is_right_or_refused(tmp_path):
    text = (DEVICE / "TR006.ti3").read_bytes()
    draw = random.Random(1)
    for cut in [1, 10, 11, 12, 40] + [draw.randrange(len(text)) for _ in range(40)]:
        source, output = tmp_path / "m.ti3", tmp_path / "p.cgats"
        source.write_bytes(text[:-cut])
        run = lccal("enter", "--import", source, "-o", output)
        if run.returncode == 0:
            assert contrast(output) == pytest.approx(46.12, abs=0.005)
            output.unlink()
        else:
            assert_refused(run, 7, "", output)


def test_darkest_of_an_incomplete_file_is_refused(tmp_path):
    text = (DEVICE / "TR006.ti3").read_bytes()
    source, output = tmp_path / "m.ti3", tmp_path / "p.cgats"
    source.write_bytes(text.replace(b"NUMBER_OF_SETS    1617", b"NUMBER_OF_SETS 1700"))
    run = lccal("enter", "--import", source, "--black", "darkest", "-o", output)
    assert_refused(run, 7, "darkest", output)


I1PROFILER = """CGATS.17
ORIGINATOR "i1Profiler"
CREATED "11/22/2026 #Time: 10:20:30"
INSTRUMENTATION "i1Pro 2 ; Serial number 1000001"
MEASUREMENT_SOURCE "Illumination=D50 ObserverAngle=2_degree WhiteBase=Abs Filter=No"
KEYWORD "SAMPLE_NAME2"
NUMBER_OF_FIELDS 11
BEGIN_DATA_FORMAT
SAMPLE_ID SAMPLE_NAME RGB_R RGB_G RGB_B LAB_L LAB_A LAB_B nm380 nm390 nm400
END_DATA_FORMAT
NUMBER_OF_SETS 3
BEGIN_DATA
1 "A1" 255.00 255.00 255.00 95.00 0.10 -2.00 0.81 0.82 0.83
2 "A2" 128.00 128.00 128.00 53.00 0.10 -1.00 0.21 0.22 0.23
3 "A3" 0.00 0.00 0.00 16.00 0.30 0.20 0.02 0.02 0.02
END_DATA
"""


def test_i1profiler_text_with_lab_alone_is_read(tmp_path):
    source, output = tmp_path / "m.txt", tmp_path / "p.cgats"
    source.write_text(I1PROFILER.replace("\n", "\r\n"))
    run = lccal("enter", "--import", source, "-o", output)
    assert run.returncode == 0, run.stderr
    assert contrast(output) == pytest.approx(((95 + 16) / (16 + 16)) ** 3, rel=1e-5)
    assert keyword(output, "CREATED") == "11/22/2026 #Time: 10:20:30"


def test_csv_is_read(tmp_path):
    source, output = tmp_path / "m.csv", tmp_path / "p.cgats"
    source.write_text("patch,density\nwhite,0.07\nwhite,0.08\nwhite,0.07\n"
                      "black,1.44\nblack,1.44\nblack,1.44\n")
    run = lccal("enter", "--import", source, "-o", output)
    assert run.returncode == 0, run.stderr
    assert contrast(output) == pytest.approx(10**1.37, rel=1e-5)
    assert float(keyword(output, "LCOR_CONTRAST_U95")) > 0.2


def test_csv_with_decimal_commas_is_refused(tmp_path):
    source, output = tmp_path / "m.csv", tmp_path / "p.cgats"
    source.write_text("R;G;B;D\n255;255;255;0,07\n0;0;0;1,44\n")
    assert_refused(lccal("enter", "--import", source, "-o", output), 7, "decimal point", output)


def test_densities_as_arguments(tmp_path):
    output = tmp_path / "p.cgats"
    run = lccal("enter", "--dmin", "0.07,0.07,0.08", "--dmax", "1.43,1.44,1.45", "-o", output,
                "--instrument", "Macbeth TD-904", "--source", "ISO visual, 45/0", "--material",
                "glossy paper", "--backing", "black", "--conditions", "best quality")
    assert run.returncode == 0, run.stderr
    assert contrast(output) == pytest.approx(10**1.37, rel=1e-5)
    assert [row[5] for row in rows(output)] == ["0.07", "0.07", "0.08", "1.43", "1.44", "1.45"]
    assert keyword(output, "LCOR_RESOLUTION") == "0.01"
    assert keyword(output, "INSTRUMENTATION") == "Macbeth TD-904"
    assert keyword(output, "MEASUREMENT_SOURCE") == "ISO visual, 45/0"
    assert keyword(output, "MATERIAL") == "glossy paper"
    assert keyword(output, "CREATED").endswith("Z")


def test_a_reading_gone_wrong_is_kept_and_marked(tmp_path):
    output = tmp_path / "p.cgats"
    run = lccal("enter", "--dmin", "0.07,0.07,0.08,0.17,0.07", "--dmax", "1.44", "-o", output)
    assert run.returncode == 0, run.stderr
    assert "reading 4 does not agree" in run.stderr
    assert [row[-1] for row in rows(output)] == ["0", "0", "0", "1", "0", "0"]


@pytest.mark.parametrize("arguments, code, words", [
    (["--dmin", "1.44", "--dmax", "0.07"], 6, "exchanged"),
    (["--dmin", "0.07", "--dmax", "0.07"], 6, "read the same"),
    (["--dmin", "0,07", "--dmax", "1.44"], 6, "no density"),
    (["--dmin", "0.07", "--dmax", "1,44"], 6, "no density"),
    (["--dmin", "0.07", "--dmax", "7"], 6, "no density"),
    (["--dmin", "0.07", "--dmax", "0.9,1.44"], 6, "do not agree"),
    (["--dmin", "0.07", "--dmax", "nan"], 2, "no density"),
    (["--dmin", "0.07", "--dmax", ""], 2, "no density"),
    (["--dmin", "0.07", "--dmax", "1.44", "--import", "x"], 2, "exclude"),
    (["--import", "x", "--black", "grey"], 2, "--black"),
    (["--black", "k", "--dmin", "0.07", "--dmax", "1.44"], 2, "--import"),
    (["--dmin", "0.07", "--dmax", "1.44", "--material", 'a "b"'], 2, "MATERIAL"),
    (["--dmin", "0.07"], 2, "--dmax"),
    (["extra"], 2, "one argument too many"),
    (["--import", "/nowhere/at/all.ti3"], 7, "/nowhere/at/all.ti3"),
])
def test_wrong_arguments(tmp_path, arguments, code, words):
    output = tmp_path / "p.cgats"
    run = lccal("enter", *arguments, "-o", output)
    assert run.returncode == code, run.stderr
    assert words in run.stderr
    assert not output.exists()


def test_densities_are_asked_for(tmp_path):
    output = tmp_path / "p.cgats"
    with Session("enter", "-o", output) as session:
        for patch, lines in (("white", ["0.07", "0.0x", "0.08", ""]),
                             ("black", ["144", "1.44", ""])):
            for line in lines:
                session.until("prompt", patch=patch)
                session.answer(line)
        assert session.end() == 0, session.errors
    assert [row[5] for row in rows(output)] == ["0.07", "0.08", "1.44"]
    slips = [event["text"] for event in session.seen if event["event"] == "warning"]
    assert len(slips) == 2 and "'0.0x' is no density" in slips[0] and "144" in slips[1]
    assert "error" not in {event["event"] for event in session.seen}


def test_q_quits(tmp_path):
    with Session("enter", "-o", tmp_path / "p.cgats") as session:
        session.until("prompt", patch="white")
        session.answer("q")
        assert session.end() == 130
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("answers", [[], ["0.07"], ["0.07", ""], ["0.07", "", "1.44"]])
def test_sigint_at_each_prompt_leaves_the_earlier_profile(tmp_path, answers):
    output = tmp_path / "p.cgats"
    output.write_bytes(b"an earlier profile\n")
    with Session("enter", "-o", output) as session:
        session.until("prompt")
        for answer in answers:
            session.answer(answer)
            session.until("prompt")
        session.interrupt()
        assert session.end() == 130
    assert output.read_bytes() == b"an earlier profile\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["p.cgats"]


def test_the_earlier_profile_is_kept_beside_the_new_one(tmp_path):
    output = tmp_path / "p.cgats"
    output.write_bytes(b"an earlier profile\n")
    assert lccal("enter", "--dmin", "0.07", "--dmax", "1.44", "-o", output).returncode == 0
    assert (tmp_path / "p.cgats~").read_bytes() == b"an earlier profile\n"
    assert contrast(output) == pytest.approx(10**1.37, rel=1e-5)


def test_a_comma_locale_changes_nothing(tmp_path):
    output = tmp_path / "p.cgats"
    run = lccal("enter", "--import", DEVICE / "FOGRA39L.ti3", "-o", output,
                env=comma_environment(tmp_path))
    assert run.returncode == 0
    assert keyword(output, "LCOR_CONTRAST") == "41.7238"


LAYOUTS = {
    # CGATS of other programs
    "quoted numbers": ("SAMPLE_ID SAMPLE_NAME RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z",
                       '"1" "A 1" "255.0" "255.0" "255.0" "80" "84" "70"\n'
                       '"2" "A 2" "0.0" "0.0" "0.0" "2.0" "2.1" "1.7"', 40.0),
    "XYZ alone": ("RGB_R RGB_G RGB_B XYZ_X XYZ_Y XYZ_Z",
                  "255 255 255 80 84 70\n0 0 0 2.0 2.1 1.7", 40.0),
    "LAB alone": ("CMYK_C CMYK_M CMYK_Y CMYK_K LAB_L LAB_A LAB_B",
                  "0 0 0 0 95 0 -2\n0 0 0 100 16 0 0", (111 / 32) ** 3),
    "density alone": ("RGB_R RGB_G RGB_B D_VIS", "100 100 100 0.07\n0 0 0 1.44", 10**1.37),
    "spectra alone": ("RGB_R RGB_G RGB_B SPECTRAL_NM380 SPECTRAL_NM390 SPECTRAL_NM400",
                      "255 255 255 .9 .9 .9\n0 0 0 .02 .02 .02", "no column D_VIS"),
    "without D_VIS": ("RGB_R RGB_G RGB_B D_RED D_GREEN D_BLUE",
                      "255 255 255 .07 .07 .07\n0 0 0 1.4 1.4 1.4", "no column D_VIS"),
    "decimal commas": ("RGB_R RGB_G RGB_B D_VIS", "255 255 255 0,07\n0 0 0 1,44", "comma"),
    # tables
    "semicolons": (None, "R;G;B;D\n255;255;255;0.07\n0;0;0;1.44\n", 10**1.37),
    "spreadsheet": (None, "sep=;\nR;G;B;D\n255;255;255;0.07\n0;0;0;1.44\n", 10**1.37),
    "byte order mark": (None, "\ufeffR,G,B,D\r\n255,255,255,0.07\r\n0,0,0,1.44\r\n", 10**1.37),
    "tabs": (None, "R\tG\tB\tD\n255\t255\t255\t0.07\n0\t0\t0\t1.44\n", 10**1.37),
    "table of L*a*b*": (None, "R,G,B,L*,a*,b*\n255,255,255,95,0,0\n0,0,0,16,0,0\n",
                        (111 / 32) ** 3),
    "table of inks": (None, "C,M,Y,K,D\n0,0,0,0,0.07\n0,0,0,100,1.44\n", 10**1.37),
    "quoted commas": (None, '"R","G","B","D"\n255,255,255,"0,07"\n0,0,0,"1,44"\n', "comma"),
    "commas in commas": (None, "R,G,B,D\n255,255,255,0,07\n0,0,0,1,44\n", "comma"),
    "exchanged": (None, "R,G,B,D\n0,0,0,0.07\n255,255,255,1.44\n", "lighter than white"),
    "Y of inks or of light": (None, "C,M,Y,K,X,Y,Z\n0,0,0,0,80,84,70\n0,0,0,100,2,2.1,1.7\n",
                              "twice"),
    "percent signs": (None, "R,G,B,D\n100%,100%,100%,0.07\n0%,0%,0%,1.44\n", "not a number"),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layout_of_another_program_gives_its_contrast_or_a_clear_error(tmp_path, layout):
    columns, text, expected = LAYOUTS[layout]
    if columns:
        text = (f'CGATS.17\nORIGINATOR "somebody"\nNUMBER_OF_FIELDS {len(columns.split())}\n'
                f"BEGIN_DATA_FORMAT\n{columns}\nEND_DATA_FORMAT\nNUMBER_OF_SETS 2\n"
                f"BEGIN_DATA\n{text}\nEND_DATA\n")
    source, output = tmp_path / "m.txt", tmp_path / "p.cgats"
    source.write_text(text)
    run = lccal("enter", "--import", source, "-o", output)
    if isinstance(expected, str):
        assert_refused(run, 7, expected, output)
    else:
        assert run.returncode == 0, run.stderr
        assert contrast(output) == pytest.approx(expected, rel=1e-4)
