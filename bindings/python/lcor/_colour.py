# SPDX-License-Identifier: MIT
"""RGB and L*a*b* (eqs 1-4, 17, 18)."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike, NDArray

from . import _core
from ._names import Space, Transfer, colour


def rgb_to_lab(
    rgb: ArrayLike,
    space: Space = "ntsc",
    lightness: str = "cie",
    *,
    transfer: Transfer = "linear",
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """L*a*b* of RGB colours (eqs 1-4).

    Parameters
    ----------
    rgb : (..., 3)
        float32 or float64 [0..1, other values are allowed], uint8 [0..255] or uint16 [0..65535];
        any strides.
    space
        Whose primaries: "ntsc" (eq 1), "srgb", or a matrix (3, 3) from linear RGB to XYZ.
    lightness
        "cie" for the CIE 1976 function, "paper" for the cube root everywhere as eqs 2-4 print it.
    transfer
        How `rgb` is stored: "linear", "srgb", or a number, the gamma.
    out
        Where to write; may be `rgb` itself when that is a float array.

    Returns
    -------
    (..., 3)
        L* [0..100], a*, b*; float32 for float32 and integer input, float64 for float64.

    Raises
    ------
    TypeError
        Samples of another type.
    ValueError
        The last dimension does not hold three channels, or an unknown word.

    Examples
    --------
    >>> import lcor
    >>> lcor.rgb_to_lab([1.0, 1.0, 1.0]).round(9) + 0.0
    array([100.,   0.,   0.])
    >>> lcor.rgb_to_lab([250 / 255, 50 / 255, 150 / 255]).round(3)
    array([74.527, 66.382, -9.385])
    """
    return _core.rgb_to_lab(rgb, colour(space, transfer, lightness), out)  # type: ignore[no-any-return]


def lab_to_rgb(
    lab: ArrayLike,
    space: Space = "ntsc",
    lightness: str = "cie",
    *,
    transfer: Transfer = "linear",
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """RGB of L*a*b* colours: the inverse of :func:`rgb_to_lab`. Nothing is clipped.

    Parameters
    ----------
    lab : (..., 3)
        L* [0..100], a*, b*; float32 or float64, any strides.
    space, lightness, transfer, out
        As for :func:`rgb_to_lab`.

    Returns
    -------
    (..., 3)
        RGB of the same type, 0..1 where the colour lies in the gamut.

    Raises
    ------
    TypeError, ValueError
        As :func:`rgb_to_lab`.

    Examples
    --------
    >>> import lcor
    >>> lcor.lab_to_rgb(lcor.rgb_to_lab([0.25, 0.5, 0.75])).round(9)
    array([0.25, 0.5 , 0.75])
    """
    return _core.lab_to_rgb(lab, colour(space, transfer, lightness), out)  # type: ignore[no-any-return]


def hue(lab: ArrayLike) -> Any:
    """Hue angle of L*a*b* colours (eq 17).

    Parameters
    ----------
    lab : (..., 3)
        float32 or float64.

    Returns
    -------
    (...)
        Angle [radians, -pi..pi], 0 where chroma is 0.

    Raises
    ------
    TypeError, ValueError
        As :func:`rgb_to_lab`.

    Examples
    --------
    >>> import lcor
    >>> float(lcor.hue([50.0, 0.0, 10.0]))
    1.5707963267948966
    """
    return _core.hue(lab)


def chroma(lab: ArrayLike) -> Any:
    """Chroma of L*a*b* colours (eq 18): the distance from the grey axis.

    Parameters
    ----------
    lab : (..., 3)
        float32 or float64.

    Returns
    -------
    (...)
        Chroma >= 0, in units of a* and b*.

    Raises
    ------
    TypeError, ValueError
        As :func:`rgb_to_lab`.

    Examples
    --------
    >>> import lcor
    >>> float(lcor.chroma([50.0, 3.0, 4.0]))
    5.0
    """
    return _core.chroma(lab)
