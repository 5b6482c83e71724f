# SPDX-License-Identifier: MIT
"""RGB to L*a*b*: speed and error of lcor beside OpenCV, scikit-image, colour-science and lcms2.

All convert linear or stored sRGB with its D65 white, except lcms2, whose L*a*b* is that of the ICC
profile connection space (D50): its error is taken against the same number with its own white.
"""

from __future__ import annotations

import ctypes
import ctypes.util
from collections.abc import Callable
from functools import partial

import lcor
import mpmath
import numpy as np
from results import best, table, write

SIDE, SAMPLE = 1024, 400
mpmath.mp.dps = 40

#: BT.709 to XYZ from its primaries and white, and the same adapted to D50 (Bradford)
D65 = [mpmath.mpf(x) for x in ("0.3127", "0.3290")]
PRIMARIES = [("0.64", "0.33"), ("0.30", "0.60"), ("0.15", "0.06")]


def white_xyz(x: mpmath.mpf, y: mpmath.mpf) -> mpmath.matrix:
    return mpmath.matrix([x / y, 1, (1 - x - y) / y])


def srgb_matrix() -> mpmath.matrix:
    columns = [white_xyz(*(mpmath.mpf(v) for v in xy)) for xy in PRIMARIES]
    m = mpmath.matrix(3, 3)
    for j, column in enumerate(columns):
        for i in range(3):
            m[i, j] = column[i]
    scale = mpmath.lu_solve(m, white_xyz(*D65))
    return m * mpmath.diag(list(scale))


def to_d50(m: mpmath.matrix) -> mpmath.matrix:
    cone = mpmath.matrix(
        [
            ["0.8951", "0.2664", "-0.1614"],
            ["-0.7502", "1.7135", "0.0367"],
            ["0.0389", "-0.0685", "1.0296"],
        ]
    )
    d50 = mpmath.matrix(["0.9642", "1", "0.8249"])
    gain = [a / b for a, b in zip(cone * d50, cone * white_xyz(*D65))]
    return cone**-1 * mpmath.diag(gain) * cone * m


def exact_lab(matrix: mpmath.matrix, rgb: np.ndarray) -> np.ndarray:
    """L*a*b* of linear RGB with 40 digits; white is the image of (1, 1, 1)."""
    white = matrix * mpmath.matrix([1, 1, 1])

    def f(t: mpmath.mpf) -> mpmath.mpf:
        return mpmath.cbrt(t) if t > mpmath.mpf(216) / 24389 else t * 841 / 108 + mpmath.mpf(4) / 29

    rows = []
    for colour in rgb:
        xyz = matrix * mpmath.matrix([mpmath.mpf(float(v)) for v in colour])
        fx, fy, fz = (f(v / w) for v, w in zip(xyz, white))
        rows.append([116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)])
    return np.array(rows, dtype=object)


class Lcms:
    """liblcms2 for linear sRGB to PCS L*a*b*, float32 or float64."""

    def __init__(self, dtype: type) -> None:
        name = ctypes.util.find_library("lcms2")
        if name is None:
            raise ImportError("liblcms2 is not installed (Debian: liblcms2-2)")
        lib = ctypes.CDLL(name)
        for call in (
            "cmsCreateRGBProfile",
            "cmsCreateLab4Profile",
            "cmsCreateTransform",
            "cmsBuildGamma",
        ):
            getattr(lib, call).restype = ctypes.c_void_p
        lib.cmsBuildGamma.argtypes = [ctypes.c_void_p, ctypes.c_double]
        triple = ctypes.c_double * 3
        white = triple(0.3127, 0.3290, 1.0)
        primaries = (ctypes.c_double * 9)(0.64, 0.33, 1, 0.30, 0.60, 1, 0.15, 0.06, 1)
        curve = ctypes.c_void_p(lib.cmsBuildGamma(None, 1.0))
        curves = (ctypes.c_void_p * 3)(curve, curve, curve)
        rgb = ctypes.c_void_p(lib.cmsCreateRGBProfile(white, primaries, curves))
        lab = ctypes.c_void_p(lib.cmsCreateLab4Profile(None))
        size = 0 if dtype == np.float64 else 4  # lcms2 writes eight bytes as none

        def form(space: int) -> ctypes.c_uint32:
            return ctypes.c_uint32(1 << 22 | space << 16 | 3 << 3 | size)

        absolute_free, no_cache = 1, 0x40  # relative colorimetric
        self.transform = ctypes.c_void_p(
            lib.cmsCreateTransform(rgb, form(4), lab, form(10), absolute_free, no_cache)
        )
        self.run = lib.cmsDoTransform

    def __call__(self, rgb: np.ndarray) -> np.ndarray:
        lab = np.empty_like(rgb)
        self.run(
            self.transform,
            ctypes.c_void_p(rgb.ctypes.data),
            ctypes.c_void_p(lab.ctypes.data),
            ctypes.c_uint32(rgb.size // 3),
        )
        return lab


def contestants() -> list[tuple[str, type, str, Callable[[np.ndarray], np.ndarray]]]:
    """Name, type, white, and the conversion of linear sRGB to L*a*b*."""
    own = partial(lcor.rgb_to_lab, space="srgb")
    found = [("lcor", t, "D65", own) for t in (np.float32, np.float64)]
    try:
        import cv2

        cv2.setNumThreads(1)
        found.append(
            (
                "OpenCV " + cv2.__version__,
                np.float32,
                "D65",
                lambda p: cv2.cvtColor(p, cv2.COLOR_LRGB2LAB),
            )
        )
    except ImportError as error:
        print(f"left out: {error}")
    try:
        import skimage
        from skimage.color import xyz2lab
        from skimage.color.colorconv import xyz_from_rgb

        name = "scikit-image " + skimage.__version__
        found.append((name, np.float64, "D65", lambda p: xyz2lab(p @ xyz_from_rgb.T)))
    except ImportError as error:
        print(f"left out: {error}")
    try:
        import colour

        space = colour.RGB_COLOURSPACES["sRGB"]

        def science(p: np.ndarray) -> np.ndarray:
            return colour.XYZ_to_Lab(p @ space.matrix_RGB_to_XYZ.T, space.whitepoint)

        found.append(("colour-science " + colour.__version__, np.float64, "D65", science))
    except ImportError as error:
        print(f"left out: {error}")
    try:
        found += [("lcms2", t, "D50", Lcms(t)) for t in (np.float32, np.float64)]
    except ImportError as error:
        print(f"left out: {error}")
    return found


def main() -> None:
    random = np.random.default_rng(0)
    picture = random.random((SIDE, SIDE, 3))
    sample = np.concatenate([random.random((SAMPLE // 2, 3)), random.random((SAMPLE // 2, 3)) ** 6])
    matrices = {"D65": srgb_matrix()}
    matrices["D50"] = to_d50(matrices["D65"])
    rows = []
    for name, dtype, white, convert in contestants():
        given = sample.astype(dtype)
        error = np.asarray(convert(given[None]), float)[0] - exact_lab(matrices[white], given)
        delta = np.sqrt((error.astype(float) ** 2).sum(axis=1))
        pixels = picture.astype(dtype)
        seconds = best(lambda convert=convert, pixels=pixels: convert(pixels), 4)
        rows.append(
            [name, np.dtype(dtype).name, white, 1e9 * seconds / SIDE**2, delta.max(), delta.mean()]
        )
    note = (
        "One megapixel of linear sRGB in memory, processor time of the best of four runs, one "
        "thread. "
        f"dE: distance from the 40-digit value for {SAMPLE} colours, half of them dark. "
        "Constants of "
        "fewer digits (matrix, white) count as error, since the definition gives more."
    )
    columns = ["library", "type", "white", "ns/pixel", "largest dE", "mean dE"]
    write([table("RGB to L*a*b* beside other libraries", note, columns, rows)])


if __name__ == "__main__":
    main()
