# SPDX-License-Identifier: MIT
import math
import pickle

import lcor
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st


def test_contrast_agrees_with_the_table(golden):
    for row in golden("density_contrast"):
        d_max, d_min, c = row.values()
        if d_max > d_min:
            assert lcor.contrast_from_density(d_max, d_min) == pytest.approx(c, rel=1e-13)
        else:
            with pytest.raises(ValueError, match="density"):
                lcor.contrast_from_density(d_max, d_min)


def test_curve_agrees_with_the_table(golden):
    for row in golden("eq8_adapt"):
        scene = (row["Jbar"], row["Jmin"], row["Jmax"], row["t"])
        assert lcor.adapt(row["J"], *scene) == pytest.approx(row["H"], rel=1e-12)
        assert lcor.adapt_range(*scene) == pytest.approx((row["J1"], row["J2"]), rel=1e-12)


def test_curve_takes_arrays_of_any_strides(random):
    j = random.random((6, 8)).astype(np.float32)[::2, ::-3]
    h = lcor.adapt(j, 0.5, 1.0, 23.4)
    assert h.dtype == np.float32 and h.shape == j.shape
    expected = [[lcor.adapt(float(x), 0.5, 1.0, 23.4) for x in row] for row in j]
    np.testing.assert_allclose(h, expected, rtol=1e-6)
    back = lcor.adapt_inverse(lcor.adapt(0.3, 0.5, 1.0, 23.4, 0.7), 0.5, 1.0, 23.4, 0.7)
    assert back == pytest.approx(0.3, rel=1e-13)


def test_curve_refuses_what_lies_outside_the_model():
    for j, mean, low, high in [
        (-1.0, 1, 1, 2),
        (1.0, 0, 1, 2),
        (1.0, 1, 2, 1),
        (math.nan, 1, 1, 2),
    ]:
        with pytest.raises(ValueError):
            lcor.adapt(j, mean, low, high)


def test_means_agree_with_the_table(golden):
    for row in golden("geomean"):
        values = [float(v) for v in str(row["values"]).split()]
        literal, adaptive = row["literal_floor1e-8"], row["adaptive10"]
        assert lcor.geometric_mean(values, method="literal") == pytest.approx(literal, rel=1e-12)
        assert lcor.geometric_mean(values) == pytest.approx(adaptive, rel=1e-12)


def test_weights_broadcast(random):
    r = random.random((3, 4)) + 0.1
    weights = np.array([1.0, 2.0, 0.0, 3.0])
    repeated = np.repeat(r, [1, 2, 0, 3], axis=1)
    expected = lcor.geometric_mean(repeated)
    assert lcor.geometric_mean(r, weights) == pytest.approx(expected, rel=1e-13)
    with pytest.raises(ValueError, match="do not fit r"):
        lcor.geometric_mean(r, np.ones(3))


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(0, 1e6), min_size=1, max_size=60),
    st.lists(st.integers(0, 60), max_size=4),
    st.sampled_from(["adaptive", "literal"]),
)
def test_mean_has_the_same_bits_however_it_is_split(values, cuts, method):
    whole = lcor.Mean().add(np.array(values))
    parts = np.split(np.array(values), sorted(c for c in cuts if c < len(values)))
    merged = lcor.Mean()
    for part in reversed(parts):
        merged.merge(pickle.loads(pickle.dumps(lcor.Mean().add(part))))
    assert merged.get(method) == whole.get(method)
    assert merged.error(method) == whole.error(method)


def test_refining_reaches_the_exact_mean(random):
    r = random.random(5000) ** 6
    mean = lcor.Mean().add(r)
    for _ in range(10):
        if mean.error() == 0:
            break
        mean.refine().add(r)
    assert mean.get() == pytest.approx(lcor.geometric_mean(r), rel=1e-12)
    assert lcor.Mean().add(r).get() == pytest.approx(mean.get(), rel=0.02)


def test_nothing_added_is_an_error():
    for call in (
        lambda: lcor.geometric_mean([]),
        lambda: lcor.Mean().get(),
        lambda: lcor.geometric_mean([math.nan]),
    ):
        with pytest.raises(ValueError):
            call()
    with pytest.raises(ValueError, match='method must be "adaptive" or "literal"'):
        lcor.geometric_mean([1.0], method="arithmetic")
