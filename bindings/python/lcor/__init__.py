# SPDX-License-Identifier: MIT
"""Lightness correction for photorealistic rendering on devices of limited contrast.

A thin layer over liblcor: numpy arrays in, numpy arrays out, no arithmetic of its own. Names are
loaded when first used, so importing the package takes a few milliseconds.

>>> import lcor
>>> c = lcor.contrast_from_density(1.44, 0.07)
>>> plan = lcor.Plan(contrast=c, r_mean=0.25)
>>> out, stats = plan.apply([0.9, 0.2, 0.6], illuminance=[0.1, 0.5, 2.0])
>>> out.shape, stats.clipped_low
((3, 3), 0)
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._adapt import Mean as Mean
    from ._adapt import adapt as adapt
    from ._adapt import adapt_inverse as adapt_inverse
    from ._adapt import adapt_range as adapt_range
    from ._adapt import contrast_from_density as contrast_from_density
    from ._adapt import contrast_u95 as contrast_u95
    from ._adapt import geometric_mean as geometric_mean
    from ._colour import chroma as chroma
    from ._colour import hue as hue
    from ._colour import lab_to_rgb as lab_to_rgb
    from ._colour import rgb_to_lab as rgb_to_lab
    from ._correct import Plan as Plan
    from ._correct import Stats as Stats
    from ._correct import conventional as conventional
    from ._correct import correct as correct
    from ._correct import picture_mean as picture_mean
    from ._errors import Cancelled as Cancelled
    from ._errors import FormatError as FormatError
    from ._errors import NotConvergedWarning as NotConvergedWarning
    from ._profile import Profile as Profile
    from ._profile import Reading as Reading
    from ._scene import Hit as Hit
    from ._scene import Patches as Patches
    from ._scene import Scene as Scene
    from ._solution import Solution as Solution
    from ._solution import solve_radiosity as solve_radiosity
    from ._version import __version__ as __version__
    from ._view import Camera as Camera
    from ._view import View as View

_HOMES = {
    "_adapt": "Mean adapt adapt_inverse adapt_range contrast_from_density contrast_u95 "
    "geometric_mean",
    "_colour": "chroma hue lab_to_rgb rgb_to_lab",
    "_correct": "Plan Stats conventional correct picture_mean",
    "_errors": "Cancelled FormatError NotConvergedWarning",
    "_profile": "Profile Reading",
    "_scene": "Hit Patches Scene",
    "_solution": "Solution solve_radiosity",
    "_version": "__version__",
    "_view": "Camera View",
}
_HOME = {name: home for home, names in _HOMES.items() for name in names.split()}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'lcor' has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{home}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
