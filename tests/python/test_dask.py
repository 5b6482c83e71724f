# SPDX-License-Identifier: MIT
"""Chunks, trees and machines do not change a byte."""

import lcor
import numpy as np
import pytest

da = pytest.importorskip("dask.array", reason="dask is not installed (pip install lcor[dask])")
distributed = pytest.importorskip("distributed", reason="distributed is not installed")
import lcor.dask  # noqa: E402

CHUNKS = [(24, 32), (1, 32), (24, 3), (5, 11), (13, 32), (9, 9), ((2, 3, 19), (1, 25, 6))]


@pytest.fixture(scope="module")
def client():
    """Two workers of one thread each, processes of their own."""
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        client.wait_for_workers(2, timeout=240)
        yield client


@pytest.fixture(scope="module")
def picture():
    random = np.random.default_rng(3)
    return {
        "texture": random.random((24, 32, 3)).astype(np.float32),
        "illuminance": random.random((24, 32)).astype(np.float32) ** 4,
        "rho": random.random((24, 32)) * 0.8 + 0.1,
    }


@pytest.mark.parametrize(
    "chunks, options",
    [(chunks, {}) for chunks in CHUNKS] + [((5, 11), {"reading": "texel", "method": "literal"})],
    ids=str,
)
def test_every_chunking_has_the_bytes_of_the_single_call(client, picture, chunks, options):
    texture, light, rho = picture["texture"], picture["illuminance"], picture["rho"]
    expected = lcor.correct(texture, light, 23.4, rho=rho, **options)
    chunked = da.from_array(texture, chunks=(*chunks, 3))
    got = lcor.dask.correct(chunked, da.from_array(light, chunks=10), 23.4, rho=rho, **options)
    assert got.compute().tobytes() == expected.tobytes()


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint8, np.uint16])
def test_types_are_kept(picture, dtype):
    scale = np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1
    texture = (picture["texture"] * scale).astype(dtype)
    got = lcor.dask.correct(da.from_array(texture, chunks=(9, 9, 1)), 1.0, 23.4, rho=0.4)
    assert got.dtype == dtype
    assert got.compute().tobytes() == lcor.correct(texture, 1.0, 23.4, rho=0.4).tobytes()


def test_weights_and_shared_adaptation(picture):
    texture, light = picture["texture"], picture["illuminance"]
    weights = np.zeros((24, 32))
    weights[:, 10:20] = 2.0
    chunked = da.from_array(texture, chunks=(11, 32, 3))
    mean = lcor.picture_mean(texture, light, weights=weights)
    assert lcor.dask.picture_mean(chunked, light, weights=weights) == mean
    got = lcor.dask.correct(chunked, light, 23.4, r_mean=mean).compute()
    np.testing.assert_array_equal(got, lcor.correct(texture, light, 23.4, r_mean=mean))


def test_numpy_arrays_are_sent_to_the_plain_call(picture):
    with pytest.raises(TypeError, match=r"use lcor\.correct"):
        lcor.dask.correct(picture["texture"], 1.0, 23.4)
