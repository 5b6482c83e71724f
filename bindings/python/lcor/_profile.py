# SPDX-License-Identifier: MIT
"""Device profiles: readings, where they come from, and the contrast that follows."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from typing import Any, NamedTuple, Union

from numpy.typing import NDArray

from . import _core
from ._names import choice

_BLACKS = {"full": _core.Black.full, "darkest": _core.Black.darkest}
Path = Union[str, "os.PathLike[str]"]


class Reading(NamedTuple):
    """One reading of one patch; None where not known."""

    id: str
    name: str
    #: sent to the device, 0..255
    rgb: tuple[float, float, float] | None
    #: sent to the device, 0..100 %
    cmyk: tuple[float, float, float, float] | None
    #: through red, green and blue filters [1]
    density: tuple[float, float, float] | None
    #: visual density [1]
    visual: float | None
    #: Y in percent of a perfect diffuser, or cd/m2 of a display
    xyz: tuple[float, float, float] | None
    #: kept, but takes no part in derived values
    rejected: bool


class Profile:
    """A device profile: CGATS.17 text, as lccal writes it.

    Examples
    --------
    >>> import lcor
    >>> profile = lcor.Profile()
    >>> profile.add(rgb=(255, 255, 255), visual=0.07)
    >>> profile.add(rgb=(0, 0, 0), visual=1.44)
    >>> round(profile.contrast, 2)
    23.44
    """

    def __init__(self) -> None:
        self._core = _core.Profile()

    @classmethod
    def parse(cls, text: str | bytes, black: str = "full") -> Profile:
        """Read CGATS text: a profile, or measurements of another program (.ti3, i1Profiler).

        Parameters
        ----------
        text
            The file's content.
        black
            Which readings are black: "full" is R=G=B=0 or K 100 % alone, "darkest" the darkest
            patch measured.

        Raises
        ------
        FormatError
            Not such a text; the message names the line and what to do.
        """
        profile = cls.__new__(cls)
        data = text.encode() if isinstance(text, str) else bytes(text)
        profile._core = _core.Profile.parse(data, choice("black", black, _BLACKS))
        return profile

    @classmethod
    def load(cls, path: Path, black: str = "full") -> Profile:
        """Read a file; arguments and errors as :meth:`parse`, and OSError."""
        with open(path, "rb") as file:
            text = file.read()
        try:
            return cls.parse(text, black)
        except ValueError as error:
            raise type(error)(f"{os.fspath(path)}: {error}") from None

    def format(self) -> bytes:
        """The profile as CGATS text. ValueError while the readings give no contrast."""
        return self._core.format()

    def save(self, path: Path) -> None:
        """Write a file: it is complete, or the old one stays. OSError, and as :meth:`format`.

        What a link leads to is replaced, not the link; a device or pipe is written to.
        """
        text = self.format()
        path = os.path.realpath(os.fsdecode(path))
        if os.path.exists(path) and not os.path.isfile(path):
            with open(path, "wb") as file:
                file.write(text)
            return
        try:
            handle, temporary = tempfile.mkstemp(dir=os.path.dirname(path), prefix=".lcor-")
        except OSError as error:
            error.filename = path  # not a name nobody gave
            raise
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(temporary, 0o666 & ~umask)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise

    @property
    def contrast(self) -> float:
        """c = Jmax/Jmin [1] (eq 13a); 0 while the readings give none."""
        return self._core.contrast

    @property
    def contrast_u95(self) -> float:
        """Half-width of the interval that holds the contrast with 95 %; 0 if not known."""
        return self._core.contrast_u95

    def evaluate(self) -> dict[str, Any]:
        """What follows from the readings.

        contrast, contrast_u95, d_min and d_max (medians), u_min and u_max (standard
        uncertainties, 0 if not known), n_min and n_max (readings they rest on).

        Raises
        ------
        ValueError
            White or black is missing, or black is no darker than white.
        """
        return self._core.evaluate()

    @property
    def readings(self) -> list[Reading]:
        """All readings in their order."""
        return [Reading(**self._core.reading(i)) for i in range(self._core.count)]

    def add(
        self,
        rgb: Iterable[float] | None = None,
        *,
        cmyk: Iterable[float] | None = None,
        visual: float | None = None,
        density: Iterable[float] | None = None,
        xyz: Iterable[float] | None = None,
        id: str | None = None,
        name: str = "",
    ) -> None:
        """Add one reading; units as in :class:`Reading`.

        Raises
        ------
        ValueError
            A number outside its range, or neither `visual` nor `xyz`.
        """
        self._core.add(rgb, cmyk, density, visual, xyz, id, name)

    def reject(self, index: int, rejected: bool = True) -> None:
        """Keep a reading but leave it out of derived values, or take it back in."""
        self._core.reject(index, rejected)

    @property
    def keywords(self) -> dict[str, str]:
        """Provenance: INSTRUMENTATION, CREATED, MATERIAL and others; a copy."""
        return self._core.keywords()

    def set_keyword(self, name: str, value: str | None) -> None:
        """Set one line of provenance, or remove it with None. ValueError for a bad name."""
        self._core.set_keyword(name, value)

    @property
    def resolution(self) -> float:
        """Step of the instrument [density, or Y]; 0 if not known."""
        return self._core.resolution

    @resolution.setter
    def resolution(self, step: float) -> None:
        self._core.resolution = step

    @property
    def black(self) -> str:
        """Which readings are black: "full" or "darkest"."""
        return str(self._core.black.name)

    @property
    def grey_levels(self) -> int:
        """Different grey levels between black and white; with 0 there is no tone curve."""
        return self._core.grey_levels

    def tone_curve(self, n: int = 256) -> NDArray[Any]:
        """Device values for n equal steps of displayed luminance, for :class:`lcor.Plan`.

        Returns
        -------
        (n,)
            float32, 0..1, non-decreasing.

        Raises
        ------
        ValueError
            n below 2, or no grey ramp that rises.
        """
        return self._core.tone_curve(n)  # type: ignore[no-any-return]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self).parse, (self.format(), self.black)

    def __repr__(self) -> str:
        count = self._core.count
        return f"<lcor.Profile contrast={self.contrast:.4g} of {count} readings>"
