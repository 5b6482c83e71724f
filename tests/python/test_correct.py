# SPDX-License-Identifier: MIT
import copy
import math
import pickle
import threading

import lcor
import numpy as np
import pytest
from conftest import columns


def image(table, *names):
    return columns(table, " ".join(names)).reshape(16, 16, -1).squeeze()


@pytest.mark.parametrize("index", range(8))
def test_images_agree_with_the_fifty_digit_tables(golden, index):
    scalars = golden("image_scalars")[index]
    table = golden(f"image_{scalars['scene']}_{scalars['reading']}")
    rgb, light = image(table, "R", "G", "B"), image(table, "I")
    rho, reading = scalars["rho_mean"], {"A": "patch", "B": "texel"}[scalars["reading"]]
    method = {"literal_floor1e-8": "literal", "adaptive10": "adaptive"}[scalars["mean"]]

    mean = lcor.picture_mean(rgb, light, rho, reading=reading, method=method)
    assert mean == pytest.approx(scalars["rbar"] * scalars["Imax"], rel=1e-12)
    plan = lcor.Plan(scalars["c"], scalars["rbar"] * scalars["Imax"], rho, reading)
    out, stats = plan.apply(rgb, light)
    np.testing.assert_allclose(out, image(table, "Rfin", "Gfin", "Bfin"), rtol=0, atol=1e-13)
    assert stats.pixels == 256 and stats.non_finite == 0
    plain = lcor.conventional(rgb, light, rho)
    np.testing.assert_allclose(plain, image(table, "Reqn19", "Geqn19", "Beqn19"), atol=1e-13)


@pytest.mark.parametrize("lightness", ["cie", "paper"])
def test_pixels_agree_with_the_fifty_digit_tables(golden, lightness):
    for row in golden(f"pixel_{lightness}"):
        plan = lcor.Plan(
            row["c"],
            row["rbar"],
            reading={"A": "patch", "B": "texel"}[row["reading"]],
            lightness=lightness,
        )
        out, _ = plan.apply([row["R"], row["G"], row["B"]], row["alpha"], row["rho"])
        np.testing.assert_allclose(out, [row["Rfin"], row["Gfin"], row["Bfin"]], atol=1e-12)


def test_correct_is_both_passes(random):
    texture, light = random.random((5, 4, 3)), random.random((5, 4)) * 10
    mean = lcor.picture_mean(texture, light, 0.3)
    plan = lcor.Plan(23.4, mean, 0.3)
    np.testing.assert_array_equal(
        lcor.correct(texture, light, contrast=23.4, rho=0.3), plan.apply(texture, light)[0]
    )
    assert mean == pytest.approx(lcor.geometric_mean(light * 0.3), rel=1e-13)
    half = lcor.correct(texture, light, contrast=23.4, rho=0.3, r_mean=mean / 2)
    np.testing.assert_array_equal(half, lcor.Plan(23.4, mean / 2, 0.3).apply(texture, light)[0])


def test_the_unit_of_illuminance_does_not_matter(random):
    texture, light = random.random((5, 4, 3)), random.random((5, 4))
    one = lcor.correct(texture, light, contrast=23.4)
    lux = lcor.correct(texture, light * 1024, contrast=23.4)
    np.testing.assert_allclose(lux, one, atol=1e-12)


def test_rho_map_equals_rho_number(random):
    texture, light = random.random((5, 4, 3)), random.random((5, 4)) + 0.1
    number = lcor.correct(texture, light, contrast=23.4, rho=0.25)
    for rho in (np.full((5, 4), 0.25), np.full((4,), 0.25), np.full((5, 1), 0.25, np.float32)):
        np.testing.assert_allclose(
            lcor.correct(texture, light, contrast=23.4, rho=rho), number, atol=1e-12
        )


def test_weights_mask_pixels_out_of_the_mean(random):
    texture, light = random.random((4, 6, 3)), random.random((4, 6)) + 0.1
    weights = np.zeros((4, 6))
    weights[:, :3] = 1
    assert lcor.picture_mean(texture, light, weights=weights) == lcor.picture_mean(
        texture[:, :3], light[:, :3]
    )


def test_stats_say_what_happened_and_where():
    rgb = np.full((3, 4, 3), 0.5)
    light = np.ones((3, 4))
    light[1, 2], light[2, 0], light[0, 0], light[0, 1] = math.nan, -1.0, 1e-9, 1e9
    out, stats = lcor.Plan(23.4, 0.5).apply(rgb, light)
    assert stats.pixels == 12 and stats.non_finite == 2 and stats.first_bad == (1, 2)
    assert stats.clipped_low >= 1 and stats.clipped_high == 1
    assert (out[1, 2] == 0).all() and (out[2, 0] == 0).all()
    np.testing.assert_allclose(out[0, 1], 1, atol=1e-12)
    out, stats = lcor.Plan(23.4, 0.5).apply([0.5, math.nan, 0.5], 1.0)
    assert stats.first_bad == () and (out == 0).all()
    assert lcor.Plan(23.4, 0.5).apply(rgb, 1.0)[1].first_bad is None


@pytest.mark.parametrize(
    "options, text",
    [
        ({"contrast": 1.0}, "contrast"),
        ({"contrast": math.nan}, "contrast"),
        ({"r_mean": -1.0}, "r_mean"),
        ({"rho": 0.0}, "rho"),
        ({"rho": 1.5}, "rho"),
        ({"exponent": -1.0}, "exponent"),
        ({"exponent": 0}, "exponent"),
        ({"reading": "pixel"}, 'reading must be "patch" or "texel"'),
        ({"gamut": "keep"}, 'gamut must be "keep-hue" or "clip"'),
        ({"tone_curve": [1.0, 0.0]}, "tone"),
        ({"tone_curve": [[0.0, 1.0]]}, "one dimension"),
    ],
)
def test_plans_refuse_what_lies_outside_the_model(options, text):
    with pytest.raises(ValueError, match=text):
        lcor.Plan(**{"contrast": 23.4, "r_mean": 0.5, **options})


@pytest.mark.parametrize("name", ["contrast", "r_mean", "rho", "exponent", "rho_ratio"])
@pytest.mark.parametrize("value", [None, "0.5", [0.5], np.full((2, 2), 0.5)], ids=str)
def test_plans_take_numbers(name, value):
    with pytest.raises(TypeError, match=f"{name} must be a number"):
        lcor.Plan(**{"contrast": 23.4, "r_mean": 0.5, name: value})


def test_numbers_of_numpy_are_numbers():
    plan = lcor.Plan(np.float32(24.0), np.array(0.5), np.float64(0.25), transfer=np.float32(2.0))
    same = lcor.Plan(24, 0.5, 0.25, transfer=2)
    colour, light = [0.5, 0.25, 0.125], [0.5, 1.0]
    np.testing.assert_array_equal(plan.apply(colour, light)[0], same.apply(colour, light)[0])


def test_eq_19_takes_any_reflectance():
    colour, light = [0.5, 0.25, 0.125], [0.5, 2.0]
    assert (lcor.conventional(colour, light, 0.0) == 0).all()
    np.testing.assert_array_equal(
        lcor.conventional(colour, light, 0.5), lcor.conventional(colour, light, np.full(2, 0.5))
    )


def test_infinite_contrast_is_a_device_with_perfect_black():
    out, _ = lcor.Plan(math.inf, 0.5).apply([0.5, 0.5, 0.5], 1.0)
    np.testing.assert_allclose(out, 0.5, atol=1e-12)


def test_tone_curve_replaces_the_transfer_function():
    plan = lcor.Plan(23.4, 0.5, tone_curve=[0.0, 0.2, 1.0])
    out, _ = plan.apply([0.5, 0.5, 0.5], 1.0)
    np.testing.assert_allclose(out, 0.2, atol=1e-6)


def test_plans_travel(random):
    plan = lcor.Plan(23.4, 0.5, space="srgb", transfer="srgb", tone_curve=[0.0, 0.4, 1.0])
    rgb, light = random.random((4, 3)), random.random(4)
    np.testing.assert_array_equal(
        pickle.loads(pickle.dumps(plan)).apply(rgb, light)[0], plan.apply(rgb, light)[0]
    )
    assert "contrast=23.4" in repr(plan)


def test_plans_are_copied_with_their_kind_and_cannot_change():
    class Own(lcor.Plan):
        """A user's."""

    for plan in (copy.copy(Own(23.4, 0.5)), copy.deepcopy(Own(23.4, 0.5))):
        assert type(plan) is Own and plan.options["r_mean"] == 0.5
    with pytest.raises(AttributeError):
        lcor.Plan(23.4, 0.5).contrast = 10.0


def test_threads_share_a_plan_and_the_bytes_stay(random):
    rgb, light = random.random((64, 50, 3)).astype(np.float32), random.random((64, 50))
    plan = lcor.Plan(23.4, 0.25)
    expected = plan.apply(rgb, light)[0]
    out = np.empty_like(expected)
    threads = [
        threading.Thread(target=plan.apply, args=(rgb[s], light[s]), kwargs={"out": out[s]})
        for s in (slice(i, i + 8) for i in range(0, 64, 8))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    np.testing.assert_array_equal(out, expected)
