# SPDX-License-Identifier: MIT
"""Irradiance by radiosity (section 3.1)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Optional

from numpy.typing import ArrayLike, NDArray

from . import _core
from ._errors import NotConvergedWarning
from ._names import choice, item, number
from ._scene import Scene

#: Called with the part done, 0..1; a true result cancels.
Progress = Optional[Callable[[float], object]]

_NORMS = {"rms": _core.Norm.rms, "max": _core.Norm.max}
_ENGINES = {
    "auto": _core.Engine.auto,
    "links": _core.Engine.links,
    "gather": _core.Engine.gather,
    "paths": _core.Engine.paths,
}
_KINDS = {"average": _core.Value.average, "centre": _core.Value.centre}


class Solution:
    """Irradiance of a scene; made by :func:`solve_radiosity`.

    Arrays have a last dimension of 3 when ``report["channels"]`` is 3 (lights of different
    colour), else none. The unit is that of the lights: lux for candela and metres.
    """

    def __init__(self, scene: Scene, core: _core.Solution) -> None:
        self._scene = scene
        self._core = core

    @property
    def report(self) -> dict[str, Any]:
        """How it was solved and how close it came.

        error_rms, error_max (estimates; max as sampled), energy_defect, converged, iterations,
        channels, engine, links, elements, rays, bytes, seconds, models (what the scene required).

        engine_reason, visibility_reason and channels_reason say why in words. links_seconds,
        gather_seconds and paths_seconds are what the engines were estimated to take where lcor
        chose between them (infinite: cannot do it, paths without `points`), else 0. pairs_apart,
        pairs_open and pairs_tested count pairs of faces that cannot see each other, do so fully,
        and are tested (engine links), which solved surfaces_merged coplanar surfaces that look
        alike as merged_into larger ones.
        """
        return self._core.report()

    @property
    def scene(self) -> Scene:
        """The scene solved."""
        return self._scene

    def _patches(self, surface: int, kind: str, direct: bool) -> NDArray[Any]:
        surface = item("surface", surface, self._scene.surface_count)
        values = self._core.patches(surface, choice("kind", kind, _KINDS), direct)
        shape = self._scene._shapes[surface]
        return values.reshape(shape + values.shape[1:])  # type: ignore[no-any-return]

    def irradiance(self, surface: int, kind: str = "average") -> NDArray[Any]:
        """Irradiance of every patch of a surface, on its facing side.

        Parameters
        ----------
        surface
            Number given by the scene's add call.
        kind
            "average" over each patch, or "centre".

        Returns
        -------
        (nu, nv)
            float64, index [i, j], i along edge_u; one list for triangles and polygons. A last
            dimension of 3 when the solution has three channels.

        Raises
        ------
        ValueError
            A surface that is not there or an unknown kind.
        """
        return self._patches(surface, kind, False)

    def direct(self, surface: int, kind: str = "average") -> NDArray[Any]:
        """The part of :meth:`irradiance` that comes straight from lights without area."""
        return self._patches(surface, kind, True)

    def at(self, points: ArrayLike, normals: ArrayLike) -> Any:
        """Irradiance at points, direct and indirect.

        Parameters
        ----------
        points : (..., 3)
            Places, scene units; float32 or float64.
        normals : (..., 3)
            Of any length: the side that receives. Broadcasts with `points`.

        Returns
        -------
        (...)
            float64 irradiance in the unit of the lights; (..., 3) when the solution has three
            channels.

        Raises
        ------
        ValueError
            A point that is not finite, a normal without direction, or shapes that do not fit.
        """
        return self._core.at(points, normals, False)

    def direct_at(self, points: ArrayLike, normals: ArrayLike) -> Any:
        """The part of :meth:`at` that comes straight from lights without area."""
        return self._core.at(points, normals, True)

    def update(self) -> Solution:
        """Solve again after the scene's set_light or set_surface, keeping what still holds."""
        self._core.update()
        self._warn()
        return self

    def _warn(self) -> None:
        report = self.report
        if not report["converged"]:
            text = (
                f"stopped at an estimated error of {report['error_rms']:.2g} rms, "
                f"{report['error_max']:.2g} at most ({report['models']}): "
                "raise max_seconds, max_bytes or tolerance"
            )
            warnings.warn(text, NotConvergedWarning, stacklevel=3)

    def __repr__(self) -> str:
        report = self.report
        return f"<lcor.Solution error_rms={report['error_rms']:.2g} engine={report['engine']}>"


def solve_radiosity(
    scene: Scene,
    tolerance: float = 1e-2,
    norm: str = "rms",
    *,
    engine: str = "auto",
    points: int = 0,
    channels: int | None = None,
    max_seconds: float = 0.0,
    max_bytes: int = 0,
    threads: int = 1,
    progress: Progress = None,
) -> Solution:
    """Solve a scene for its irradiance (section 3.1) to a requested accuracy.

    Parameters
    ----------
    scene
        Surfaces and lights; committed if it was not yet.
    tolerance
        Error asked for in `norm`, 1e-5..1, relative to the irradiance, or to 2 % of the scene's
        mean where that is more.
    norm
        "rms": area-weighted over the patches; "max": the largest.
    engine
        "links": light carried between elements of surfaces, for scenes of few surfaces;
        "gather": light gathered by rays over a field made first, for any number of them;
        "paths": rays without a field, for few places, since each takes longer; "auto" lets the
        scene decide, and the report says how.
    points
        So many places will be asked for, points and patches; 0: many, or not known. For few,
        "auto" may choose paths. More may be asked for all the same.
    channels
        None: 1 if lights and emission are grey, else 3; or 1 or 3.
    max_seconds, max_bytes
        Limits, 0 for none. On reaching one the best solution so far is returned with a
        :class:`lcor.NotConvergedWarning`.
    threads
        Threads to use; the result has the same bits for any number.
    progress
        Called now and then with the part done, 0..1; a true result cancels.

    Returns
    -------
    Solution

    Raises
    ------
    ValueError
        A bad scene (its text names the item) or option.
    Cancelled
        `progress` asked to stop.
    MemoryError

    Examples
    --------
    A closed furnace: every wall emits 1 and reflects half, so that B = 1 / (1 - 0.5) = 2.

    >>> import lcor
    >>> scene = lcor.Scene()
    >>> for o, u, v in [((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 0, 1), (0, 1, 0), (1, 0, 0)),
    ...                 ((0, 0, 0), (0, 0, 1), (1, 0, 0)), ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
    ...                 ((0, 0, 0), (0, 1, 0), (0, 0, 1)), ((1, 0, 0), (0, 0, 1), (0, 1, 0))]:
    ...     wall = scene.add_quad(o, u, v, reflectance=0.5, emission=1.0)
    >>> solution = lcor.solve_radiosity(scene, tolerance=1e-3)
    >>> abs(solution.irradiance(wall)[0, 0] - 2.0) < 1e-3
    np.True_
    """
    for name, value in (("max_bytes", max_bytes), ("points", points)):
        if value < 0:
            raise ValueError(f"{name} must be >= 0, not {value!r}")
    scene.commit()
    core = _core.solve(
        scene._core,
        number("tolerance", tolerance),
        choice("norm", norm, _NORMS),
        choice("engine", engine, _ENGINES),
        points,
        channels or 0,
        max_seconds,
        max_bytes,
        threads,
        progress,
    )
    solution = Solution(scene, core)
    solution._warn()
    return solution
