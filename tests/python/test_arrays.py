# SPDX-License-Identifier: MIT
"""What arrays may be: types, strides, out=, broadcasting, refusals. No copies where promised."""

import threading
import tracemalloc

import lcor
import numpy as np
import pytest

TYPES = [np.float32, np.float64, np.uint8, np.uint16]
PLAN = lcor.Plan(23.4, 0.3, 0.5)


def stored(values, dtype):
    """0..1 as samples of a type."""
    if np.issubdtype(dtype, np.integer):
        return np.round(values * np.iinfo(dtype).max).astype(dtype)
    return values.astype(dtype)


@pytest.fixture
def picture(random):
    return random.random((6, 8, 3))


@pytest.fixture
def light(random):
    return random.random((6, 8)) + 0.05


def layouts(rgb):
    """The same pixels in every kind of memory."""
    height, width, _ = rgb.shape
    yield "fortran", np.asfortranarray(rgb)
    yield "planar", np.ascontiguousarray(rgb.transpose(2, 0, 1)).transpose(1, 2, 0)
    yield "banded", np.ascontiguousarray(rgb.transpose(0, 2, 1)).transpose(0, 2, 1)
    rgba = np.zeros((height, width, 4), rgb.dtype)
    rgba[..., :3] = rgb
    yield "rgba", rgba[..., :3]
    bgr = np.ascontiguousarray(rgb[..., ::-1])
    yield "bgr", bgr[..., ::-1]
    yield "mirrored", np.ascontiguousarray(rgb[:, ::-1])[:, ::-1]
    yield "upside down", np.ascontiguousarray(rgb[::-1])[::-1]
    yield "transposed", np.ascontiguousarray(rgb.transpose(1, 0, 2)).transpose(1, 0, 2)
    spread = np.zeros((height * 2, width * 3, 3), rgb.dtype)
    spread[::2, ::3] = rgb
    yield "every third", spread[::2, ::3]
    raw = np.zeros(rgb.nbytes + 1, np.uint8)[1:].view(rgb.dtype).reshape(rgb.shape)
    raw[...] = rgb
    yield "unaligned", raw
    frozen = rgb.copy()
    frozen.flags.writeable = False
    yield "read-only", frozen


@pytest.mark.parametrize("dtype", TYPES)
def test_every_layout_gives_the_same_bytes(picture, light, dtype):
    rgb = stored(picture, dtype)
    expected, stats = PLAN.apply(rgb, light)
    assert expected.dtype == dtype and expected.flags.c_contiguous
    for name, view in layouts(rgb):
        out, view_stats = PLAN.apply(view, light)
        np.testing.assert_array_equal(out, expected, err_msg=name)
        assert view_stats == stats
        np.testing.assert_array_equal(view, rgb, err_msg=f"{name} was changed")


@pytest.mark.parametrize("dtype", TYPES)
def test_out_may_have_every_layout(picture, light, dtype):
    rgb = stored(picture, dtype)
    expected = PLAN.apply(rgb, light)[0]
    for name, view in layouts(np.zeros_like(rgb)):
        if view.flags.writeable:
            out, _ = PLAN.apply(rgb, light, out=view)
            assert out is view
            np.testing.assert_array_equal(view, expected, err_msg=name)


@pytest.mark.parametrize("dtype", TYPES)
def test_in_place(picture, light, dtype):
    rgb = stored(picture, dtype)
    expected = PLAN.apply(rgb, light)[0]
    for name, view in layouts(rgb):
        if view.flags.writeable:
            PLAN.apply(view, light, out=view)
            np.testing.assert_array_equal(view, expected, err_msg=name)


def test_samples_beside_a_view_stay(picture, light):
    rgba = np.full((6, 8, 4), 0.25, np.float32)
    rgba[..., :3] = picture
    PLAN.apply(rgba[..., :3], light, out=rgba[..., :3])
    assert (rgba[..., 3] == 0.25).all()


def test_out_of_another_type(picture, light):
    eight = PLAN.apply(picture, light, out=np.empty((6, 8, 3), np.uint8))[0]
    np.testing.assert_allclose(eight / 255, PLAN.apply(picture, light)[0], atol=0.51 / 255)


def test_maps_of_every_layout_and_both_types(picture, light):
    expected = PLAN.apply(picture, light, light)[0]
    for view in (np.asfortranarray(light), np.repeat(light, 2, axis=1)[:, ::2], light[::-1][::-1]):
        np.testing.assert_array_equal(PLAN.apply(picture, view, view)[0], expected)
    single = light.astype(np.float32)
    np.testing.assert_array_equal(
        PLAN.apply(picture, single, single)[0], PLAN.apply(picture, single, single.astype(float))[0]
    )


def test_numbers_rows_and_maps_broadcast(picture, light):
    row, column = light[0], light[:, :1]
    for small in (0.7, 1, np.float32(0.5), np.array(0.7), row, column, [0.7] * 8):
        full = np.broadcast_to(np.asarray(small, np.float64), (6, 8))
        np.testing.assert_allclose(
            PLAN.apply(picture, small)[0], PLAN.apply(picture, full)[0], atol=1e-12
        )
    sweep = PLAN.apply([0.9, 0.2, 0.6], light)[0]
    assert sweep.shape == (6, 8, 3)
    np.testing.assert_array_equal(sweep[2, 3], PLAN.apply([0.9, 0.2, 0.6], light[2, 3])[0])
    frames = np.stack([picture, picture / 2])
    np.testing.assert_array_equal(
        PLAN.apply(frames, light)[0][1], PLAN.apply(picture / 2, light)[0]
    )


@pytest.mark.parametrize("shape", [(0, 3), (4, 0, 3), (0, 5, 3)])
def test_empty_pictures(shape):
    out, stats = PLAN.apply(np.zeros(shape), 1.0)
    assert out.shape == shape and stats.pixels == 0


@pytest.mark.parametrize(
    "dtype, fix",
    [
        (np.int64, r"rgb\.astype\(numpy\.uint8\)"),
        (np.int8, r"rgb\.astype\(numpy\.uint8\)"),
        (np.uint32, r"rgb / 4095"),
        (np.float16, r"rgb\.astype\(numpy\.float32\)"),
        (np.longdouble, r"rgb\.astype\(numpy\.float32\)"),
        (">f4", r"byte order: .*rgb\.astype\(rgb\.dtype\.newbyteorder\('='\)\)"),
        (">u2", r"byte order: .*rgb\.astype\(rgb\.dtype\.newbyteorder\('='\)\)"),
        (">i4", r"rgb / 4095"),
        (bool, "pass float32, float64"),
        (complex, "pass float32, float64"),
        (object, "pass float32, float64"),
        ("M8[s]", "pass float32, float64"),
    ],
)
def test_unknown_types_are_refused_with_the_fix(dtype, fix):
    rgb = np.zeros((2, 3)).astype(dtype)
    with pytest.raises(TypeError, match=f"rgb has samples of type .*{fix}"):
        PLAN.apply(rgb, 1.0)


def test_other_byte_orders_are_fixed_as_the_text_says(picture, light):
    foreign = picture.astype(">f8")
    fixed = foreign.astype(foreign.dtype.newbyteorder("="))
    np.testing.assert_array_equal(PLAN.apply(fixed, light)[0], PLAN.apply(picture, light)[0])


@pytest.mark.parametrize("dtype", [bool, np.int64, np.uint8, np.float16])
def test_values_of_other_types_are_refused_with_the_fix(dtype):
    with pytest.raises(TypeError, match=r"j\.astype\(numpy\.float32\)"):
        lcor.adapt(np.ones(2, dtype), 1.0, 1.0, 23.4)


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda: lcor.rgb_to_lab(None), "rgb"),
        (lambda: lcor.lab_to_rgb(None), "lab"),
        (lambda: lcor.hue(None), "lab"),
        (lambda: lcor.adapt(None, 1, 1, 2), "j"),
        (lambda: lcor.adapt_inverse(None, 1, 1, 2), "h"),
        (lambda: lcor.geometric_mean(None), "r"),
        (lambda: PLAN.apply(None, 1.0), "rgb"),
        (lambda: PLAN.apply([0.5] * 3, None), "illuminance"),
    ],
)
def test_nothing_is_refused_by_name(call, name):
    with pytest.raises(TypeError, match=f"^{name} is None"):
        call()


def test_a_channel_axis_left_on_a_map_is_refused(picture):
    square = picture[:, :6]
    with pytest.raises(ValueError, match=r"shape \(6, 6, 1\) .*illuminance\[\.\.\., 0\]"):
        PLAN.apply(square, np.ones((6, 6, 1)))
    with pytest.raises(ValueError, match=r"pass rho\[\.\.\., 0\]"):
        PLAN.apply(picture, 1.0, np.ones((6, 8, 1)))
    outer = PLAN.apply(picture[0], np.linspace(0.1, 1, 8)[:, None])[0]  # each colour in each light
    assert outer.shape == (8, 8, 3)
    assert PLAN.apply(square, np.ones((2, 1, 1)))[0].shape == (2, 6, 6, 3)


def test_integers_in_lists_are_refused_with_the_fix():
    with pytest.raises(TypeError, match=r"int64, whose scale is not known"):
        PLAN.apply([250, 50, 150], 1.0)


def test_integer_maps_are_refused_with_the_fix(picture):
    with pytest.raises(TypeError, match=r"illuminance\.astype\(numpy\.float32\)"):
        PLAN.apply(picture, np.ones((6, 8), np.uint16))


@pytest.mark.parametrize(
    "call, error, text",
    [
        (lambda p: PLAN.apply(p[..., 0], 1.0), ValueError, "must hold 3 channels"),
        (lambda p: PLAN.apply(p, np.ones((5, 8))), ValueError, r"illuminance of shape \(5, 8\)"),
        (lambda p: PLAN.apply(p, 1.0, np.ones(5)), ValueError, r"rho of shape \(5,\)"),
        (lambda p: PLAN.apply(p, 1.0, out=[0.0]), TypeError, "out must be a numpy array"),
        (lambda p: PLAN.apply(p, 1.0, out=p[:2]), ValueError, r"out has shape \(2, 8, 3\)"),
        (lambda p: PLAN.apply(p, 1.0, out=np.zeros((6, 8, 3), int)), TypeError, "out has samples"),
        (lambda p: PLAN.apply(p, 1.0, out=p[:, ::-1]), ValueError, "out shares memory with rgb"),
        (lambda p: PLAN.apply(p[1:], 1.0, out=p[:-1]), ValueError, "out shares memory with rgb"),
        (lambda p: PLAN.apply(np.zeros(3), 1.0, out=p), ValueError, "the result has"),
        (lambda p: PLAN.apply(p, p[..., 0], out=p), ValueError, "out shares memory with illum"),
    ],
)
def test_wrong_arrays_are_refused(picture, call, error, text):
    before = picture.copy()
    with pytest.raises(error, match=text):
        call(picture)
    np.testing.assert_array_equal(picture, before)


def test_read_only_out_is_refused(picture):
    out = np.zeros_like(picture)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="out cannot be written"):
        PLAN.apply(picture, 1.0, out=out)


@pytest.mark.parametrize("dtype", TYPES)
def test_nothing_is_copied(dtype):
    rgb = np.zeros((512, 512, 3), dtype)
    light = np.ones((512, 512), np.float32)
    out = np.empty_like(rgb)
    PLAN.apply(rgb, light, out=out)
    tracemalloc.start()
    PLAN.apply(rgb, light, out=out)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8192


def test_other_threads_run_meanwhile():
    rgb = np.random.default_rng(0).random((600, 1000, 3))
    running, seen = threading.Event(), []

    def count():
        while not running.is_set():
            seen.append(1)

    thread = threading.Thread(target=count)
    thread.start()
    before = len(seen)
    lcor.correct(rgb, 1.0, contrast=23.4)
    after = len(seen)
    running.set()
    thread.join()
    assert after > before


def test_buffers_without_numpy(picture):
    import array

    light = array.array("d", [0.5, 1.0])
    np.testing.assert_array_equal(
        PLAN.apply(picture[:1, :2], light)[0], PLAN.apply(picture[:1, :2], [0.5, 1.0])[0]
    )
