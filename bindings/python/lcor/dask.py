# SPDX-License-Identifier: MIT
"""Pictures larger than memory, and many machines (extra ``dask``).

Both passes of the correction split anywhere: the mean of r is a tree reduction over chunks whose
bits do not depend on the tree (:class:`lcor.Mean`), and corrected pixels depend on nothing but
themselves and the plan. So every chunking, scheduler and number of machines gives the bytes of the
single call :func:`lcor.correct`.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any

import numpy as np

try:
    import dask.array as da
    from dask.base import compute
    from dask.delayed import delayed
except ImportError as error:
    raise ImportError('lcor.dask needs dask: pip install "lcor[dask]"') from error

import lcor

from ._names import Space, Transfer


def _chunked(texture: da.Array, *maps: Any) -> tuple[da.Array, list[Any]]:
    """The texture with its channels in one chunk, and maps in chunks that match its pixels."""
    if not isinstance(texture, da.Array):
        raise TypeError("texture must be a dask array: use lcor.correct for a numpy array")
    texture = texture.rechunk({texture.ndim - 1: -1})
    matched = []
    for values in maps:
        if values is None or np.ndim(values) == 0:
            matched.append(values)
            continue
        whole = values if isinstance(values, da.Array) else da.asarray(np.asarray(values))
        whole = da.broadcast_to(whole, texture.shape[:-1])
        matched.append(whole.rechunk(texture.chunks[:-1]))
    return texture, matched


def _chunks(array: Any, count: int) -> list[Any]:
    """Chunks of an array in order, or the number that stands for all of them."""
    if not isinstance(array, da.Array):
        return [array] * count
    return list(array.to_delayed().ravel())


def _add(
    start: lcor.Mean,
    texture: Any,
    illuminance: Any,
    rho: Any,
    weights: Any,
    options: dict[str, Any],
) -> lcor.Mean:
    rho = 0.5 if rho is None else rho
    return start.copy().add_picture(texture, illuminance, rho, weights=weights, **options)


def _merge(means: Iterable[lcor.Mean]) -> lcor.Mean:
    first, *others = means
    return reduce(lambda into, mean: into.merge(mean), others, first.copy())


def _tree(means: list[Any], fan: int = 8) -> Any:
    """One delayed mean of many, `fan` at a time."""
    merge = delayed(_merge)
    while len(means) > 1:
        means = [merge(means[i : i + fan]) for i in range(0, len(means), fan)]
    return means[0]


def picture_mean(
    texture: da.Array,
    illuminance: Any,
    rho: Any = 0.5,
    *,
    weights: Any = None,
    method: str = "adaptive",
    reading: str = "patch",
    space: Space = "ntsc",
    transfer: Transfer = "linear",
) -> float:
    """Mean of r over a dask array: :func:`lcor.picture_mean`, to the last bit.

    Parameters
    ----------
    texture : (..., 3)
        dask array; each chunk must fit in a worker's memory.
    illuminance, rho, weights
        Numbers, numpy or dask arrays that broadcast to the pixels.
    method, reading, space, transfer
        As for :func:`lcor.picture_mean`.

    Returns
    -------
    float
        Computed now, on the scheduler in force: usually one or two passes over the data.

    Raises
    ------
    TypeError, ValueError
        As :func:`lcor.picture_mean`.

    Examples
    --------
    >>> import dask.array, lcor.dask
    >>> picture = dask.array.full((4, 6, 3), 0.25, chunks=(2, 3, 3))
    >>> round(lcor.dask.picture_mean(picture, 2.0, rho=0.25), 12)
    0.5
    """
    texture, (light, reflectance, weight) = _chunked(texture, illuminance, rho, weights)
    count = texture.npartitions
    parts = [_chunks(array, count) for array in (texture, light, reflectance, weight)]
    options = {"reading": reading, "space": space, "transfer": transfer}
    start, total = lcor.Mean(), lcor.Mean()
    add = delayed(_add)
    while True:
        shared = delayed(start)
        means = [add(shared, *chunk, options) for chunk in zip(*parts)]
        (total,) = compute(_tree(means))
        if total.error(method) == 0:
            return float(total.get(method))
        start = total.refine(method)


def _apply(texture: Any, illuminance: Any, rho: Any, plan: lcor.Plan) -> Any:
    return plan.apply(texture, illuminance, rho)[0]


def apply(plan: lcor.Plan, texture: da.Array, illuminance: Any, rho: Any = None) -> da.Array:
    """Correct a dask array chunk by chunk: :meth:`lcor.Plan.apply`, to the last bit.

    Parameters
    ----------
    plan
        Its r_mean is that of the whole picture, or of all frames that share an adaptation.
    texture : (..., 3)
        dask array.
    illuminance, rho
        Numbers, numpy or dask arrays that broadcast to the pixels.

    Returns
    -------
    (..., 3)
        dask array of the same type, nothing computed yet.

    Examples
    --------
    >>> import dask.array, lcor, lcor.dask
    >>> picture = dask.array.full((4, 6, 3), 0.5, chunks=(2, 3, 3))
    >>> out = lcor.dask.apply(lcor.Plan(23.4, 0.5), picture, 1.0)
    >>> float(out[0, 0, 0].compute().round(9))
    0.5
    """
    texture, (light, reflectance) = _chunked(texture, illuminance, rho)
    pixels = "".join(chr(ord("a") + d) for d in range(texture.ndim - 1))
    arguments: list[Any] = [texture, pixels + "z"]
    for values in (light, reflectance):
        arguments += [values, pixels if isinstance(values, da.Array) else None]
    return da.blockwise(  # type: ignore[no-any-return]
        _apply, pixels + "z", *arguments, plan=plan, dtype=texture.dtype, concatenate=True
    )


def correct(
    texture: da.Array,
    illuminance: Any,
    contrast: float,
    *,
    rho: Any = 0.5,
    r_mean: float | None = None,
    method: str = "adaptive",
    weights: Any = None,
    **options: Any,
) -> da.Array:
    """Correct a dask array: :func:`lcor.correct`, to the last bit.

    The mean is computed now unless `r_mean` is given; the pixels when the result is.

    Parameters
    ----------
    texture, illuminance, rho, weights
        As for :func:`picture_mean`.
    contrast, r_mean, method, options
        As for :func:`lcor.correct`.

    Returns
    -------
    (..., 3)
        dask array of the type of `texture`.

    Examples
    --------
    >>> import dask.array, numpy, lcor, lcor.dask
    >>> picture = numpy.random.default_rng(0).random((8, 9, 3))
    >>> chunked = dask.array.from_array(picture, chunks=(3, 4, 3))
    >>> whole = lcor.correct(picture, 1.0, contrast=23.4)
    >>> bool((lcor.dask.correct(chunked, 1.0, contrast=23.4).compute() == whole).all())
    True
    """
    if r_mean is None:
        names = ("reading", "space", "transfer")
        r_mean = picture_mean(
            texture,
            illuminance,
            rho,
            weights=weights,
            method=method,
            **{name: options[name] for name in names if name in options},
        )
    number = np.ndim(rho) == 0 and not isinstance(rho, da.Array)
    plan = lcor.Plan(contrast, r_mean, **({"rho": rho} if number else {}), **options)
    return apply(plan, texture, illuminance, None if number else rho)
