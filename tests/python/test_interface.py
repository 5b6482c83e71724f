# SPDX-License-Identifier: MIT
"""The calls people's scripts rely on: names, order and defaults of their parameters."""

import inspect

import lcor
import pytest

CALLS = {
    "rgb_to_lab": "rgb, space='ntsc', lightness='cie', *, transfer='linear', out=None",
    "lab_to_rgb": "lab, space='ntsc', lightness='cie', *, transfer='linear', out=None",
    "contrast_from_density": "d_max, d_min",
    "adapt": "j, j_mean, j_min, j_max, exponent=1.0",
    "geometric_mean": "r, weights=None, method='adaptive'",
    "Plan": "contrast, r_mean, rho=0.5, reading='patch', exponent=1.0, gamut='keep-hue', "
    "space='ntsc', transfer='linear', lightness='cie', *, rho_ratio=1.0, tone_curve=None",
    "Plan.apply": "self, rgb, illuminance, rho=None, out=None",
    "correct": "texture, illuminance, contrast, *, rho=0.5, reading='patch', exponent=1.0, "
    "gamut='keep-hue', space='ntsc', transfer='linear', lightness='cie', rho_ratio=1.0, "
    "tone_curve=None, r_mean=None, method='adaptive', weights=None, out=None",
    "conventional": "texture, illuminance, rho=1.0, *, space='ntsc', transfer='linear', out=None",
    "Scene.add_quad": "self, origin, edge_u, edge_v, reflectance=0.5, emission=0.0, "
    "patches=(1, 1), two_sided=False",
    "Scene.add_triangle": "self, a, b, c, reflectance=0.5, emission=0.0, patches=1, "
    "two_sided=False",
    "Scene.add_point_light": "self, position, intensity=1.0, range=0.0",
    "solve_radiosity": "scene, tolerance=0.01, norm='rms', *, engine='auto', points=0, "
    "channels=None, max_seconds=0.0, max_bytes=0, threads=1, progress=None",
    "Solution.irradiance": "self, surface, kind='average'",
    "Solution.direct": "self, surface, kind='average'",
    "Solution.at": "self, points, normals",
    "Profile.load": "path, black='full'",
    "Profile.save": "self, path",
}


@pytest.mark.parametrize("name", CALLS)
def test_parameters_keep_their_names_order_and_defaults(name):
    call = lcor
    for part in name.split("."):
        call = getattr(call, part)
    signature = inspect.signature(call)
    bare = [p.replace(annotation=p.empty) for p in signature.parameters.values()]
    assert str(inspect.Signature(bare)) == f"({CALLS[name]})"


def test_the_report_has_its_keys():
    scene = lcor.Scene()
    surface = scene.add_quad((0, 0, 0), (1, 0, 0), (0, 1, 0), patches=(2, 3))
    scene.add_point_light((0.5, 0.5, 1.0))
    solution = lcor.solve_radiosity(scene, tolerance=1e-2, norm="rms")
    keys = "error_rms error_max energy_defect converged iterations links bytes seconds models"
    assert set(keys.split()) <= set(solution.report)
    assert solution.irradiance(surface).shape == (2, 3)
