# SPDX-License-Identifier: MIT
"""Lightness correction of pictures (sections 4.3-4.5, eqs 9-16) and the conventional method."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._adapt import Mean
from ._names import GAMUTS, READINGS, Space, Transfer, choice, colour, number, split_rho


class Stats(NamedTuple):
    """What happened to the pixels of one call."""

    #: pixels written
    pixels: int
    #: darker than the device shows (J < J1, eq 8)
    clipped_low: int
    #: lighter than the device shows (J > J2, eq 8)
    clipped_high: int
    #: RGB left 0..1 before the gamut rule
    out_of_gamut: int
    #: NaN, infinity or negative input; written as 0
    non_finite: int
    #: index of the first non_finite pixel, or None
    first_bad: tuple[int, ...] | None


def _result(result: tuple[Any, tuple[int, ...]]) -> tuple[NDArray[Any], Stats]:
    out, (pixels, low, high, gamut, bad, row, pixel) = result
    first = None
    if bad:
        rows = out.shape[:-2]
        outer = np.unravel_index(row, rows) if rows else ()
        first = (*(int(i) for i in outer), pixel)[: out.ndim - 1]
    return out, Stats(pixels, low, high, gamut, bad, first)


class Plan:
    """The correction for one device and one adaptation. Immutable; threads may share one.

    Parameters
    ----------
    contrast
        c of the device [1], above 1, infinity allowed (eq 13a).
    r_mean
        Mean of r over the picture (section 4.3), in the unit of illuminance times reflectance;
        0 when nothing was lit: all comes out black.
    rho
        Reflectance of the surface [1], 0 < rho <= 1, used where :meth:`apply` gets none.
    reading
        What rho means in r: "patch", the surface's mean reflectance (section 4.2), or "texel", the
        texel's own Y, which makes displayed luminance proportional to illuminance times Y.
    exponent
        t of eq 8, above 0.
    gamut
        Colours outside RGB 0..1: "keep-hue" lowers chroma until they fit, "clip" clips channels.
    space, transfer, lightness
        As for :func:`lcor.rgb_to_lab`. Integer pictures are usually stored with transfer "srgb".
    rho_ratio
        Measured over textured reflectance (section 5.2), above 0.
    tone_curve
        None, or the device's values at equal steps of linear 0..1, as
        :meth:`lcor.Profile.tone_curve` gives them; replaces the transfer function on output.

    Raises
    ------
    ValueError
        A number outside its range or an unknown word.

    Examples
    --------
    A pixel whose r is the mean is shown at half the luminance range (eq 9):

    >>> import lcor
    >>> plan = lcor.Plan(contrast=23.4, r_mean=0.5, rho=0.5)
    >>> out, stats = plan.apply([0.5, 0.5, 0.5], illuminance=1.0)
    >>> out.round(9)
    array([0.5, 0.5, 0.5])
    """

    __slots__ = ("_core", "_options")

    def __init__(
        self,
        contrast: float,
        r_mean: float,
        rho: float = 0.5,
        reading: str = "patch",
        exponent: float = 1.0,
        gamut: str = "keep-hue",
        space: Space = "ntsc",
        transfer: Transfer = "linear",
        lightness: str = "cie",
        *,
        rho_ratio: float = 1.0,
        tone_curve: ArrayLike | None = None,
    ) -> None:
        self._options: dict[str, Any] = {
            "contrast": contrast,
            "r_mean": r_mean,
            "rho": rho,
            "reading": reading,
            "exponent": exponent,
            "gamut": gamut,
            "space": space,
            "transfer": transfer,
            "lightness": lightness,
            "rho_ratio": rho_ratio,
            "tone_curve": tone_curve,
        }
        self._core = _core.Plan(
            number("contrast", contrast),
            number("r_mean", r_mean),
            number("rho", rho),
            number("rho_ratio", rho_ratio),
            number("exponent", exponent),
            choice("reading", reading, READINGS),
            choice("gamut", gamut, GAMUTS),
            colour(space, transfer, lightness),
            tone_curve,
        )

    @property
    def options(self) -> dict[str, Any]:
        """The arguments the plan was made with."""
        return dict(self._options)

    def apply(
        self,
        rgb: ArrayLike,
        illuminance: ArrayLike,
        rho: ArrayLike | None = None,
        out: NDArray[Any] | None = None,
    ) -> tuple[NDArray[Any], Stats]:
        """Correct pixels (eqs 9-16).

        Parameters
        ----------
        rgb : (..., 3)
            Stored values: float32 or float64 [0..1], uint8 [0..255] or uint16 [0..65535]; any
            strides, no copy.
        illuminance : (...)
            Number or map >= 0 in the unit of r_mean; float32 or float64. Broadcasts with the
            pixels, so one colour can be swept over a list of illuminances.
        rho : (...)
            None for the plan's, or a map of reflectances [1].
        out
            Array to write; may be `rgb` itself, and of another of the four types.

        Returns
        -------
        (array, Stats)
            Corrected pixels of the type of `rgb` (or `out` itself), and what was clipped.

        Raises
        ------
        TypeError
            Samples of another type; the text says how to convert them.
        ValueError
            Shapes that do not fit, or an `out` that overlaps its inputs in part.

        Examples
        --------
        >>> import lcor, numpy
        >>> picture = numpy.full((2, 3, 3), 128, numpy.uint8)
        >>> plan = lcor.Plan(contrast=23.4, r_mean=0.25, transfer="srgb")
        >>> out, stats = plan.apply(picture, illuminance=0.25)
        >>> out.dtype.name, stats.pixels
        ('uint8', 6)
        """
        return _result(self._core.apply(rgb, illuminance, rho, out))

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self._options)

    def __repr__(self) -> str:
        words = ", ".join(f"{k}={v!r}" for k, v in self._options.items() if v is not None)
        return f"lcor.Plan({words})"


def _rebuild(kind: type[Plan], options: dict[str, Any]) -> Plan:
    return kind(**options)


def picture_mean(
    texture: ArrayLike,
    illuminance: ArrayLike,
    rho: ArrayLike = 0.5,
    *,
    weights: ArrayLike | None = None,
    method: str = "adaptive",
    reading: str = "patch",
    space: Space = "ntsc",
    transfer: Transfer = "linear",
) -> float:
    """Mean of r over a picture (sections 3.1 and 4.3), to rounding: the first pass of `correct`.

    Parameters
    ----------
    texture, illuminance, rho, reading, space, transfer
        As for :func:`correct`.
    weights
        None, or weights >= 0 that broadcast to the pixels: gaze, or coverage where no surface is.
    method
        "adaptive" or "literal", as for :func:`lcor.geometric_mean`.

    Returns
    -------
    float
        r_mean for :class:`Plan`. Pixels of NaN, infinite or negative input count as black, as they
        are shown.

    Raises
    ------
    TypeError, ValueError
        As :meth:`Plan.apply`.

    Examples
    --------
    >>> import lcor
    >>> grey = [[0.5, 0.5, 0.5], [0.5, 0.5, 0.5]]
    >>> round(lcor.picture_mean(grey, [0.5, 2.0], rho=0.5), 12)
    0.5
    """
    mean = Mean()
    while True:
        mean.add_picture(
            texture,
            illuminance,
            rho,
            weights=weights,
            reading=reading,
            space=space,
            transfer=transfer,
        )
        if mean.error(method) == 0:
            return mean.get(method)
        mean.refine(method)


def correct(
    texture: ArrayLike,
    illuminance: ArrayLike,
    contrast: float,
    *,
    rho: ArrayLike = 0.5,
    reading: str = "patch",
    exponent: float = 1.0,
    gamut: str = "keep-hue",
    space: Space = "ntsc",
    transfer: Transfer = "linear",
    lightness: str = "cie",
    rho_ratio: float = 1.0,
    tone_curve: ArrayLike | None = None,
    r_mean: float | None = None,
    method: str = "adaptive",
    weights: ArrayLike | None = None,
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """Correct a picture for a device: both passes, :func:`picture_mean` and :meth:`Plan.apply`.

    Parameters
    ----------
    texture : (..., 3)
        Stored values as for :meth:`Plan.apply`.
    illuminance : (...)
        Number or map >= 0 that broadcasts with the pixels, any unit.
    contrast
        c of the device [1]: a profile's, or from :func:`lcor.contrast_from_density`.
    rho
        Reflectance of the surface (section 4.2: the texture's mean), a number or a map [1].
    r_mean
        The adaptation to use; None for that of this picture (`method`, `weights` as for
        :func:`picture_mean`). Give one to frames that must share it.
    reading, exponent, gamut, space, transfer, lightness, rho_ratio, tone_curve
        As for :class:`Plan`.
    out
        As for :meth:`Plan.apply`.

    Returns
    -------
    (..., 3)
        Corrected pixels of the type of `texture`. For counts of clipped pixels use :class:`Plan`.

    Raises
    ------
    TypeError, ValueError
        As :class:`Plan` and :meth:`Plan.apply`.

    Examples
    --------
    >>> import lcor
    >>> lcor.correct([[0.4, 0.4, 0.4]], [10.0], contrast=23.4, rho=0.4).round(9)
    array([[0.5, 0.5, 0.5]])
    """
    if r_mean is None:
        r_mean = picture_mean(
            texture,
            illuminance,
            rho,
            weights=weights,
            method=method,
            reading=reading,
            space=space,
            transfer=transfer,
        )
    plan_rho, values = split_rho(rho)
    plan = Plan(
        contrast,
        r_mean,
        plan_rho,
        reading,
        exponent,
        gamut,
        space,
        transfer,
        lightness,
        rho_ratio=rho_ratio,
        tone_curve=tone_curve,
    )
    return plan.apply(texture, illuminance, values, out)[0]


def conventional(
    texture: ArrayLike,
    illuminance: ArrayLike,
    rho: ArrayLike = 1.0,
    *,
    space: Space = "ntsc",
    transfer: Transfer = "linear",
    out: NDArray[Any] | None = None,
) -> NDArray[Any]:
    """The conventional method for comparison: linear RGB times rho times illuminance (eq 19).

    Parameters
    ----------
    texture, illuminance, rho, space, transfer, out
        As for :func:`correct`. The unit of illuminance matters here: RGB of 1 is white.

    Returns
    -------
    (..., 3)
        Pixels of the type of `texture`, each channel clipped to 0..1.

    Raises
    ------
    TypeError, ValueError
        As :meth:`Plan.apply`.

    Examples
    --------
    >>> import lcor
    >>> lcor.conventional([0.9, 0.2, 0.6], [0.5, 2.0], 1.0)
    array([[0.45, 0.1 , 0.3 ],
           [1.  , 0.4 , 1.  ]])
    """
    plan = Plan(2.0, 1.0, space=space, transfer=transfer)
    return _result(plan._core.conventional(texture, illuminance, rho, out))[0]
