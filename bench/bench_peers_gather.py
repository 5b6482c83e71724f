# SPDX-License-Identifier: MIT
"""Irradiance at points of triangle scenes: lcor's engine gather beside Mitsuba 3 in the same run.

The hall and the furnished room of bench/scenes.c at the 200 points of tests/data/reference, two
threads each. Mitsuba traces paths until its true error is that of lcor; since its error falls with
the root of the paths, its time at lcor's error follows from two measured numbers of paths.
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lcor
import numpy as np
from results import table, write

SOURCE = Path(__file__).parents[1]
BENCH = SOURCE / "build/bench/bench/bench_gather"
THREADS = 2
TOLERANCES = (0.02, 0.01, 0.005)


class Mesh:
    """Triangles, reflectances and lights as `bench_gather --mesh` writes them."""

    def __init__(self, name: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mesh.txt"
            subprocess.run([str(BENCH), "--mesh", name, str(path)], check=True)
            lines = [line.split() for line in path.read_text().splitlines()]
        self.lights = [[float(x) for x in line[1:]] for line in lines if line[0] == "light"]
        rows = np.array([[float(x) for x in line] for line in lines if line[0] != "light"])
        self.rho, self.corners = rows[:, 0], rows[:, 1:].reshape(-1, 3, 3)


class Reference:
    def __init__(self, name: str) -> None:
        path = SOURCE / f"tests/data/reference/gather_{name}.csv"
        with open(path, newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["kind"] == "point"]
        numbers = {key: np.array([float(r[key]) for r in rows]) for key in rows[0] if key != "kind"}
        self.points = np.stack([numbers[key] for key in ("x", "y", "z")], axis=-1)
        self.normals = np.stack([numbers[key] for key in ("nx", "ny", "nz")], axis=-1)
        self.value, self.sigma = numbers["E"], numbers["sigma"]

    def error(self, got: np.ndarray) -> float:
        """Root mean square of the relative error, less the reference's own noise."""
        scale = np.maximum(self.value, 0.02 * self.value.mean())
        square = (((got - self.value) / scale) ** 2).mean() - ((self.sigma / scale) ** 2).mean()
        return float(np.sqrt(max(square, 0.0)))


def run_lcor(mesh: Mesh, truth: Reference, tolerance: float) -> tuple[float, float]:
    """True error, and seconds for solution and points."""
    scene = lcor.Scene()
    for rho, (a, b, c) in zip(mesh.rho, mesh.corners):
        scene.add_triangle(a, b, c, rho, two_sided=True)
    for _, x, y, z, *_, intensity, _, _ in mesh.lights:
        scene.add_point_light((x, y, z), intensity)
    scene.commit()
    start = time.process_time()
    solution = lcor.solve_radiosity(scene, tolerance, engine="gather", threads=THREADS)
    got = solution.at(truth.points, truth.normals)
    seconds = time.process_time() - start
    return truth.error(got), seconds


def mitsuba(mesh: Mesh, truth: Reference) -> Callable[[int], tuple[float, float]]:
    """A call that traces so many paths a point and returns true error and seconds."""
    # Dr.Jit wants an LLVM newer than Debian 12's own: package libllvm19.
    newest = sorted(Path("/usr/lib").glob("*/libLLVM*19*"))
    if newest:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(newest[-1]))
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(THREADS)
    world: dict[str, Any] = {"type": "scene"}
    for index, rho in enumerate(np.unique(mesh.rho)):
        corners = mesh.corners[mesh.rho == rho]
        shape = mi.Mesh(f"rho{index}", 3 * len(corners), len(corners), props=two_sided(mi, rho))
        values = mi.traverse(shape)
        values["vertex_positions"] = corners.astype(np.float32).ravel()
        values["faces"] = np.arange(3 * len(corners), dtype=np.uint32)
        values.update()
        world[f"shape{index}"] = shape
    for index, (_, x, y, z, *_, intensity, _, _) in enumerate(mesh.lights):
        power = {"type": "rgb", "value": intensity}
        world[f"light{index}"] = {"type": "point", "position": [x, y, z], "intensity": power}
    scene = mi.load_dict(world)
    integrator = mi.load_dict({"type": "path", "max_depth": 64, "rr_depth": 4})
    count = len(truth.points)
    points = truth.points + 1e-5 * truth.normals

    def measure(paths: int) -> tuple[float, float]:
        start = time.process_time()
        index = dr.arange(mi.UInt32, count * paths) // paths
        at = dr.gather(mi.Point3f, mi.Point3f(points.T.astype(np.float32)), index)
        normal = dr.gather(mi.Normal3f, mi.Normal3f(truth.normals.T.astype(np.float32)), index)
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(paths, count * paths)
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        ray = mi.Ray3f(at, mi.Frame3f(normal).to_world(local))
        light, _, _ = integrator.sample(scene, sampler, ray)
        sums = dr.zeros(mi.Float, count)
        dr.scatter_reduce(dr.ReduceOp.Add, sums, light[0], index)
        got = np.array(sums) * np.pi / paths + direct(mi, dr, scene, mesh, truth)
        return truth.error(got), time.process_time() - start

    return measure


def two_sided(mi: Any, rho: float) -> Any:
    """Properties of a mesh that reflects on both sides."""
    colour = {"type": "rgb", "value": float(rho)}
    properties = mi.Properties()
    inner = {"type": "diffuse", "reflectance": colour}
    properties["mesh_bsdf"] = mi.load_dict({"type": "twosided", "bsdf": inner})
    return properties


def direct(mi: Any, dr: Any, scene: Any, mesh: Mesh, truth: Reference) -> np.ndarray:
    """Straight light of the lamps at the points, by one shadow ray each."""
    total = np.zeros(len(truth.points))
    start = mi.Point3f((truth.points + 1e-5 * truth.normals).T.astype(np.float32))
    for _, x, y, z, *_, intensity, _, _ in mesh.lights:
        off = np.array([x, y, z]) - truth.points
        distance = np.linalg.norm(off, axis=-1)
        cosine = np.maximum((off * truth.normals).sum(-1) / distance, 0.0)
        to = mi.Vector3f((off / distance[:, None]).T.astype(np.float32))
        ray = mi.Ray3f(start, to, mi.Float((distance * 0.9999).astype(np.float32)), 0.0, [])
        seen = 1.0 - np.array(dr.select(scene.ray_test(ray), mi.Float(1.0), mi.Float(0.0)))
        total += intensity * cosine / distance**2 * seen
    return total


def compare(name: str) -> list[list[Any]]:
    mesh, truth = Mesh(name), Reference(name)
    rows = []
    peer = mitsuba(mesh, truth)
    peer(64)  # compiles the kernels
    for tolerance in TOLERANCES:
        error, seconds = run_lcor(mesh, truth, tolerance)
        paths = 1024
        peer_error, peer_seconds = peer(paths)
        while peer_error > 1.3 * error and peer_seconds < 8 and paths < 2**17:
            paths *= 4
            peer_error, peer_seconds = peer(paths)
        same = peer_seconds * (peer_error / error) ** 2
        rows.append([name, tolerance, error, seconds, peer_error, peer_seconds, same / seconds])
    return rows


def main() -> None:
    rows = []
    for name in ("hall", "room"):
        try:
            rows += compare(name)
        except ImportError as error:
            print(f"left out: {error}", file=sys.stderr)
            return
    write(
        [
            table(
                "Triangle scenes beside Mitsuba 3",
                "200 points by engine gather, solution included, and by Mitsuba's path integrator "
                "with its LLVM variant; scene preparation and compilation left out, two threads "
                "each, processor time of both. The last column is Mitsuba's time at lcor's true "
                "error, taken from its own error by the square root of paths, over lcor's time.",
                [
                    "scene",
                    "tolerance",
                    "lcor rms",
                    "lcor, s",
                    "Mitsuba rms",
                    "Mitsuba, s",
                    "lcor faster",
                ],
                rows,
            )
        ]
    )


if __name__ == "__main__":
    main()
