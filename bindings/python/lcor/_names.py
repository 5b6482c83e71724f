# SPDX-License-Identifier: MIT
"""Words of the Python face turned into what the C library takes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from numbers import Real
from operator import index as integer
from typing import Any, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core

T = TypeVar("T")

#: A word for one of the built-in sets of primaries, or a matrix from linear RGB to XYZ.
Space = Union[str, ArrayLike]
#: "linear", "srgb", or the exponent of a power law.
Transfer = Union[str, float]

_SPACES = {"ntsc": _core.Primaries.ntsc, "srgb": _core.Primaries.srgb}
_TRANSFERS = {"linear": _core.Transfer.linear, "srgb": _core.Transfer.srgb}
_LIGHTNESS = {"cie": _core.Lightness.cie, "paper": _core.Lightness.paper}
READINGS = {"patch": _core.Reading.patch, "texel": _core.Reading.texel}
GAMUTS = {"keep-hue": _core.Gamut.keep_hue, "clip": _core.Gamut.clip}
METHODS = {"adaptive": _core.MeanMethod.adaptive, "literal": _core.MeanMethod.literal}


def choice(what: str, word: object, words: Mapping[str, T], otherwise: str = "") -> T:
    """The value of a word; a ValueError that lists the words there are."""
    try:
        return words[word]  # type: ignore[index]
    except (KeyError, TypeError):
        known = " or ".join(f'"{w}"' for w in words)
        raise ValueError(f"{what} must be {known}{otherwise}, not {word!r}") from None


def _make(space: Space, transfer: Transfer, lightness: str) -> _core.Colour:
    matrix = None
    if isinstance(space, str):
        primaries = choice("space", space, _SPACES, " or a matrix (3, 3)")
    else:
        primaries, matrix = _core.Primaries.custom, np.asarray(space, np.float64)
    kind, gamma = _core.Transfer.gamma, 1.0
    if isinstance(transfer, Real):
        gamma = float(transfer)
    else:
        kind = choice("transfer", transfer, _TRANSFERS, " or a number, the gamma")
    light = choice("lightness", lightness, _LIGHTNESS)
    return _core.Colour.make(primaries, matrix, kind, gamma, light)


_make_once = lru_cache(maxsize=64)(_make)


def colour(space: Space, transfer: Transfer, lightness: str) -> _core.Colour:
    """The colour space of these words; the same object each time for the built-in ones."""
    if isinstance(space, str) and isinstance(transfer, (str, Real)):
        return _make_once(space, transfer, lightness)
    return _make(space, transfer, lightness)


def number(what: str, value: Any) -> float:
    """One number, not an array of them."""
    if np.ndim(value) != 0 or not hasattr(value, "__float__"):
        raise TypeError(f"{what} must be a number, not {value!r}")
    return float(value)


def item(what: str, value: Any, count: int) -> int:
    """The number of one of `count` things."""
    try:
        found = integer(value)
    except TypeError:
        raise TypeError(f"{what} must be a whole number, not {value!r}") from None
    if not 0 <= found < count:
        raise ValueError(f"{what} {found}: the scene has {count}, numbered from 0")
    return found


def grid(value: Any) -> tuple[int, int]:
    """How many patches along u and v: two numbers, or one for both."""
    try:
        nu, nv = map(integer, (value, value) if np.ndim(value) == 0 else value)
    except (TypeError, ValueError):
        raise ValueError(f"patches takes one or two whole numbers, not {value!r}") from None
    if min(nu, nv) < 1:
        raise ValueError(f"patches must be at least 1 along each edge, not {value!r}")
    return nu, nv


def side(value: Any) -> int:
    """How many patches along each side of a triangle."""
    n, other = grid(value)
    if n != other:
        raise ValueError(f"patches of a triangle is one number, not {value!r}")
    return n


def triple(what: str, value: Any) -> tuple[float, float, float]:
    """Three numbers."""
    x, y, z = numbers(what, value, 3)
    return x, y, z


def numbers(what: str, value: Iterable[float], count: int) -> tuple[float, ...]:
    """So many numbers from any sequence or array."""
    try:
        result = tuple(number(what, v) for v in value)
    except TypeError:
        result = ()
    if len(result) != count:
        raise ValueError(f"{what} takes {count} numbers, not {value!r}")
    return result


def channels(what: str, value: Any) -> tuple[float, float, float]:
    """One number for all three channels, or three."""
    if np.ndim(value) == 0:
        return (number(what, value),) * 3
    return triple(what, value)


def split_rho(rho: ArrayLike) -> tuple[float, ArrayLike | None]:
    """A reflectance for all pixels, or 0.5 and the map of one for each."""
    if isinstance(rho, (int, float)):
        return float(rho), None
    return 0.5, rho
