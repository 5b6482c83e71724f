# SPDX-License-Identifier: MIT
import lcor
import numpy as np
import pytest
from conftest import columns


@pytest.mark.parametrize("lightness", ["cie", "paper"])
def test_lab_agrees_with_the_fifty_digit_tables(golden, lightness):
    table = golden(f"rgb_to_lab_{lightness}")
    lab = lcor.rgb_to_lab(columns(table, "R G B"), lightness=lightness)
    np.testing.assert_allclose(lab, columns(table, "L a b"), rtol=0, atol=1e-10)
    back = golden(f"lab_to_rgb_{lightness}")
    rgb = lcor.lab_to_rgb(columns(back, "L a b"), lightness=lightness)
    expected = columns(back, "R G B")
    np.testing.assert_allclose(rgb, expected, rtol=1e-13, atol=1e-13)


def test_hue_and_chroma_agree_with_the_tables(golden):
    table = golden("rgb_to_lab_cie")
    lab = columns(table, "L a b")
    np.testing.assert_allclose(lcor.chroma(lab), columns(table, "chroma")[:, 0], rtol=1e-13)
    coloured = columns(table, "chroma")[:, 0] > 1e-3
    np.testing.assert_allclose(
        np.degrees(lcor.hue(lab))[coloured], columns(table, "hue_deg")[coloured, 0], atol=1e-9
    )


@pytest.mark.parametrize(
    "space", ["ntsc", "srgb", [[0.5, 0.3, 0.2], [0.3, 0.6, 0.1], [0, 0.1, 1.0]]]
)
@pytest.mark.parametrize("transfer", ["linear", "srgb", 2.2])
def test_there_and_back(random, space, transfer):
    rgb = random.random((5, 7, 3))
    lab = lcor.rgb_to_lab(rgb, space, transfer=transfer)
    np.testing.assert_allclose(
        lcor.lab_to_rgb(lab, space, transfer=transfer), rgb, rtol=0, atol=1e-12
    )
    white = lcor.rgb_to_lab([1.0, 1.0, 1.0], space, transfer=transfer)
    np.testing.assert_allclose(white, [100, 0, 0], atol=1e-10)


def test_float_types_are_kept_and_integers_become_float32(random):
    rgb = random.random((4, 3))
    assert lcor.rgb_to_lab(rgb).dtype == np.float64
    assert lcor.rgb_to_lab(rgb.astype(np.float32)).dtype == np.float32
    assert lcor.lab_to_rgb(np.float32([[50, 10, 10]])).dtype == np.float32
    for dtype in (np.uint8, np.uint16):
        top = np.iinfo(dtype).max
        stored = (rgb * top).astype(dtype)
        lab = lcor.rgb_to_lab(stored)
        assert lab.dtype == np.float32
        np.testing.assert_allclose(lab, lcor.rgb_to_lab(stored / top), atol=2e-4)


def test_writes_into_out_and_in_place(random):
    rgb = random.random((4, 3))
    expected = lcor.rgb_to_lab(rgb)
    out = np.empty((4, 6))[:, ::2]
    assert lcor.rgb_to_lab(rgb, out=out) is out
    np.testing.assert_array_equal(out, expected)
    assert lcor.rgb_to_lab(rgb, out=rgb) is rgb
    np.testing.assert_array_equal(rgb, expected)


def test_numbers_in_lists_are_the_same_as_arrays():
    for colour in ([0.1, 0.2, 0.3], (0.1, 0.2, 0.3), [[0.1, 0.2, 0.3]] * 2):
        np.testing.assert_array_equal(lcor.rgb_to_lab(colour), lcor.rgb_to_lab(np.array(colour)))
    assert lcor.hue((50, 1, 1)) == pytest.approx(np.pi / 4)


@pytest.mark.parametrize(
    "call, text",
    [
        (lambda: lcor.rgb_to_lab([0.1, 0.2, 0.3], "rgb"), 'space must be "ntsc" or "srgb"'),
        (lambda: lcor.rgb_to_lab([0.1, 0.2, 0.3], transfer="log"), 'transfer must be "linear" or'),
        (lambda: lcor.rgb_to_lab([0.1, 0.2, 0.3], lightness="x"), 'lightness must be "cie" or'),
        (lambda: lcor.rgb_to_lab([0.1, 0.2, 0.3], transfer=-1), "gamma"),
        (lambda: lcor.rgb_to_lab([0.1, 0.2, 0.3], np.eye(2)), r"space has shape \(2, 2\)"),
        (lambda: lcor.rgb_to_lab([0.1, 0.2, 0.3], np.zeros((3, 3))), "matrix"),
        (lambda: lcor.rgb_to_lab(np.zeros((4, 4))), r"pass rgb\[..., :3\]"),
        (lambda: lcor.rgb_to_lab(0.5), r"rgb has shape \(\)"),
    ],
)
def test_refusals_say_what_and_how(call, text):
    with pytest.raises(ValueError, match=text):
        call()
