# SPDX-License-Identifier: MIT
"""Adaptation: the mean of r, contrast from densities, the curve of eq 8."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from . import _core
from ._names import METHODS, READINGS, Space, Transfer, choice, colour, split_rho


def contrast_from_density(d_max: float, d_min: float) -> float:
    """Contrast of a device from two densities of one print (section 2.3, eq 13a).

    Parameters
    ----------
    d_max, d_min
        Density [1] of black and of white.

    Returns
    -------
    float
        c = 10^(d_max - d_min) [1], above 1.

    Raises
    ------
    ValueError
        Not finite, or d_max is not above d_min.

    Examples
    --------
    >>> import lcor
    >>> round(lcor.contrast_from_density(1.44, 0.07), 3)
    23.442
    """
    return _core.contrast_from_density(d_max, d_min)


def contrast_u95(contrast: float, u_d_max: float, u_d_min: float) -> float:
    """Half-width of the interval that holds the contrast with 95 %.

    Parameters
    ----------
    contrast
        c [1].
    u_d_max, u_d_min
        Standard uncertainties of the two densities [1].

    Returns
    -------
    float
        1.96 c ln(10) sqrt(u_d_max^2 + u_d_min^2).

    Examples
    --------
    >>> import lcor
    >>> round(lcor.contrast_u95(23.4, 0.01, 0.005), 3)
    1.181
    """
    return _core.contrast_u95(contrast, u_d_max, u_d_min)


def adapt(j: ArrayLike, j_mean: float, j_min: float, j_max: float, exponent: float = 1.0) -> Any:
    """Display luminance H of scene luminance J (eq 8).

    Parameters
    ----------
    j : (...)
        Scene luminance >= 0, any unit; float32, float64 or a number.
    j_mean
        The eye's mean luminance > 0, same unit: geometric mean of the picture.
    j_min, j_max
        Least and greatest luminance of the device, 0 <= j_min < j_max, any unit.
    exponent
        t of eq 8, >= 0.

    Returns
    -------
    (...)
        (j_min + j_max) / 2 * (j / j_mean)^t, clipped to j_min..j_max.

    Raises
    ------
    ValueError
        A number outside the ranges above.

    Examples
    --------
    >>> import lcor
    >>> lcor.adapt([0.01, 1.0, 1.5, 100.0], 1.0, 10.0, 234.0)
    array([ 10., 122., 183., 234.])
    """
    return _core.adapt(j, j_mean, j_min, j_max, exponent)


def adapt_inverse(
    h: ArrayLike, j_mean: float, j_min: float, j_max: float, exponent: float = 1.0
) -> Any:
    """Scene luminance J that :func:`adapt` shows as H.

    Parameters
    ----------
    h : (...)
        Display luminance in j_min..j_max.
    j_mean, j_min, j_max, exponent
        As for :func:`adapt`; exponent > 0.

    Raises
    ------
    ValueError
        A number outside its range.

    Examples
    --------
    >>> import lcor
    >>> float(lcor.adapt_inverse(183.0, 1.0, 10.0, 234.0))
    1.5
    """
    return _core.adapt_inverse(h, j_mean, j_min, j_max, exponent)


def adapt_range(
    j_mean: float, j_min: float, j_max: float, exponent: float = 1.0
) -> tuple[float, float]:
    """J1 and J2: the scene luminances shown as j_min and j_max (eq 8, figure 1).

    Parameters
    ----------
    j_mean, j_min, j_max, exponent
        As for :func:`adapt`.

    Returns
    -------
    (float, float)
        In the unit of j_mean; 0 and infinity for exponent 0.

    Raises
    ------
    ValueError
        A number outside its range.

    Examples
    --------
    >>> import lcor
    >>> j1, j2 = lcor.adapt_range(1.0, 10.0, 234.0)
    >>> round(j2 / j1, 9)
    23.4
    """
    return _core.adapt_range(j_mean, j_min, j_max, exponent)


def geometric_mean(
    r: ArrayLike, weights: ArrayLike | None = None, method: str = "adaptive"
) -> float:
    """Geometric mean of the virtual reflectance r (section 4.3), to rounding.

    Parameters
    ----------
    r : (...)
        Values >= 0; float32 or float64. NaN, infinite and negative ones are left out.
    weights
        None, or weights >= 0 that broadcast to r: a gaze, area or coverage map.
    method
        "adaptive": values below a tenth of the mean count as a tenth of it, so that a black corner
        cannot rule the picture. "literal": the plain geometric mean of max(r, 1e-8 * largest).

    Returns
    -------
    float
        The mean; 0 when every r is 0.

    Raises
    ------
    ValueError
        No valid value of weight above 0.

    Examples
    --------
    >>> import lcor
    >>> round(lcor.geometric_mean([0.1, 0.4]), 12)
    0.2
    >>> round(lcor.geometric_mean([0.0, 0.4]), 3)
    0.04
    """
    return _core.geometric_mean(r, weights, choice("method", method, METHODS))


class Mean:
    """Running geometric mean (section 4.3): one for each thread or machine, then merge.

    The bits of the result depend neither on the order of the values nor on how they were split.
    A Mean can be pickled. Values near the bound of the method leave a small doubt (:meth:`error`);
    :meth:`refine` and adding all the same values again removes it.

    Examples
    --------
    >>> import lcor
    >>> left, right = lcor.Mean().add([0.1, 0.4]), lcor.Mean().add([0.2, 0.2])
    >>> left.merge(right).get() == lcor.Mean().add([0.1, 0.2, 0.4, 0.2]).get()
    True
    """

    def __init__(self) -> None:
        self._core = _core.Mean()

    def add(self, r: ArrayLike, weights: ArrayLike | None = None) -> Mean:
        """Add values and return self; arguments as for :func:`geometric_mean`."""
        self._core.add(r, weights)
        return self

    def add_picture(
        self,
        texture: ArrayLike,
        illuminance: ArrayLike,
        rho: ArrayLike = 0.5,
        *,
        weights: ArrayLike | None = None,
        reading: str = "patch",
        space: Space = "ntsc",
        transfer: Transfer = "linear",
    ) -> Mean:
        """Add r of every pixel of a picture or a part of one (section 3.1) and return self.

        Arguments as for :func:`lcor.correct`; `weights` broadcast to the pixels.
        """
        number, values = split_rho(rho)
        plan = _core.Plan(
            2.0,
            1.0,
            number,
            1.0,
            1.0,
            choice("reading", reading, READINGS),
            _core.Gamut.keep_hue,
            colour(space, transfer, "cie"),
            None,
        )
        plan.add_to(self._core, texture, illuminance, values, weights)
        return self

    def merge(self, other: Mean) -> Mean:
        """Add what `other` has seen and return self.

        Raises ValueError when one of the two was refined and the other is not its copy.
        """
        self._core.merge(other._core)
        return self

    def get(self, method: str = "adaptive") -> float:
        """The mean so far; 0 when every value was 0. ValueError when nothing was added."""
        return self._core.get(choice("method", method, METHODS))

    def error(self, method: str = "adaptive") -> float:
        """Bound of the relative error of :meth:`get` that another pass would reduce."""
        return self._core.error(choice("method", method, METHODS))

    def refine(self, method: str = "adaptive") -> Mean:
        """Begin another pass over the same values and return self."""
        self._core.refine(choice("method", method, METHODS))
        return self

    def copy(self) -> Mean:
        """An independent Mean that has seen the same."""
        other = Mean()
        other.__setstate__(self.__getstate__())
        return other

    def __getstate__(self) -> bytes:
        return self._core.state()

    def __setstate__(self, state: bytes) -> None:
        self._core = _core.Mean()
        self._core.set_state(state)

    def __repr__(self) -> str:
        try:
            return f"<lcor.Mean {self.get():.6g}>"
        except ValueError:
            return "<lcor.Mean of nothing>"
