# SPDX-License-Identifier: MIT
"""Scenes of planar diffuse surfaces and lights without area."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, Union

from numpy.typing import NDArray

from . import _core
from ._names import channels, grid, item, side, triple

#: Three numbers: a tuple, a list or an array.
Vector = Iterable[float]
#: One number for all channels of light, or three.
Channels = Union[float, Iterable[float]]


class Hit(NamedTuple):
    """Where a ray meets a surface."""

    surface: int
    #: distance in lengths of the direction
    t: float
    #: along the surface's edges, 0..1 on a quad
    u: float
    v: float
    #: the facing side was hit
    front: bool


class Patches(NamedTuple):
    """Patches of a surface; the leading dimensions are those of its irradiance."""

    #: (..., 3), scene units
    centres: NDArray[Any]
    #: (...), scene units squared
    areas: NDArray[Any]
    #: unit normal of the facing side
    normal: tuple[float, float, float]


class Scene:
    """Surfaces and lights; build it, then hand it to :func:`lcor.solve_radiosity`.

    Lengths are in scene units; with metres and candela, irradiance comes out in lux. A surface
    reflects on its facing side and blocks light from both, unless it is `two_sided`.

    Examples
    --------
    >>> import lcor
    >>> scene = lcor.Scene()
    >>> floor = scene.add_quad((0, 0, 0), (1, 0, 0), (0, 1, 0), reflectance=0.3, patches=(4, 4))
    >>> scene.add_point_light((0.5, 0.5, 1.0), intensity=10.0)
    0
    >>> scene.intersect((0.5, 0.5, 2.0), (0, 0, -1)).t
    2.0
    """

    def __init__(self) -> None:
        self._core = _core.Scene()
        self._grids: list[tuple[int, int]] = []
        self._shapes: list[tuple[int, ...]] = []

    def add_quad(
        self,
        origin: Vector,
        edge_u: Vector,
        edge_v: Vector,
        reflectance: Channels = 0.5,
        emission: Channels = 0.0,
        patches: int | Sequence[int] = (1, 1),
        two_sided: bool = False,
    ) -> int:
        """Add the parallelogram origin + s edge_u + t edge_v, facing edge_u x edge_v.

        Parameters
        ----------
        origin, edge_u, edge_v
            Three numbers each, scene units.
        reflectance
            rho [1], 0 <= rho < 1; a number or three.
        emission
            Emitted flux per area (exitance) >= 0; a number or three.
        patches
            Grid along u and v for results, 1..100000 each, or one number for both; it does not
            steer accuracy.
        two_sided
            Reflects and emits on both sides.

        Returns
        -------
        int
            The surface's number, from 0.

        Raises
        ------
        ValueError
            Not three numbers, or a patch count below 1. Shapes and ranges are judged by
            :meth:`commit`. The scene cannot grow once it is committed.
        """
        nu, nv = grid(patches)
        id_ = self._core.add_quad(
            triple("origin", origin),
            triple("edge_u", edge_u),
            triple("edge_v", edge_v),
            channels("reflectance", reflectance),
            channels("emission", emission),
            nu,
            nv,
            two_sided,
        )
        self._grids.append((nu, nv))
        self._shapes.append((nu, nv))
        return id_

    def add_triangle(
        self,
        a: Vector,
        b: Vector,
        c: Vector,
        reflectance: Channels = 0.5,
        emission: Channels = 0.0,
        patches: int = 1,
        two_sided: bool = False,
    ) -> int:
        """Add a triangle facing (b-a) x (c-a), with `patches` times `patches` patches in a row.

        Other parameters, result and errors as for :meth:`add_quad`.
        """
        n = side(patches)
        id_ = self._core.add_triangle(
            triple("a", a),
            triple("b", b),
            triple("c", c),
            channels("reflectance", reflectance),
            channels("emission", emission),
            n,
            n,
            two_sided,
        )
        self._grids.append((n, n))
        self._shapes.append((-1,))
        return id_

    def add_polygon(
        self,
        corners: Iterable[Vector],
        reflectance: Channels = 0.5,
        emission: Channels = 0.0,
        patches: int = 1,
        two_sided: bool = False,
    ) -> int:
        """Add a convex planar polygon facing its right-hand normal.

        Its patches are `patches` times `patches` in each triangle of the fan from its first
        corner. Other parameters, result and errors as for :meth:`add_quad`.
        """
        n = side(patches)
        id_ = self._core.add_polygon(
            [triple("corners", corner) for corner in corners],
            channels("reflectance", reflectance),
            channels("emission", emission),
            n,
            n,
            two_sided,
        )
        self._grids.append((n, n))
        self._shapes.append((-1,))
        return id_

    def set_surface(
        self,
        surface: int,
        reflectance: Channels,
        emission: Channels = 0.0,
        two_sided: bool = False,
    ) -> None:
        """Change how a surface meets light, its shape stays; allowed after a solution too.

        Then call :meth:`lcor.Solution.update`. ValueError for a surface that is not there.
        """
        surface = item("surface", surface, self.surface_count)
        nu, nv = self._grids[surface]
        self._core.set_surface(
            surface,
            channels("reflectance", reflectance),
            channels("emission", emission),
            nu,
            nv,
            two_sided,
        )

    def add_point_light(
        self, position: Vector, intensity: Channels = 1.0, range: float = 0.0
    ) -> int:
        """Add a light that shines alike in every direction.

        Parameters
        ----------
        position
            Three numbers, scene units.
        intensity
            Flux per steradian >= 0 (candela); a number or three.
        range
            Distance at which its light ends (KHR_lights_punctual); 0 for never.

        Returns
        -------
        int
            The light's number, from 0.
        """
        return self._core.add_light(self.point_light(position, intensity, range))

    def add_spot_light(
        self,
        position: Vector,
        direction: Vector,
        intensity: Channels = 1.0,
        inner_cone: float = 0.0,
        outer_cone: float = math.pi / 4,
        range: float = 0.0,
    ) -> int:
        """Add a light that fades from its inner to its outer cone (KHR_lights_punctual).

        `direction` is where the light goes; cones are half angles [radians],
        0 <= inner < outer <= pi/2. The rest as for :meth:`add_point_light`.
        """
        return self._core.add_light(
            self.spot_light(position, direction, intensity, inner_cone, outer_cone, range)
        )

    def add_directional_light(self, direction: Vector, illuminance: Channels = 1.0) -> int:
        """Add light from far away; `illuminance` is that of a surface facing it (lux)."""
        return self._core.add_light(self.directional_light(direction, illuminance))

    @staticmethod
    def point_light(position: Vector, intensity: Channels = 1.0, range: float = 0.0) -> _core.Light:
        """A light for :meth:`set_light`; parameters as for :meth:`add_point_light`."""
        return _core.Light.make(
            _core.LightKind.point,
            triple("position", position),
            (0.0, 0.0, 0.0),
            channels("intensity", intensity),
            0.0,
            0.0,
            range,
        )

    @staticmethod
    def spot_light(
        position: Vector,
        direction: Vector,
        intensity: Channels = 1.0,
        inner_cone: float = 0.0,
        outer_cone: float = math.pi / 4,
        range: float = 0.0,
    ) -> _core.Light:
        """A light for :meth:`set_light`; parameters as for :meth:`add_spot_light`."""
        return _core.Light.make(
            _core.LightKind.spot,
            triple("position", position),
            triple("direction", direction),
            channels("intensity", intensity),
            inner_cone,
            outer_cone,
            range,
        )

    @staticmethod
    def directional_light(direction: Vector, illuminance: Channels = 1.0) -> _core.Light:
        """A light for :meth:`set_light`; parameters as for :meth:`add_directional_light`."""
        return _core.Light.make(
            _core.LightKind.directional,
            (0.0, 0.0, 0.0),
            triple("direction", direction),
            channels("illuminance", illuminance),
            0.0,
            0.0,
            0.0,
        )

    def set_light(self, light: int, new: _core.Light) -> None:
        """Replace a light; allowed after a solution too, then call :meth:`lcor.Solution.update`."""
        self._core.set_light(item("light", light, self.light_count), new)

    def commit(self) -> None:
        """Validate everything; done by the first use if you do not.

        Raises
        ------
        ValueError
            Names the first bad item: a number that is not finite, a polygon that is not planar or
            not convex, a surface without area, rho outside 0 <= rho < 1, no surface at all.
        """
        self._core.commit()

    @property
    def surface_count(self) -> int:
        """Number of surfaces."""
        return self._core.surface_count

    @property
    def light_count(self) -> int:
        """Number of lights."""
        return self._core.light_count

    def patches(self, surface: int) -> Patches:
        """Centres, areas and facing normal of a surface's patches, (nu, nv) for a quad.

        Commits the scene. ValueError for a surface that is not there.
        """
        self.commit()
        surface = item("surface", surface, self.surface_count)
        centres, areas, normal = self._core.patches(surface)
        shape = self._shapes[surface]
        return Patches(centres.reshape(*shape, 3), areas.reshape(shape), triple("normal", normal))

    def intersect(self, origin: Vector, direction: Vector, t_max: float = math.inf) -> Hit | None:
        """First hit of a ray, or None. Commits the scene.

        `t_max` is in lengths of `direction`.
        """
        self.commit()
        hit = self._core.intersect(triple("origin", origin), triple("direction", direction), t_max)
        return None if hit is None else Hit(*hit)

    def __reduce__(self) -> Any:
        raise TypeError("a Scene cannot be copied or pickled: build it again where it is needed")

    def __repr__(self) -> str:
        return f"<lcor.Scene of {self.surface_count} surfaces and {self.light_count} lights>"
