# SPDX-License-Identifier: MIT
"""What a camera sees: visible pieces of surfaces, their irradiance, and pictures of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._names import triple
from ._scene import Scene, Vector
from ._solution import Solution


@dataclass(frozen=True)
class Camera:
    """A camera.

    Parameters
    ----------
    position, forward, up
        Three numbers each, scene units; forward and up of any length, not parallel.
    fov_y
        Full vertical angle [radians], 0..pi; 0 for an orthographic view.
    size
        Width and height in pixels, 1..65535.
    height
        Orthographic: height of the picture in scene units.
    z_near, z_far
        Clip distances along forward; 0 for none.

    Examples
    --------
    >>> import lcor
    >>> camera = lcor.Camera.look((0, -3, 1), at=(0, 0, 1), size=(320, 240))
    >>> camera.forward
    (0.0, 3.0, 0.0)
    """

    position: Vector
    forward: Vector
    up: Vector = (0.0, 0.0, 1.0)
    fov_y: float = math.pi / 3
    size: tuple[int, int] = (640, 480)
    height: float = 0.0
    z_near: float = 0.0
    z_far: float = 0.0

    @classmethod
    def look(cls, position: Vector, at: Vector, **options: Any) -> Camera:
        """A camera at a place that looks at another."""
        origin, target = np.asarray(position, float), np.asarray(at, float)
        return cls(triple("position", origin), triple("at", target - origin), **options)


class View:
    """Hidden-surface solution of one picture, as a list of visible pieces.

    A piece is a surface's part of one pixel; a pixel at an edge has several. The arrays have one
    row a piece, pixels in reading order. Two cameras on one solution share its adaptation when
    they are corrected with one ``r_mean``.

    Parameters
    ----------
    scene
        Committed if it was not yet.
    camera
        What to see.
    lines
        Scan lines a pixel row, 1..64: coverage is exact along x, averaged over them along y.
    cull_back
        True: surfaces are seen from their facing side only, as when one looks into a room from
        outside; or one flag for each surface.

    Raises
    ------
    ValueError
        A camera or scene the library refuses.

    Examples
    --------
    >>> import lcor
    >>> scene = lcor.Scene()
    >>> floor = scene.add_quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    >>> light = scene.add_point_light((0, 0, 1))
    >>> camera = lcor.Camera((0, 0, 3), (0, 0, -1), up=(0, 1, 0), size=(8, 6), fov_y=0.5)
    >>> view = lcor.View(scene, camera)
    >>> len(view), set(view.surface.tolist())
    (48, {0})
    >>> light = view.irradiance(lcor.solve_radiosity(scene))
    >>> view.image(light).shape
    (6, 8)
    """

    def __init__(
        self,
        scene: Scene,
        camera: Camera,
        lines: int = 8,
        cull_back: bool | Sequence[bool] = False,
    ) -> None:
        scene.commit()
        flags = [cull_back] * scene.surface_count if isinstance(cull_back, bool) else cull_back
        width, height = camera.size
        self._core = _core.make_view(
            scene._core,
            triple("position", camera.position),
            triple("forward", camera.forward),
            triple("up", camera.up),
            camera.fov_y,
            camera.height,
            camera.z_near,
            camera.z_far,
            width,
            height,
            lines,
            bytes(map(bool, flags)),
        )
        self.size = (width, height)
        pixel, surface, coverage, uv, du, dv, depth = self._core.pieces()
        #: (n,) row of each piece's pixel
        self.y: NDArray[np.intp] = pixel[:, 0].astype(np.intp)
        #: (n,) column
        self.x: NDArray[np.intp] = pixel[:, 1].astype(np.intp)
        #: (n,) number of the surface
        self.surface: NDArray[np.intp] = surface.astype(np.intp)
        #: (n,) part of the pixel, 0..1
        self.coverage: NDArray[np.float32] = coverage
        #: (n, 2) place on the surface along its edges, 0..1 on a quad
        self.uv: NDArray[np.float64] = uv
        #: (n, 2) change of u a pixel along x and y, for texture filtering
        self.du: NDArray[np.float64] = du
        #: (n, 2) change of v
        self.dv: NDArray[np.float64] = dv
        #: (n,) distance along the camera's forward
        self.depth: NDArray[np.float64] = depth

    def __len__(self) -> int:
        return len(self.surface)

    def irradiance(
        self,
        solution: Solution,
        *,
        tolerance: float = 0.0,
        direct: bool = False,
        threads: int = 1,
    ) -> NDArray[np.float64]:
        """Irradiance of every piece: direct light exactly, indirect light interpolated.

        Parameters
        ----------
        solution
            Of this view's scene.
        tolerance
            Interpolation error relative to the irradiance; 0 for 0.001.
        direct
            Only what comes straight from lights without area.
        threads
            Threads to use; the result has the same bits for any number.

        Returns
        -------
        (n,)
            In the unit of the lights; (n, 3) when the solution has three channels.
        """
        return self._core.irradiance(  # type: ignore[no-any-return]
            solution._core, tolerance, direct, threads
        )

    def image(self, values: ArrayLike, background: float = 0.0) -> NDArray[Any]:
        """Picture of one value, or one colour, a piece: weighted by coverage.

        Parameters
        ----------
        values : (n,) or (n, k)
        background
            Where no surface is seen.

        Returns
        -------
        (height, width) or (height, width, k)
            float64.
        """
        values = np.asarray(values, np.float64)
        width, height = self.size
        picture = np.zeros((height * width, *values.shape[1:]))
        weight = self.coverage.astype(np.float64).reshape(-1, *[1] * (values.ndim - 1))
        pixel = self.y * width + self.x
        np.add.at(picture, pixel, (values - background) * weight)
        return (picture + background).reshape(height, width, *values.shape[1:])
