# SPDX-License-Identifier: MIT
"""Wavefront OBJ scenes: the same light as the same scene in glTF, materials, polygons, errors."""

import math
import random
import struct

import pytest
from gltf_scene import QUAD, Scene, png
from lcor_run import good, refused, report, table

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def save(folder, text, materials=""):
    (folder / "s.mtl").write_text(materials)
    (folder / "s.obj").write_text(("mtllib s.mtl\n" if materials else "") + text)
    return folder / "s.obj"


def light_at(folder, scene, points, *options):
    wanted, out = folder / "p.csv", folder / "e.csv"
    wanted.write_text("x,y,z,nx,ny,nz\n" + "".join(f"{','.join(map(str, p))}\n" for p in points))
    good("irradiance", scene, "--points", wanted, "-o", out, *options)
    return table(out)


def test_light_is_that_of_the_same_scene_in_gltf(tmp_path):
    wall = [(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)]
    gltf = Scene()
    for points, rho in ((QUAD, 0.5), (wall, 0.7)):
        gltf.node(mesh=gltf.quad(points, material=gltf.material((rho,) * 3)))
    (tmp_path / "s.glb").write_bytes(gltf.glb())
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in QUAD + wall)
    obj = save(
        tmp_path,
        corners + "o floor\nusemtl half\nf 1 2 3 4\no wall\nusemtl bright one\nf -4 -3 -2 -1\n",
        "newmtl half\nKd 0.5 0.5 0.5\n\nnewmtl bright one\nKd 0.7\nNs 10\nillum 2\n",
    )
    lamp = ("--light", "0.6,0.5,0.9,10")
    points = [(x, 0.5, 0, 0, 0, 1) for x in (0.1, 0.5, 0.9)]
    assert light_at(tmp_path, obj, points, *lamp) == light_at(
        tmp_path, tmp_path / "s.glb", points, *lamp
    )
    info = report("info", obj)
    assert info["surfaces"] == info["parallelograms"] == 2 and info["warnings"] == []


def test_pictures_stand_upright_and_repeat_as_the_file_says(tmp_path):
    """White above, black below: what v = 1/2..1 shows is white."""
    (tmp_path / "white above.png").write_bytes(
        png(8, 8, bytes([255] * 3 * 8 * 4 + [0] * 3 * 8 * 4))
    )

    def mean(options, low, high):
        text = SQUARE.replace("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1", "")
        text += f"vt 0 {low}\nvt 1 {low}\nvt 1 {high}\nvt 0 {high}\nusemtl a\n" + FACE
        obj = save(tmp_path, text, f"newmtl a\nmap_Kd {options} white above.png\n")
        return report("info", obj)["mean_reflectance"]

    assert mean("", 0.5, 1) == pytest.approx(0.98, abs=1e-6)
    assert mean("", 0, 0.5) == pytest.approx(0, abs=1e-6)
    assert mean("", 0, 1) == pytest.approx(0.5, abs=1e-6)
    assert mean("-o 0 0.5", 0, 0.5) == pytest.approx(0.98, abs=1e-6)
    assert mean("-s 1 0.5 1", 1, 2) == pytest.approx(0.98, abs=1e-6)
    assert mean("", 1, 3) == pytest.approx(0.5, abs=1e-6)
    assert mean("-clamp on", 1, 3) == pytest.approx(0.98, abs=1e-6)


def test_emitters_shine(tmp_path):
    """A Lambert emitter of radiance 3 seen from a distance gives L A / d^2."""
    obj = save(
        tmp_path,
        SQUARE + "usemtl lamp\n" + FACE + "v 0 0 100\nv 1 0 100\nv 1 1 100\nusemtl dark\nf 5 7 6\n",
        "newmtl lamp\nKd 0 0 0\nKe 3 3 3\nnewmtl dark\nKd 0 0 0\n",
    )
    assert report("info", obj)["emitters"] == 1
    (row,) = light_at(tmp_path, obj, [(0.66, 0.34, 100, 0, 0, -1)])
    assert row["E_total"] == pytest.approx(3e-4, rel=1e-3)


def star(corners, seed):
    """A polygon with dents, in a plane of its own, and its area."""
    rng = random.Random(seed)
    angles = [2 * math.pi * (k + rng.uniform(0, 0.5)) / corners for k in range(corners)]
    flat = [(r * math.cos(a), r * math.sin(a)) for a in angles for r in [rng.uniform(0.2, 1)]]
    area = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(flat, flat[1:] + flat[:1])) / 2
    u, v = (0.6, 0.0, 0.8), (0.0, 1.0, 0.0)
    return [tuple(x * a + y * b + 3 for a, b in zip(u, v)) for x, y in flat], area


@pytest.mark.parametrize("corners", [5, 9, 40, 200])
def test_dented_polygons_keep_their_area(tmp_path, corners):
    points, area = star(corners, corners)
    text = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points)
    obj = save(tmp_path, text + "f " + " ".join(map(str, range(1, corners + 1))) + "\n")
    info = report("info", obj)
    assert info["area"] == pytest.approx(abs(area), rel=1e-9)
    assert info["triangles"] == corners - 2


def test_a_dart_is_cut_at_its_dent(tmp_path):
    darts = "".join(f"v 0 0 {z}\nv 2 0 {z}\nv 0.5 0.5 {z}\nv 0 2 {z}\n" for z in (0, 1))
    obj = save(tmp_path, darts + "f 1 2 3 4\nf 6 7 8 5\n")
    assert report("info", obj)["area"] == pytest.approx(2 * 1.0)


def test_lines_as_other_programs_write_them(tmp_path):
    text = "\ufeffv 9 9 9\r\n# by hand\r\n"
    text += "v 0 0 0\r\nv\t1 0 0 # corner\r\nv 1 1 \\\r\n 0\r\nv 0 1 0 1.0\r\n"
    obj = tmp_path / "s.OBJ"
    obj.write_bytes((text + "vn 0 0 1\r\ns off\r\ng a b\r\nf 2//1 3//1 \\\r\n4//1 5//1").encode())
    info = report("info", obj)
    assert info["area"] == pytest.approx(1) and info["warnings"] == []
    assert info["mean_reflectance"] == pytest.approx(0.8)


def test_what_is_not_supported_is_named_once(tmp_path):
    obj = save(
        tmp_path,
        SQUARE + "v 0 0 0 1 0 0\nv 0 0 0 1 0 0\nusemtl a\n" + FACE + FACE
        + "usemtl lost\n" + FACE + "l 1 2\nl 2 3\ncurv 0 1 1 2\nspam\n",
        "newmtl a\nd 0.5\nKs 1 1 1\nmap_Bump b.png\nmap_Kd -mm 0 1 gone.png\nmap_Ke gone.png\n",
    )  # fmt: skip
    said = report("info", obj)["warnings"]
    for feature in (
        "transparency",
        "specular",
        "normal and displacement",
        "vertex colours",
        "points and lines",
        "curves",
        "texture options",
        "another kind",
        "'lost'",
        "gone.png",
    ):
        assert sum(feature in line for line in said) == 1, (feature, said)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("f 1 2 9", "vertex 9 of 4"),
        ("f 1 2 -5", "vertex -5 of 4"),
        ("f 1 2 0", "vertex 0 of 4"),
        ("f 1 2", "three corners"),
        ("f 1 2 x", "'x' is no index"),
        ("f 1/9 2/1 3/1", "texture coordinate 9 of 4"),
        ("f 1 2 99999999999999999999", "no index"),
        ("f" + " 1" * 300, "300 corners"),
        ("v 1 2", "three numbers"),
        ("v 1 nan 2", "three numbers"),
    ],
)
def test_errors_name_file_line_and_reason(tmp_path, line, says):
    assert "s.obj', line 9: " in refused(3, "info", save(tmp_path, SQUARE + line), says=says)


def test_nothing_to_draw_is_an_error(tmp_path):
    refused(3, "info", save(tmp_path, ""), says="has no surface")
    refused(3, "info", save(tmp_path, SQUARE), says="has no surface")
    refused(3, "info", tmp_path / "gone.obj", says="gone.obj")
    garbage = tmp_path / "g.obj"
    garbage.write_bytes(struct.pack("<64I", *range(1 << 20, (1 << 20) + 64)))
    refused(3, "info", garbage, says="has no surface")


def test_a_missing_material_file_is_said(tmp_path):
    obj = save(tmp_path, "mtllib not here.mtl\nusemtl a\n" + SQUARE + FACE)
    info = report("info", obj)
    assert any("here.mtl" in line for line in info["warnings"])
    assert info["mean_reflectance"] == pytest.approx(0.8)
    (tmp_path / "not here.mtl").write_text("newmtl a\nKd .25 .25 .25\n")
    info = report("info", obj)
    assert info["warnings"] == [] and info["mean_reflectance"] == pytest.approx(0.25)


def test_renders(tmp_path):
    out = tmp_path / "o.png"
    obj = save(tmp_path, SQUARE + "f 1 2 3 4\n")
    good("render", obj, "--light", "0.5,0.5,1,9", "--contrast", 9, "-o", out, "--size", "32x32")
    assert out.stat().st_size > 100
