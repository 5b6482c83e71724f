# SPDX-License-Identifier: MIT
"""Irradiance of the paper's room: lcor's tolerances, beside Mitsuba 3 and Radiance in the same run.

The room of Table 3 with 2500 patches a face and its reference solution, tests/data/reference.
"""

from __future__ import annotations

import csv
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import lcor
import numpy as np
from results import best, table, write

FACES = {  # origin, edge_u, edge_v as the reference counts i and j, inward normal, reflectance
    "floor": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), 0.3),
    "ceiling": ((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, -1), 0.8),
    "x0": ((0, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0), 0.5),
    "x1": ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), 0.5),
    "y0": ((0, 0, 0), (1, 0, 0), (0, 0, 1), (0, 1, 0), 0.5),
    "y1": ((0, 1, 0), (1, 0, 0), (0, 0, 1), (0, -1, 0), 0.5),
}
LIGHT = (0.3, 0.4, 0.7)
N = 50


def reference() -> dict[str, dict[str, np.ndarray]]:
    """Average and centre irradiance of each face, [i, j]."""
    path = Path(__file__).parents[1] / "tests/data/reference/paper_room_50x50.csv"
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {
        face: {
            key: np.array([float(r[key]) for r in rows if r["face"] == face]).reshape(N, N)
            for key in ("E_avg", "E_centre")
        }
        for face in FACES
    }


def errors(got: dict[str, np.ndarray], key: str, truth: dict) -> tuple[float, float]:
    """rms and largest relative error over all patches."""
    off = np.concatenate([(got[f] / truth[f][key] - 1).ravel() for f in FACES])
    return float(np.sqrt((off**2).mean())), float(np.abs(off).max())


def centres() -> tuple[np.ndarray, np.ndarray]:
    """Patch centres and normals of all faces, in their order."""
    t = (np.arange(N) + 0.5) / N
    u, v = np.meshgrid(t, t, indexing="ij")
    points, normals = [], []
    for origin, edge_u, edge_v, normal, _ in FACES.values():
        at = np.array(origin) + u[..., None] * np.array(edge_u) + v[..., None] * np.array(edge_v)
        points.append(at.reshape(-1, 3))
        normals.append(np.tile(np.array(normal, float), (N * N, 1)))
    return np.concatenate(points), np.concatenate(normals)


def by_face(values: np.ndarray) -> dict[str, np.ndarray]:
    return dict(zip(FACES, values.reshape(len(FACES), N, N)))


def own_scene() -> lcor.Scene:
    scene = lcor.Scene()
    for origin, u, v, normal, rho in FACES.values():
        if np.dot(np.cross(u, v), normal) < 0:  # face inwards: swap the edges
            u, v = v, u
        scene.add_quad(origin, u, v, rho, patches=(N, N))
    scene.add_point_light(LIGHT, 1.0)
    return scene


def own_values(scene: lcor.Scene, tolerance: float) -> tuple[dict[str, np.ndarray], dict]:
    solution = lcor.solve_radiosity(scene, tolerance)
    got = {}
    for index, (face, (_, u, v, normal, _)) in enumerate(FACES.items()):
        values = solution.irradiance(index)
        got[face] = values.T if np.dot(np.cross(u, v), normal) < 0 else values
    return got, solution.report


def run_lcor(truth: dict) -> list[list]:
    rows = []
    scene = own_scene()
    for tolerance in (0.1, 0.03, 0.01, 0.003, 0.001):
        got, report = own_values(scene, tolerance)
        rms, largest = errors(got, "E_avg", truth)
        solve = best(lambda t=tolerance: lcor.solve_radiosity(scene, t), 3)
        whole = best(lambda t=tolerance: own_values(scene, t), 2)
        rows.append(
            [tolerance, rms, report["error_rms"], largest, solve, whole, report["bytes"] / 1e6]
        )
    return rows


def run_mitsuba(truth: dict) -> list[list]:
    import mitsuba as mi

    rows = []
    for variant, paths in (("scalar_rgb", (16, 64)), ("llvm_ad_rgb", (64, 1024))):
        try:
            mi.set_variant(variant)
            irradiance = mitsuba_room()
            irradiance(1)  # compiles its kernel
        except (ImportError, RuntimeError) as error:
            print(f"left out: Mitsuba's {variant}: {error}")
            continue
        for spp in paths:
            start = time.process_time()
            got = irradiance(spp)
            seconds = time.process_time() - start
            name = f"Mitsuba {mi.__version__} {variant.split('_')[0]}, {spp} paths"
            rows.append([name, *errors(got, "E_avg", truth), seconds])
    return rows


def mitsuba_room() -> Callable[[int], dict[str, np.ndarray]]:
    """The room in the variant that is set: paths a patch -> irradiance of each face."""
    import mitsuba as mi

    to_world = mi.ScalarTransform4f
    scene: dict = {"type": "scene"}
    cameras = {}
    for face, (origin, u, v, normal, rho) in FACES.items():
        corner, u, v, normal = (np.array(x, float) for x in (origin, u, v, normal))
        middle = corner + (u + v) / 2
        scene[face] = {
            "type": "rectangle",
            "to_world": to_world().look_at(origin=middle, target=middle + normal, up=v)
            @ to_world().scale(0.5),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": rho}},
        }
        camera = {
            "type": "orthographic",
            "near_clip": 1e-4,
            "to_world": to_world().look_at(origin=middle + 0.01 * normal, target=middle, up=v)
            @ to_world().scale([0.5, 0.5, 1]),
            "film": {"type": "hdrfilm", "width": N, "height": N, "rfilter": {"type": "box"}},
        }
        cameras[face] = mi.load_dict(camera)
    intensity = {"type": "rgb", "value": 1.0}
    scene["light"] = {"type": "point", "position": list(LIGHT), "intensity": intensity}
    scene["integrator"] = {"type": "path", "max_depth": 64, "rr_depth": 8}
    world = mi.load_dict(scene)

    def place(face: str, x: float, y: float) -> np.ndarray:
        """Where on the face, along u and v, a place of its picture lies."""
        ray, _ = cameras[face].sample_ray(0.0, 0.0, mi.Point2f(x, y), mi.Point2f(0.5))
        origin, u, v, *_ = (np.array(a, float) for a in FACES[face])
        off = np.array(ray.o, float).ravel() - origin
        return np.array([off @ u, off @ v])

    def irradiance(spp: int) -> dict[str, np.ndarray]:
        got = {}
        for seed, (face, (*_, rho)) in enumerate(FACES.items()):
            image = np.array(mi.render(world, sensor=cameras[face], spp=spp, seed=seed))[..., 0]
            corner, right, down = (place(face, *at) for at in ((0, 0), (1, 0), (0, 1)))
            if abs((right - corner)[0]) > 0.5:  # columns run along u
                image = image.T
                right, down = down, right
            # rows of `image` now run along u, from `corner` to `down`
            image = image[::-1] if (down - corner)[0] < 0 else image
            image = image[:, ::-1] if (right - corner)[1] < 0 else image
            got[face] = image * np.pi / rho  # a diffuse surface: L = rho E / pi
        return got

    return irradiance


def run_radiance(truth: dict) -> list[list]:
    import pyradiance

    radius = 0.002
    lines = [f"void light lamp 0 0 3 {' '.join([str(1 / (np.pi * radius**2))] * 3)}"]
    lines.append(f"lamp sphere bulb 0 0 4 {' '.join(map(str, LIGHT))} {radius}")
    for face, (origin, u, v, normal, rho) in FACES.items():
        corner, u, v = (np.array(x, float) for x in (origin, u, v))
        if np.dot(np.cross(u, v), normal) < 0:
            u, v = v, u
        corners = np.concatenate([corner, corner + u, corner + u + v, corner + v])
        lines.append(f"void plastic m_{face} 0 0 5 {rho} {rho} {rho} 0 0")
        lines.append(f"m_{face} polygon {face} 0 0 12 {' '.join(map(str, corners))}")
    points, normals = centres()
    rays = "\n".join(
        " ".join(map(str, row)) for row in np.hstack([points + 1e-4 * normals, normals])
    )
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "room.rad"
        scene.write_text("\n".join(lines) + "\n")
        octree = Path(folder) / "room.oct"
        octree.write_bytes(pyradiance.oconv(str(scene)))
        for name, ambient in {
            "3 bounces": "-ab 3 -ad 64 -as 16 -aa 0.2 -ar 16",
            "5 bounces": "-ab 5 -ad 256 -as 64 -aa 0.15 -ar 32",
        }.items():
            start = sum(os.times()[:4])
            out = pyradiance.rtrace(
                rays.encode(),
                str(octree),
                header=False,
                irradiance=True,
                params=[*ambient.split(), "-dt", "0", "-dc", "1"],
            )
            seconds = sum(os.times()[:4]) - start
            values = np.array(
                [line.split()[:3] for line in out.decode().splitlines() if line.strip()], float
            )
            got = by_face(values[:, 1])
            rows.append([f"Radiance rtrace -I, {name}", *errors(got, "E_centre", truth), seconds])
    return rows


def main() -> None:
    truth = reference()
    own = run_lcor(truth)
    peers = [[f"lcor, tolerance {row[0]:g}", row[1], row[3], row[5]] for row in own]
    for run in (run_mitsuba, run_radiance):
        try:
            peers += run(truth)
        except ImportError as error:
            print(f"left out: {error}")
    columns = [
        "tolerance",
        "true rms",
        "estimated rms",
        "true largest",
        "solve, s",
        "with patches, s",
        "MB",
    ]
    write(
        [
            table(
                "Irradiance of the paper's room: what a tolerance costs",
                "15,000 patch averages against the reference; processor time of the best of "
                "several "
                "runs, one thread. The estimate is the solver's own, the true error is not "
                "known to it.",
                columns,
                own,
            ),
            table(
                "Irradiance of the paper's room beside other programs",
                "All 15,000 patches: averages by lcor and Mitsuba (one orthographic pixel a "
                "patch), "
                "centres by Radiance, each against that column of the reference. Processor time of "
                "all threads, scene preparation left out.",
                ["program", "rms error", "largest error", "seconds"],
                peers,
            ),
        ]
    )


if __name__ == "__main__":
    main()
