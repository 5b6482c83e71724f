# SPDX-License-Identifier: MIT
"""rastertolcor by itself: formats, options, refusals, what it leaves behind."""

import contextlib
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import raster
from conftest import FILTER
from raster import ADOBERGB, BANDED, CMYK, MARK, PLANAR, RGB, SGRAY, SRGB, K, Page, W

ONE_PIXEL = np.full((1, 1, 3), 128, np.uint8)


def picture(height=40, width=64, colours=3, dtype=np.uint8, seed=1):
    """Colours of medium chroma, so that the corrected ones stay in the gamut."""
    rng = np.random.default_rng(seed)
    grey = rng.uniform(0.25, 0.75, (height, width, 1))
    tint = rng.uniform(-0.04, 0.04, (height, width, colours)) if colours > 1 else 0
    return np.round((grey + tint) * np.iinfo(dtype).max).astype(dtype)


def ramp(height, width):
    """Illuminance from 0.6 to 1.6, bent both ways."""
    y, x = np.mgrid[0:height, 0:width]
    return (0.6 + 0.5 * (x / max(1, width - 1)) ** 2 + 0.5 * y / max(1, height - 1)).astype("<f4")


def save_pfm(path, light):
    path.write_bytes(
        b"Pf\n%d %d\n-1.0\n" % (light.shape[1], light.shape[0])
        + light[::-1].astype("<f4").tobytes()
    )
    return path


def reference(stored, light, r_mean, contrast=23.4, rho=0.5, gamma=None):
    """Equations 12 and 13b-16 in plain numpy, for colours that stay in the gamut."""
    if gamma is None:
        linear = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)
        m = np.array(
            [
                [0.4124564, 0.3575761, 0.1804375],
                [0.2126729, 0.7151522, 0.0721750],
                [0.0193339, 0.1191920, 0.9503041],
            ]
        )
    else:
        linear = stored**gamma
        m = np.array(
            [[0.57667, 0.18556, 0.18823], [0.29734, 0.62736, 0.07529], [0.02703, 0.07069, 0.99134]]
        )
    white = m @ np.ones(3)

    def f_of(t):
        return np.where(t > (6 / 29) ** 3, np.cbrt(t), t * 841 / 108 + 4 / 29)

    def t_of(f):
        return np.where(f > 6 / 29, f**3, (f - 4 / 29) * 108 / 841)

    xyz = linear @ m.T / white
    f = f_of(xyz)
    q = light * rho / r_mean
    t = np.maximum(0.5 + (q - 1) / 2 * (1 + 2 / (contrast - 1)), 0)
    fn = f_of(np.clip(t * xyz[..., 1] / rho, 0, 1))
    fy = f[..., 1]
    k = np.where(fn <= fy, (fn - 4 / 29) / (fy - 4 / 29), (1 - fn) / (1 - fy))
    fnew = np.stack([fn + k * (f[..., i] - fy) for i in range(3)], axis=-1)
    out = t_of(fnew) * white @ np.linalg.inv(m).T
    assert out.min() > 0 and out.max() < 1
    if gamma is None:
        return np.where(out <= 0.0031308, out * 12.92, 1.055 * out ** (1 / 2.4) - 0.055)
    return out ** (1 / gamma)


def mean_said(result):
    return [float(x) for x in re.findall(r"r_mean ([0-9.e+-]+)", result.log)]


@pytest.mark.parametrize("space", [RGB, SRGB, ADOBERGB, W, SGRAY, K])
@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("order", [raster.CHUNKED, BANDED])
def test_every_format_gives_the_colours_of_the_equations(correct, tmp_path, space, bits, order):
    colours, dtype = (1 if space in (W, SGRAY, K) else 3), np.dtype(f"u{bits // 8}")
    top = np.iinfo(dtype).max
    pixels = picture(colours=colours, dtype=dtype)
    light = ramp(*pixels.shape[:2])
    result = correct(
        raster.write([Page(pixels, space, order)]),
        f"lcor-contrast=23.4 lcor-illuminance={save_pfm(tmp_path / 'map.pfm', light)}",
    )
    assert result.code == 0, result.log
    (page,) = raster.read(result.out)
    stored = pixels / top
    if space == K:
        stored = 1 - stored
    expected = reference(
        np.broadcast_to(stored, (*stored.shape[:2], 3)),
        light.astype(float),
        mean_said(result)[0],
        gamma=563 / 256 if space == ADOBERGB else None,
    )[..., :colours]
    if space == K:
        expected = 1 - expected
    # Half a step of rounding; float kernels and 7-digit matrices stay far below 1/65535.
    assert np.abs(page.pixels - expected * top).max() < (0.51 if bits == 8 else 2.0)
    assert (page.space, page.order) == (space, order)


@pytest.mark.parametrize("kind", ["v3", "v3-big", "v2", "pwg"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_every_kind_of_stream_carries_the_same_picture(correct, kind, dtype):
    pixels = picture(dtype=dtype)
    pixels[3:9] = pixels[3]  # repeated rows and pixels take other paths through the compression
    pixels[:, 10:30] = pixels[:, 10:11]
    options = "lcor-contrast=5 lcor-reading=texel"
    result = correct(raster.write([Page(pixels)], kind), options)
    assert result.code == 0, result.log
    assert result.out[:4] == {"v3": b"3SaR", "v3-big": b"3SaR", "v2": b"2SaR", "pwg": b"RaS2"}[kind]
    plain = correct(raster.write([Page(pixels)]), options)
    assert np.array_equal(raster.read(result.out)[0].pixels, raster.read(plain.out)[0].pixels)
    assert not np.array_equal(raster.read(result.out)[0].pixels, pixels)


def patterns(dtype, colours):
    """Runs and stretches about the lengths where their codes end; rows come up to 300 times."""
    lengths = [1, 1, 2, 1, 3, 127, 1, 128, 2, 129, 1, 1, 130, 256, 257, 1]
    repeats = np.repeat(np.arange(len(lengths)), lengths) % 2 * 200
    stretches = np.arange(repeats.size) % 251
    mixed = np.where(np.repeat(np.arange(len(lengths)), lengths) % 3 == 0, stretches, repeats)
    rows = np.stack([repeats, stretches, mixed, mixed[::-1], np.zeros_like(mixed)])
    page = rows[np.repeat([0, 1, 2, 3, 2, 4, 0], [1, 2, 3, 1, 255, 300, 257])]
    channels = page[..., None] + np.arange(colours) * 3
    return channels.astype(dtype) * (1 if dtype == np.uint8 else 259)


@pytest.mark.parametrize("kind", ["v2", "pwg"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize(
    ("space", "order"), [(SRGB, raster.CHUNKED), (SRGB, BANDED), (K, raster.CHUNKED)]
)
def test_packed_rows_are_read_back_as_they_were(correct, kind, dtype, space, order):
    pixels = patterns(dtype, 3 if space == SRGB else 1)
    once = correct(raster.write([Page(pixels, space, order)], kind), "lcor-correction=off")
    assert once.code == 0, once.log
    assert np.array_equal(raster.read(once.out)[0].pixels, pixels)
    assert len(once.out) < pixels.nbytes / 20
    # libcups reads the same from it
    assert correct(once.out, "lcor-correction=off").out == once.out


def test_pwg_headers_go_through_whole(correct):
    page = Page(picture(), words={"PrintQuality": 5, "ImageBoxLeft": 77, "NumCopies": 3})
    (out,) = raster.read(correct(raster.write([page], "pwg")).out)
    assert (out.words["PrintQuality"], out.words["ImageBoxLeft"], out.words["NumCopies"]) == (
        5,
        77,
        3,
    )


def test_even_light_changes_no_byte_of_the_pixels(correct, tmp_path):
    every = np.arange(256 * 3 * 16, dtype=np.uint32).reshape(16, 256, 3)
    light = save_pfm(
        tmp_path / "map.pfm", np.full((2, 2), 7.0)
    )  # through the plan; without: past it
    for dtype in (np.uint8, np.uint16):
        pixels = (every * 2654435761 % (np.iinfo(dtype).max + 1)).astype(dtype)
        for options in ("", f" lcor-illuminance={light}"):
            (out,) = raster.read(
                correct(raster.write([Page(pixels)]), "lcor-contrast=9" + options).out
            )
            assert np.array_equal(out.pixels, pixels)


def repeating(rng, height, width, colours):
    """Paper, letters, and a photograph that a renderer enlarged 6.67 times."""
    pixels = np.full((height, width, colours), 255, np.uint8)
    letters = rng.integers(0, 3, (height // 8, width)) == 0
    pixels[height // 4 : height // 2][letters.repeat(8, 0)[: height // 2 - height // 4]] = 20
    small = rng.integers(60, 200, (height // 2, width, colours), np.uint8)
    y, x = ((np.arange(n) / 6.67).astype(int) for n in (height - height // 2, width))
    pixels[height // 2 :] = small[y][:, x]
    return pixels


@pytest.mark.parametrize("space", [SRGB, W, K])
@pytest.mark.parametrize("light", ["even", "steps", "map"])
def test_what_repeats_comes_out_as_if_each_pixel_were_computed(correct, tmp_path, space, light):
    rng = np.random.default_rng(3)
    shape = (700, 401, 3 if space == SRGB else 1)
    paper, noise = repeating(rng, *shape), rng.integers(0, 256, shape, np.uint8)
    here = rng.integers(0, 2, shape[:2], np.uint8)[..., None] == 0
    options = "lcor-contrast=9 lcor-reading=texel lcor-mean=0.4"
    if light != "even":
        stretched = 1 + ramp(5, 7) / 10 if light == "steps" else ramp(*shape[:2])
        options += f" lcor-illuminance={save_pfm(tmp_path / 'map.pfm', stretched)}"
    pages = (paper, noise, np.where(here, paper, noise), np.where(here, noise, paper))
    runs = [correct(raster.write([Page(p, space)]), options) for p in pages]
    assert all(run.code == 0 for run in runs), runs[0].log
    a, b, mixed, other = (raster.read(run.out)[0].pixels for run in runs)
    # A pixel comes out as its colour and its light say, whatever lies about it.
    assert np.array_equal(mixed, np.where(here, a, b))
    assert np.array_equal(other, np.where(here, b, a))
    computed = [int(re.findall(r"(\d+) pixels computed", run.log)[0]) for run in runs]
    assert computed[0] < here.size * {"even": 0.2, "steps": 0.3, "map": 1}[light] + 1
    assert 0.99 * here.size < computed[1] <= here.size


def test_banded_order_gets_the_same_light(correct, tmp_path):
    pixels = picture(120, 90)
    light = save_pfm(tmp_path / "map.pfm", 1 + ramp(5, 7) / 10)
    options = f"lcor-contrast=9 lcor-illuminance={light}"
    a, b = (correct(raster.write([Page(pixels, SRGB, o)]), options) for o in (0, BANDED))
    assert np.array_equal(raster.read(a.out)[0].pixels, raster.read(b.out)[0].pixels)


def test_the_steps_of_light_are_too_small_to_be_seen(correct, tmp_path):
    rng = np.random.default_rng(4)
    height, width = 400, 600
    pixels = rng.integers(0, 256, (height, width, 1), np.uint8).repeat(3, 2)
    light = 1 + ramp(4, 6) / 5
    light[2, 3] = 40  # an edge, which is no place for steps
    options = f"lcor-contrast=23.4 lcor-illuminance={save_pfm(tmp_path / 'map.pfm', light)}"
    in_steps = correct(raster.write([Page(pixels)]), options)
    smooth = correct(raster.write([Page(pixels * np.uint16(257))]), options)
    assert in_steps.code == 0 and smooth.code == 0, in_steps.log
    a = raster.read(in_steps.out)[0].pixels.astype(float)
    off = np.abs(a - raster.read(smooth.out)[0].pixels / 257)
    # Light is off by half a step along and half a step down, T / q by as much of 0.545, Ynew / Y by
    # 0.545 q / T of it. A code is 255 1.055 Ynew^(1/2.4), so it is off by 0.24 at the most where q
    # is above 0.5; and the light is nowhere near the edge below that. Half a code is rounding.
    assert off.max() < 0.5 + 0.27


def test_a_corrected_page_is_marked_and_not_corrected_again(correct):
    for kind in ("v3", "v2", "pwg"):
        once = correct(raster.write([Page(picture())], kind), "lcor-contrast=5 lcor-reading=texel")
        assert raster.read(once.out)[0].strings == {15: MARK}
        twice = correct(once.out, "lcor-contrast=5 lcor-reading=texel")
        assert twice.code == 0 and twice.out == once.out
        assert "corrected already" in twice.log


def test_the_mark_takes_a_string_no_driver_uses(correct):
    taken = {15: b"driver", 14: b"also"}
    (out,) = raster.read(correct(raster.write([Page(picture(), strings=taken)])).out)
    assert out.strings == taken | {13: MARK}
    full = {i: b"x" for i in range(16)}
    result = correct(raster.write([Page(picture(), strings=full)]))
    assert result.code == 0 and raster.read(result.out)[0].strings == full
    assert "WARNING: page 1: no cupsString is free" in result.log


def test_pages_are_counted_with_their_copies_by_the_last_filter_only(correct):
    data = raster.write([Page(picture()), Page(picture(8, 9), words={"NumCopies": 2})])
    for env, said in [
        ({}, True),
        ({"FINAL_CONTENT_TYPE": "image/pwg-raster"}, True),
        ({"FINAL_CONTENT_TYPE": "application/vnd.lcor-raster"}, False),
    ]:
        result = correct(data, env=env)
        assert result.code == 0 and len(raster.read(result.out)) == 2
        pages = [line for line in result.log.splitlines() if line.startswith("PAGE: ")]
        assert pages == (["PAGE: 1 1", "PAGE: 2 2"] if said else [])


@pytest.mark.parametrize(
    ("page", "why"),
    [
        (Page(ONE_PIXEL, order=PLANAR), "planar order"),
        (Page(ONE_PIXEL, CMYK), "colour space 6"),
        (Page(ONE_PIXEL, words={"cupsBytesPerLine": 6}), "6 bytes a line, but 1 pixels need 3"),
        (Page(ONE_PIXEL, words={"cupsWidth": 2}), "3 bytes a line, but 2 pixels need 6"),
        (Page(ONE_PIXEL, words={"cupsNumColors": 4}), "4 colours"),
        (Page(ONE_PIXEL, words={"cupsBitsPerPixel": 32}), "damaged"),
        (Page(ONE_PIXEL, words={"cupsBitsPerColor": 4}), "4 bits per colour"),
        (
            Page(ONE_PIXEL, words={"cupsWidth": 262145, "cupsBytesPerLine": 786435}),
            "at most 262144 wide",
        ),
        (Page(ONE_PIXEL, words={"cupsHeight": 2}), "within rows 1 to 2 of 2"),
        (Page(ONE_PIXEL, words={"cupsHeight": 4000000000}), "of 4000000000"),
    ],
)
def test_pages_that_lie_or_cannot_be_corrected_are_refused(correct, page, why):
    for options in ("lcor-contrast=5", "lcor-contrast=5 lcor-reading=texel"):
        result = correct(raster.write([page]), options)
        assert result.code == 1
        assert len(result.errors) == 1 and why in result.errors[0], result.log


@pytest.mark.parametrize(
    "words",
    [
        {"cupsWidth": 0, "cupsBytesPerLine": 0},
        {"cupsHeight": 0},
        {"cupsBytesPerLine": 0},
        {"cupsWidth": 0xFFFFFFFF, "cupsBytesPerLine": 0xFFFFFFFD},
    ],
)
def test_empty_and_overflowing_pages_are_refused(correct, words):
    for kind in ("v3", "v2", "pwg"):
        result = correct(raster.write([Page(ONE_PIXEL, words=words)], kind))
        assert result.code == 1 and len(result.errors) == 1, result.log


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"", "is empty"),
        (b"Ra", "no CUPS or PWG raster"),
        (b"%PDF-1.4\n", "no CUPS"),
        (b"UNIRAST\0\0\0\0\1", "Apple raster"),
        (b"3SaR", "no page"),
        (b"3SaR" + bytes(1000), "cut short"),
        (b"3SaR" + bytes(2000), "damaged"),
    ],
)
def test_what_is_no_raster_is_refused(correct, data, why):
    result = correct(data)
    assert (
        result.code == 1
        and result.out == b""
        and len(result.errors) == 1
        and why in result.errors[0]
    )


def test_a_second_page_that_is_damaged_is_no_quiet_end(correct):
    good = raster.write([Page(picture())])
    for rest in (raster.write([Page(ONE_PIXEL, words={"cupsBitsPerPixel": 32})])[4:], bytes(100)):
        result = correct(good + rest)
        assert result.code == 1 and "page 2: its header is damaged" in result.errors[0]


@pytest.mark.parametrize("kind", ["v3", "v2", "pwg"])
def test_a_raster_cut_anywhere_ends_in_one_error(correct, kind):
    data = raster.write([Page(picture(12, 40))], kind)
    for size in (len(data) - 1, len(data) - 700, 1801, 1800):
        result = correct(data[:size])
        assert result.code == 1 and len(result.errors) == 1, (size, result.log)


@pytest.mark.parametrize(
    ("height", "width"), [(1, 1), (100_000, 1), (1, 20_000), (3, 20_000), (700, 4001)]
)
def test_extreme_sizes(correct, tmp_path, height, width):
    pixels = np.full((height, width, 3), 100, np.uint8)
    light = save_pfm(tmp_path / "map.pfm", ramp(5, 7))
    result = correct(
        raster.write([Page(pixels)], "v2"), f"lcor-contrast=23.4 lcor-illuminance={light}"
    )
    assert result.code == 0, result.log
    (out,) = raster.read(result.out)
    assert out.pixels.shape == pixels.shape
    if height * width > 1:
        assert out.pixels.min() < 100 < out.pixels.max()


def test_maps_of_every_kind_and_size_are_resampled_alike(correct, tmp_path):
    pixels = np.full((60, 50, 3), 120, np.uint8)
    ramp_x = np.linspace(0.5, 1.5, 50)
    coarse = np.interp((np.arange(10) + 0.5) * 5 - 0.5, np.arange(50), ramp_x)[None, :].repeat(4, 0)
    full = np.interp(np.clip((np.arange(50) + 0.5) / 5 - 0.5, 0, 9), np.arange(10), coarse[0])[
        None
    ].repeat(60, 0)
    top = 65535 / 1.6
    (tmp_path / "map.pgm").write_bytes(
        b"P5 # comment\n10 4\n65535\n" + np.round(coarse * top).astype(">u2").tobytes()
    )
    (tmp_path / "map8.pgm").write_bytes(
        b"P5\n10 4\n200\n" + np.round(coarse * 125).astype("u1").tobytes()
    )
    outs = []
    for path in (
        save_pfm(tmp_path / "a.pfm", coarse),
        save_pfm(tmp_path / "b.pfm", full),
        tmp_path / "map.pgm",
        tmp_path / "map8.pgm",
    ):
        result = correct(
            raster.write([Page(pixels)]), f"lcor-contrast=23.4 lcor-illuminance={path}"
        )
        assert result.code == 0, result.log
        outs.append(raster.read(result.out)[0].pixels.astype(int))
    assert np.ptp(outs[0]) > 50
    assert all(np.abs(out - outs[0]).max() <= 1 for out in outs)
    assert np.array_equal(outs[0], outs[1])


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (b"PF\n1 1\n-1\n" + bytes(12), "neither a grey PFM"),
        (b"Pf\n1 1\n", "incomplete"),
        (b"Pf\n0 1\n-1\n", "size outside"),
        (b"P5\n2 2\n255\nabc", "cut short"),
        (b"P5\n2 2\n255\nabcde", "cut short or longer"),
        (b"P5\n2 2\n0\nabcd", "largest value"),
        (b"Pf\n1 1\nnan\nabcd", "byte order"),
        (b"P5\n99999 1\n255\n", "size outside"),
    ],
)
def test_broken_maps_are_refused(correct, tmp_path, text, why):
    (tmp_path / "map").write_bytes(text)
    result = correct(
        raster.write([Page(ONE_PIXEL)]), f"lcor-contrast=5 lcor-illuminance={tmp_path / 'map'}"
    )
    assert result.code == 1 and len(result.errors) == 1 and why in result.errors[0], result.log
    assert result.out == b""


def test_light_that_is_no_number_is_black_and_said(correct, tmp_path):
    light = np.ones((4, 4), np.float32)
    light[2, 1] = np.nan
    result = correct(
        raster.write([Page(np.full((4, 4, 3), 99, np.uint8))]),
        f"lcor-contrast=5 lcor-illuminance={save_pfm(tmp_path / 'map.pfm', light)}",
    )
    assert result.code == 0 and "WARNING: page 1" in result.log
    (out,) = raster.read(result.out)
    assert out.pixels[0].min() > 99 and (out.pixels[2, 1] == 0).all()  # a dark spot lowers the mean


def test_the_mean_of_two_passes_can_be_saved_and_given_back(correct, tmp_path):
    data = raster.write([Page(picture(200, 300))])
    two = correct(data, "lcor-contrast=8 lcor-reading=texel")
    (mean,) = mean_said(two)
    stored = picture(200, 300) / 255
    y = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4) @ [
        0.2126729,
        0.7151522,
        0.072175,
    ]
    assert mean == pytest.approx(np.exp(np.log(y).mean()), rel=1e-6)
    (tmp_path / "adaptation").write_text(f"# saved\nsomething else\nr_mean {mean}\n")
    for given in (f"lcor-mean={mean}", f"lcor-adaptation={tmp_path / 'adaptation'}"):
        again = correct(data, f"lcor-contrast=8 lcor-reading=texel {given}")
        assert (
            np.abs(
                raster.read(again.out)[0].pixels.astype(int) - raster.read(two.out)[0].pixels
            ).max()
            <= 1
        )
    assert mean_said(correct(data, "lcor-contrast=8 lcor-reading=texel lcor-mean=literal"))[
        0
    ] == pytest.approx(mean, rel=1e-3)
    assert list(tmp_path.iterdir()) == [
        tmp_path / "adaptation"
    ]  # nothing is left of the spooled page


@pytest.mark.parametrize(
    ("space", "dtype", "order"), [(SRGB, np.uint8, BANDED), (K, np.uint16, raster.CHUNKED)]
)
def test_a_large_page_gives_its_mean_by_a_part_of_its_pixels(
    correct, tmp_path, space, dtype, order
):
    height, width, top = 1024, 2048, np.iinfo(dtype).max
    y, x = np.mgrid[0:height, 0:width]
    grey = np.where(x % 2 == 1, 0.9, 0.2 + 0.6 * y / height)  # a grid hits or misses
    grey[height // 3 : height // 2, width // 2 :] = 0.02
    pixels = np.round(grey[..., None] * [1, 0.8, 0.6] * top)[..., : 3 if space == SRGB else 1]
    light = save_pfm(tmp_path / "map.pfm", ramp(height, width))
    result = correct(
        raster.write([Page(pixels.astype(dtype), space, order)]),
        f"lcor-contrast=8 lcor-reading=texel lcor-illuminance={light}",
    )
    stored = pixels / top if space == SRGB else 1 - pixels / top
    linear = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4)
    luminance = linear @ ([0.2126729, 0.7151522, 0.072175] if space == SRGB else [1])
    logs = np.log(luminance * ramp(height, width))
    mean = logs.mean()
    for _ in range(12):
        mean = np.maximum(logs, mean - np.log(10)).mean()
    # The worst of patterns: r of two neighbours is e^2 about their mean. Five deviations.
    assert mean_said(result)[0] == pytest.approx(np.exp(mean), rel=1e-2)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize(
    ("space", "order"), [(SRGB, raster.CHUNKED), (SRGB, BANDED), (K, raster.CHUNKED)]
)
def test_a_page_that_waits_for_its_mean_comes_back_as_it_was(correct, dtype, space, order):
    pixels = patterns(dtype, 3 if space == SRGB else 1)
    noise = np.random.default_rng(5).integers(0, 256, pixels.shape, np.uint8).astype(dtype)
    for page in (pixels, noise):
        data = raster.write([Page(page, space, order)])
        two = correct(data, "lcor-contrast=8 lcor-reading=texel")
        (mean,) = mean_said(two)
        one = correct(data, f"lcor-contrast=8 lcor-reading=texel lcor-mean={mean}")
        a, b = (raster.read(run.out)[0].pixels.astype(int) for run in (two, one))
        assert two.code == one.code == 0, two.log
        assert np.abs(a - b).max() <= 1 and (a != b).mean() < 1e-3


@pytest.mark.parametrize("options", ["", "lcor-reading=texel", "lcor-reading=texel lcor-passes=1"])
def test_the_bytes_do_not_depend_on_the_number_of_threads(correct, tmp_path, options):
    data = raster.write([Page(picture(1300, 1000))])  # sixteen bands, and more than 2^18 pixels
    light = save_pfm(tmp_path / "map.pfm", ramp(5, 7))
    options += f" lcor-contrast=8 lcor-illuminance={light}"
    one, *more = (correct(data, f"{options} lcor-threads={n}") for n in (1, 2, 3, 8))
    assert one.code == 0 and one.out[-1000:] != data[-1000:]
    assert all(run.out == one.out for run in more)


def test_one_pass_ends_at_the_mean_of_the_page(correct):
    pixels = picture(900, 300)
    pixels[:450] //= 2
    data = raster.write([Page(pixels)])
    options = "lcor-contrast=8 lcor-reading=texel"
    one, two = correct(data, options + " lcor-passes=1"), correct(data, options)
    assert one.code == 0, one.log
    assert mean_said(one) == mean_said(two)
    a, b = (raster.read(r.out)[0].pixels.astype(int) for r in (one, two))
    assert np.array_equal(a[-20:], b[-20:]) and np.abs(a[:100] - b[:100]).max() > 5
    assert correct(data, options + " lcor-passes=1").out == one.out


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ("", "no device profile"),
        ("lcor-contrast=1", "contrast"),
        ("lcor-contrast=nan", "a number"),
        ("lcor-contrast=0x9", "a number"),
        ("lcor-contrast=5 lcor-rho=7", "rho"),
        ("lcor-contrast=5 lcor-exponent=-1", "exponent"),
        ("lcor-contrats=5", "unknown option"),
        ("lcor-contrast=5 lcor-threads=9", "choose 1 to 8"),
        ("lcor-contrast=5 lcor-reading=both", "choose one of patch, texel"),
        ("lcor-contrast=5 lcor-mean=some", "adaptive, literal or a number"),
        ("lcor-profile=/nowhere/profile", "No such file"),
        ("lcor-profile=/dev/zero", "regular file"),
        ("lcor-contrast=5 lcor-adaptation=/etc/hostname", "no line"),
    ],
)
def test_bad_options_are_refused_before_anything_is_written(correct, options, why):
    result = correct(raster.write([Page(ONE_PIXEL)]), options)
    assert (
        result.code == 1
        and result.out == b""
        and len(result.errors) == 1
        and why in result.errors[0]
    ), result.log


PROFILE = """CGATS.17
NUMBER_OF_FIELDS 5
BEGIN_DATA_FORMAT
SAMPLE_ID RGB_R RGB_G RGB_B D_VIS
END_DATA_FORMAT
NUMBER_OF_SETS 2
BEGIN_DATA
1 255 255 255 0.05
2 0 0 0 1.45
END_DATA
"""


def test_the_profile_gives_the_contrast_and_jobs_name_it_within_one_folder(correct, tmp_path):
    data = raster.write([Page(picture())])
    (tmp_path / "lcor").mkdir()
    (tmp_path / "lcor" / "print.cgats").write_text(PROFILE)
    by_number = correct(data, f"lcor-contrast={10**1.4:.12g} lcor-reading=texel")
    by_path = correct(data, f"lcor-profile={tmp_path}/lcor/print.cgats lcor-reading=texel")
    assert by_path.code == 0 and by_path.out == by_number.out
    cups = {"CUPS_SERVERROOT": str(tmp_path)}
    assert correct(data, "lcor-profile=print.cgats lcor-reading=texel", cups).out == by_number.out
    for path in (f"{tmp_path}/lcor/print.cgats", "../lcor/print.cgats"):
        outside = correct(data, f"lcor-profile={path}", cups)
        assert outside.code == 1 and "without a folder" in outside.errors[0]
    (tmp_path / "lcor" / "bad").write_text("CGATS.17\n")
    assert "lcor-profile" in correct(data, "lcor-profile=bad", cups).errors[0]


def test_a_job_in_a_comma_locale_gives_the_same_bytes(correct):
    data = raster.write([Page(picture())])
    options = "lcor-contrast=8.5 lcor-reading=texel"
    assert (
        correct(data, options, {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"}).out
        == correct(data, options).out
    )


def test_switched_off_it_copies(correct):
    data = raster.write([Page(picture()), Page(picture(3, 5), CMYK)][:1])
    assert correct(data, "lcor-correction=off").out == data


def spools(process):
    """The spooled pages that a running filter has open."""
    found = []
    for entry in Path(f"/proc/{process.pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed in the meantime
            found += [name] if "rastertolcor" in (name := os.readlink(entry)) else []
    return found


def test_sigterm_ends_it_and_leaves_nothing(tmp_path):
    data = raster.write([Page(np.full((4000, 1000, 3), 90, np.uint8))])
    process = subprocess.Popen(
        [FILTER, "1", "u", "t", "1", "lcor-contrast=5 lcor-reading=texel"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"TMPDIR": str(tmp_path)},
    )
    process.stdin.write(data[:6_000_000])  # half a page: the filter waits for the rest
    process.stdin.flush()
    for _ in range(24000):  # until the spool file is open and has no name any more
        if len(spools(process)) == 1 and not any(tmp_path.iterdir()):
            break
        assert process.poll() is None
        time.sleep(0.005)
    else:
        pytest.fail("no spooled page that would vanish with the filter")
    process.send_signal(signal.SIGTERM)
    _, log = process.communicate(timeout=120)
    assert process.returncode == 0 and b"INFO: cancelled" in log and b"PAGE" not in log
    assert list(tmp_path.iterdir()) == []


def test_a_reader_that_goes_away_is_an_error_not_a_crash():
    data = raster.write([Page(np.full((2000, 1000, 3), 90, np.uint8))])
    process = subprocess.Popen(
        [FILTER, "1", "u", "t", "1", "lcor-contrast=5"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.close()
    process.stdout = None
    _, log = process.communicate(data, timeout=120)
    assert (
        process.returncode == 1
        and b"ERROR: page 1: the output cannot be written: Broken pipe" in log
    )


def test_memory_does_not_grow_with_the_page(tmp_path):
    if b"__asan_init" in FILTER.read_bytes():
        pytest.skip("sanitizers have memory of their own")
    peaks = []
    light = save_pfm(tmp_path / "map.pfm", ramp(300, 200))
    for height in (300, 1200):
        process = subprocess.Popen(
            [FILTER, "1", "u", "t", "1", f"lcor-contrast=5 lcor-illuminance={light}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        process.stdin.write(raster.write([Page(np.full((height, 4960, 3), 90, np.uint8))]))
        process.stdin.flush()
        while not process.stderr.readline().startswith(
            b"PAGE: "
        ):  # the page is done, the job is not
            assert process.poll() is None
        (peak,) = re.findall(r"VmHWM:\s+(\d+)", Path(f"/proc/{process.pid}/status").read_text())
        peaks.append(int(peak) / 1024)
        process.communicate(timeout=120)
        assert process.returncode == 0
    assert peaks[1] < 16 and peaks[1] < peaks[0] + 1, peaks  # MiB


def test_help_and_version():
    for option in ("--help", "--version"):
        done = subprocess.run([FILTER, option], capture_output=True, check=True)
        assert b"lcor" in done.stdout and done.stderr == b""
    assert subprocess.run([FILTER, "1"], capture_output=True, check=False).returncode == 1
