# SPDX-License-Identifier: MIT
"""`lcor correct` against the equations written out here, over formats, channels and sizes."""

import math
import struct

import pytest
from gltf_scene import png
from lcor_run import good, oiiotool, pixels, refused, report, write_pfm

MATRIX = ((0.6067, 0.1736, 0.2001), (0.2988, 0.5868, 0.1144), (0.0, 0.0661, 1.1150))  # eq 1
WHITE = tuple(sum(row) for row in MATRIX)
COLOURS = [(250, 50, 150), (128, 128, 128), (20, 200, 90), (255, 255, 255), (60, 40, 30), (0, 0, 0)]
LIGHT = [0.9, 1.1, 1.0, 0.8, 1.2, 1.0]


def f(t):
    return t ** (1 / 3) if t > (6 / 29) ** 3 else t * 841 / 108 + 4 / 29


def inverse(t):
    return t**3 if t > 6 / 29 else (t - 4 / 29) * 108 / 841


def luminance(rgb):
    return sum(m * x for m, x in zip(MATRIX[1], rgb))


def corrected(rgb, r, r_mean, rho, contrast):
    """One linear colour by eqs 1-16 in the stable form; none here leaves the gamut."""
    y = luminance(rgb)
    t = 0.5 + (r / r_mean - 1) / 2 * (1 + 2 / (contrast - 1))
    new = min(max(t * y / rho, 0), 1)
    if new == 0:
        return (0.0, 0.0, 0.0)
    fx, fy, fz = (f(sum(m * x for m, x in zip(row, rgb)) / w) for row, w in zip(MATRIX, WHITE))
    fn = f(new)
    k = (fn - 4 / 29) / (fy - 4 / 29) if fn <= fy else (1 - fn) / (1 - fy)
    xyz = [inverse(v) * w for v, w in zip((fn + k * (fx - fy), fn, fn + k * (fz - fy)), WHITE)]
    return solve(xyz)


def solve(xyz):
    """MATRIX^-1 xyz by Cramer's rule."""

    def det(m):
        return (
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        )

    whole = det(MATRIX)
    return tuple(
        det([[xyz[i] if j == c else MATRIX[i][j] for j in range(3)] for i in range(3)]) / whole
        for c in range(3)
    )


@pytest.fixture
def light(tmp_path):
    return write_pfm(tmp_path / "light.pfm", [LIGHT])


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "in.png"
    path.write_bytes(png(6, 1, bytes(x for rgb in COLOURS for x in rgb)))
    return path


def expected(contrast=23.4):
    rgb = [tuple(x / 255 for x in colour) for colour in COLOURS]
    rho = sum(map(luminance, rgb)) / len(rgb)
    mean = math.exp(sum(math.log(e) for e in LIGHT) / len(LIGHT)) * rho
    return [corrected(c, e * rho, mean, rho, contrast) for c, e in zip(rgb, LIGHT)], rho, mean


@pytest.mark.parametrize(
    "depth, step", [("8", 1 / 255), ("16", 1 / 65535), ("half", 1e-3), ("float", 1e-5)]
)
def test_pixels_follow_the_equations_at_every_depth(tmp_path, picture, light, depth, step):
    out = tmp_path / ("out.exr" if depth == "half" else "out.tif")
    result = report(
        "correct",
        picture,
        "--illuminance",
        light,
        "--contrast",
        23.4,
        "-o",
        out,
        "--space",
        "ntsc",
        "--transfer",
        "linear",
        "--depth",
        depth,
    )
    values, rho, mean = expected()
    assert result["rho"] == pytest.approx(rho, rel=1e-6)
    assert result["r_mean"] == pytest.approx(mean, rel=1e-4)
    scale = {"8": 255, "16": 65535}.get(depth, 1)
    for got, want in zip(pixels(out), values):
        for a, b in zip(got, want):
            assert a / scale == pytest.approx(min(max(b, 0), 1), abs=1.01 * step + 2e-5)


def test_a_format_that_cannot_hold_the_depth_is_refused(tmp_path, picture, light):
    for name, depth in (("a.jpg", 16), ("a.png", "float")):
        refused(2, "correct", picture, "--illuminance", light, "--contrast", 9, "--depth", depth,
                "-o", tmp_path / name, says="samples at most")
        assert not (tmp_path / name).exists()


def test_conventional_is_the_product(tmp_path, picture, light):
    out = tmp_path / "out.tif"
    good(
        "correct",
        picture,
        "--illuminance",
        light,
        "--conventional",
        "--rho",
        0.5,
        "-o",
        out,
        "--transfer",
        "linear",
        "--depth",
        "float",
        "--space",
        "ntsc",
    )
    for got, colour, e in zip(pixels(out), COLOURS, LIGHT):
        assert got == pytest.approx([min(0.5 * e * x / 255, 1) for x in colour], abs=1e-5)


def test_alpha_extra_channels_and_metadata_are_kept(tmp_path, light):
    source = tmp_path / "in.png"
    alpha = [255, 255, 0, 128, 1, 255]
    source.write_bytes(
        png(6, 1, bytes(x for c, a in zip(COLOURS, alpha) for x in (*c, a)), colour_type=6)
    )
    tagged = tmp_path / "tagged.tif"
    oiiotool(source, "--attrib", "Copyright", "somebody", "-o", tagged)
    out = tmp_path / "out.tif"
    good("correct", tagged, "--illuminance", light, "--contrast", 9, "-o", out)
    assert [p[3] for p in pixels(out)] == [p[3] for p in pixels(tagged)]
    assert "somebody" in oiiotool("--info", "-v", out)
    refused(
        2,
        "correct",
        source,
        "--illuminance",
        light,
        "--contrast",
        9,
        "-o",
        tmp_path / "out.jpg",
        says="alpha",
    )
    # What does not show takes no part in the mean.
    clear = report(
        "correct", source, "--illuminance", light, "--contrast", 9, "-o", tmp_path / "o.png"
    )
    weights = [a / 255 for a in alpha]
    mean = math.exp(sum(w * math.log(e) for w, e in zip(weights, LIGHT)) / sum(weights))
    assert clear["r_mean"] / clear["rho"] == pytest.approx(mean, rel=1e-4)


def test_premultiplied_float_alpha(tmp_path, picture, light):
    """A colour under half alpha comes out as the same colour does alone, times alpha."""
    plain, half = tmp_path / "plain.exr", tmp_path / "half.exr"
    oiiotool(picture, "-d", "float", "-o", plain)
    oiiotool(picture, "-d", "float", "--ch", "R,G,B,A=1.0", "--mulc", "0.5", "-o", half)
    options = ("--illuminance", light, "--contrast", 9, "--mean", 0.5, "--rho", 0.5)
    good("correct", plain, *options, "-o", tmp_path / "a.exr")
    good("correct", half, *options, "-o", tmp_path / "b.exr")
    for a, b in zip(pixels(tmp_path / "a.exr"), pixels(tmp_path / "b.exr")):
        assert b == pytest.approx([*(0.5 * x for x in a), 0.5], abs=1e-5)


def test_gif_is_corrected_as_the_same_picture_in_png(tmp_path, picture, light):
    """Its reader says that alpha is the channel after the last one."""
    gif, straight = tmp_path / "in.gif", tmp_path / "straight.png"
    oiiotool(picture, "-o", gif)
    oiiotool(gif, "--ch", "R,G,B", "-o", straight)
    for path in (gif, straight):
        good(
            "correct", path, "--illuminance", light, "--contrast", 9, "-o", path.with_suffix(".tif")
        )
    opaque = [(*p, 255.0) for p in pixels(straight.with_suffix(".tif"))]
    assert pixels(gif.with_suffix(".tif")) == opaque


def test_pictures_after_the_first_of_a_file_are_counted_in_a_warning(tmp_path, picture, light):
    options = ("--illuminance", light, "--contrast", 9, "-o", tmp_path / "out.png")
    for name in ("parts.exr", "pages.tif", "frames.gif"):
        several = tmp_path / name
        oiiotool(picture, "--dup", "--dup", "--siappendall", "-o", several)
        said = report("correct", several, *options)["warnings"]
        assert said == [f"'{several}' holds 3 pictures; the first is taken"]
    assert report("correct", picture, *options)["warnings"] == []


def test_a_bilevel_tiff_that_leaves_its_bits_to_the_default_is_refused(tmp_path):
    def tiff(*bits):
        tags = [(256, 64), (257, 64), *bits, (259, 1), (262, 1), (273, 8), (278, 64), (279, 512)]
        entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
        start = struct.pack("<2sHI512s", b"II", 42, 520, b"\xaa" * 512)
        path = tmp_path / "in.tif"
        path.write_bytes(start + struct.pack("<H", len(tags)) + entries + bytes(4))
        return path

    assert report("info", tiff((258, 1)))["reflectance"] == pytest.approx(0.5)
    refused(3, "info", tiff(), says="1 bit a sample")


def test_grey_pictures_stay_grey(tmp_path, light):
    grey, colour = tmp_path / "grey.png", tmp_path / "colour.png"
    levels = [0, 30, 90, 128, 200, 255]
    grey.write_bytes(png(6, 1, bytes(levels), colour_type=0))
    colour.write_bytes(png(6, 1, bytes(x for v in levels for x in (v, v, v))))
    for path in (grey, colour):
        good(
            "correct", path, "--illuminance", light, "--contrast", 9, "-o", path.with_suffix(".tif")
        )
    assert [p[0] for p in pixels(grey.with_suffix(".tif"))] == [
        p[1] for p in pixels(colour.with_suffix(".tif"))
    ]
    assert len(pixels(grey.with_suffix(".tif"))[0]) == 1


def test_map_of_another_size_is_interpolated_between_aligned_centres(tmp_path):
    flat = tmp_path / "flat.png"
    flat.write_bytes(png(8, 4, bytes([128, 128, 128] * 32)))
    light = write_pfm(tmp_path / "light.pfm", [[1.0, 2.0], [3.0, 5.0]])
    out = tmp_path / "out.tif"
    good(
        "correct",
        flat,
        "--illuminance",
        light,
        "--conventional",
        "--rho",
        0.1,
        "--transfer",
        "linear",
        "--depth",
        "float",
        "-o",
        out,
    )
    got = [p[0] / (0.1 * 128 / 255) for p in pixels(out)]
    for y in range(4):
        for x in range(8):
            s = min(max((x + 0.5) / 4 - 0.5, 0), 1)
            t = min(max((y + 0.5) / 2 - 0.5, 0), 1)
            want = (1 - t) * (1 + s) + t * (3 + 2 * s)
            assert got[8 * y + x] == pytest.approx(want, rel=1e-5)


def test_maps_that_are_no_illuminance(tmp_path, picture):
    for value in (-1.0, math.nan, math.inf):
        light = write_pfm(tmp_path / "bad.pfm", [[1.0, value]])
        refused(
            3,
            "correct",
            picture,
            "--illuminance",
            light,
            "--contrast",
            9,
            "-o",
            tmp_path / "o.png",
            says="pixel (1, 0)",
        )
    dark = write_pfm(tmp_path / "dark.pfm", [[0.0]])
    run = good("correct", picture, "--illuminance", dark, "--contrast", 9, "-o", tmp_path / "o.png")
    assert "black" in run.stderr and {x for p in pixels(tmp_path / "o.png") for x in p} == {0}


def test_broken_float_pixels_are_counted_and_black(tmp_path, light):
    source = write_pfm(
        tmp_path / "in.pfm", [[(0.5, 0.5, 0.5), (math.nan, 0, 0), (-0.2, 0.1, 0.1)] * 2]
    )
    out = tmp_path / "out.exr"
    result = report("correct", source, "--illuminance", light, "--contrast", 9, "-o", out)
    assert result["non_finite"] == 4 and "row 0, column 1" in result["warnings"][0]
    assert pixels(out)[1] == (0, 0, 0) and pixels(out)[0][0] > 0


def test_device_tone_curve_is_applied(tmp_path, picture, light):
    profile = tmp_path / "p.cgats"
    ramp = [(0, 1.44), (64, 1.10), (128, 0.70), (192, 0.33), (255, 0.07)]
    profile.write_text(
        "CGATS.17\nNUMBER_OF_FIELDS 5\nBEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R RGB_G RGB_B D_VIS\n"
        f"END_DATA_FORMAT\nNUMBER_OF_SETS {len(ramp)}\nBEGIN_DATA\n"
        + "".join(f"{i} {v} {v} {v} {d}\n" for i, (v, d) in enumerate(ramp))
        + "END_DATA\n"
    )
    options = ("correct", picture, "--illuminance", light, "-o", tmp_path / "o.png")
    with_curve = report(*options, "--profile", profile)
    first = pixels(tmp_path / "o.png")
    report(*options, "--contrast", with_curve["contrast"])
    assert pixels(tmp_path / "o.png") != first


def test_threads_tiles_and_bands_change_no_byte(tmp_path):
    source = tmp_path / "in.png"
    source.write_bytes(png(700, 900, bytes((i * i // 7) % 251 for i in range(700 * 900 * 3))))
    light = write_pfm(tmp_path / "light.pfm", [[0.2, 1.0, 0.4], [1.5, 2.0, 0.3], [0.7, 0.1, 1.0]])
    tiled = tmp_path / "tiled.tif"
    oiiotool(source, "--tile", 64, 64, "-o", tiled)
    out, pixel_sets = [], []
    for n in (1, 2, 3):
        good(
            "correct",
            source,
            "--illuminance",
            light,
            "--contrast",
            9,
            "-o",
            tmp_path / "o.png",
            "--threads",
            n,
        )
        out.append((tmp_path / "o.png").read_bytes())
    assert out[0] == out[1] == out[2]
    for path in (source, tiled):
        good("correct", path, "--illuminance", light, "--contrast", 9, "-o", tmp_path / "o.tif")
        pixel_sets.append(pixels(tmp_path / "o.tif")[::997])
    assert pixel_sets[0] == pixel_sets[1]


def test_jpeg_refuses_more_than_it_holds(tmp_path, light):
    long = tmp_path / "long.png"
    options = ("--illuminance", light, "--contrast", 9, "-o", tmp_path / "o.jpg")
    for width in (65500, 65501):
        long.write_bytes(png(width, 1, bytes(width), colour_type=0))
        if width == 65500:
            good("correct", long, *options)
        else:
            refused(2, "correct", long, *options, says="65501 x 1")


def test_other_colours_than_rgb_are_said_to_be_converted(tmp_path, light):
    rgb = tmp_path / "rgb.png"
    rgb.write_bytes(png(2, 2, bytes(range(40, 160, 10))))
    cmyk = tmp_path / "cmyk.tif"
    oiiotool(rgb, "--attrib", "tiff:ColorSpace", "CMYK", "-o", cmyk)
    out = tmp_path / "o.tif"
    run = good("correct", cmyk, "--illuminance", light, "--contrast", 9, "-o", out)
    assert run.stderr.count("is not RGB") == 1
    assert "CMYK" in oiiotool("--info", "-v", cmyk)
    assert "CMYK" not in oiiotool("--info", "-v", out)
