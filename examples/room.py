# SPDX-License-Identifier: MIT
"""The paper's room (Table 3) in Python: solved, seen by two cameras, corrected for one device.

usage: room.py DIR
Both pictures share one adaptation, so that a wall looks the same in both.
"""

import sys
from pathlib import Path

import lcor
import numpy as np
from PIL import Image

CONTRAST = 23.4
FACES = {  # origin, edge_u, edge_v, colour (linear sRGB)
    "floor": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0.45, 0.28, 0.16)),
    "ceiling": ((0, 0, 1), (0, 1, 0), (1, 0, 0), (0.80, 0.80, 0.78)),
    "x0": ((0, 0, 0), (0, 1, 0), (0, 0, 1), (0.62, 0.20, 0.18)),
    "x1": ((1, 0, 0), (0, 0, 1), (0, 1, 0), (0.20, 0.45, 0.25)),
    "y0": ((0, 0, 0), (0, 0, 1), (1, 0, 0), (0.55, 0.55, 0.52)),
    "y1": ((0, 1, 0), (1, 0, 0), (0, 0, 1), (0.55, 0.55, 0.52)),
}
CAMERAS = {
    "side": lcor.Camera.look((0.5, -0.65, 0.5), at=(0.5, 0.5, 0.48), size=(320, 240)),
    "above": lcor.Camera.look((0.5, 0.45, 1.65), at=(0.5, 0.5, 0.0), up=(0, 1, 0), size=(320, 240)),
}


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    colours = np.array([colour for *_, colour in FACES.values()])
    rho = colours @ (0.2126, 0.7152, 0.0722)  # reflectance: Y of each face
    scene = lcor.Scene()
    for (origin, u, v, _), reflectance in zip(FACES.values(), rho):
        scene.add_quad(origin, u, v, reflectance, patches=(50, 50))
    scene.add_point_light((0.45, 0.4, 0.6), intensity=100.0)  # candela, so metres give lux
    solution = lcor.solve_radiosity(scene, tolerance=0.005)

    views = {name: lcor.View(scene, camera, cull_back=True) for name, camera in CAMERAS.items()}
    light = {name: view.irradiance(solution) for name, view in views.items()}
    adaptation = lcor.Mean()
    for name, view in views.items():
        adaptation.add(light[name] * rho[view.surface], view.coverage)
    plan = lcor.Plan(CONTRAST, adaptation.get(), space="srgb", transfer="linear")

    for name, view in views.items():
        pixels, stats = plan.apply(colours[view.surface], light[name], rho[view.surface])
        linear = view.image(pixels)  # edges are averaged in linear light
        picture = lcor.lab_to_rgb(lcor.rgb_to_lab(linear, "srgb"), "srgb", transfer="srgb")
        path = folder / f"{name}.png"
        Image.fromarray(np.uint8(np.round(255 * np.clip(picture, 0, 1)))).save(path)
        shown = 100 * (1 - (stats.clipped_low + stats.clipped_high) / stats.pixels)
        print(f"{path}: {light[name].min():.0f} to {light[name].max():.0f} lx, {shown:.1f} % shown")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
