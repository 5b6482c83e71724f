# SPDX-License-Identifier: MIT
"""Views of scenes: what is seen where, how it is lit and corrected, and what is refused."""

import hashlib
import json
import math
import os
import random

import pytest
from gltf_scene import Scene, png
from lcor_run import good, oiiotool, pixels, refused, report, table

SIZE = (160, 120)
DEVICE = ("--contrast", "23.4")
DRAFT = ("--size", f"{SIZE[0]}x{SIZE[1]}", "--tolerance", "0.05")
BOXES = ("--box", "0.55,0.8,0.5,0.75,0,0.3,0.4", "--box", "0.1,0.3,0.6,0.9,0,0.5,0.6")
CAMERAS = {"side": None, "above": None, "inside": (0.05, 0.1, 0.8, 0.8, 0.9, 0.2, 80)}


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    folder = tmp_path_factory.mktemp("room")
    random.seed(5)
    noise = bytes(random.randrange(256) for _ in range(64 * 64 * 3))
    (folder / "noise.png").write_bytes(png(64, 64, noise))
    camera = "inside=" + ",".join(map(str, CAMERAS["inside"]))
    good("room", "-o", folder / "room.glb", *BOXES, "--camera", camera, "--patches", "10",
         "--texture", f"floor={folder}/noise.png", "--texture", f"y1={folder}/noise.png")
    return folder / "room.glb"


def panel(tmp_path, rgb, tilt=0.0):
    """One unit quad of one colour under a near lamp, seen by a camera that sees more than it."""
    scene = Scene()
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, tilt), (0, 1, tilt)]
    scene.node(mesh=scene.quad(corners, material=scene.material(rgb)))
    scene.light({"type": "point", "intensity": 8.0}, translation=[0.1, 0.1, 0.4])
    path = tmp_path / "panel.glb"
    path.write_bytes(scene.glb())
    return path


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return tuple(x / math.sqrt(dot(a, a)) for x in a)


class Caster:
    """Tries every parallelogram for every ray. Their shapes come from centres of 2 x 2 patches."""

    def __init__(self, scene, folder):
        good("irradiance", scene, "--patches", folder / "p.csv", "--patches", "2",
             "--tolerance", "0.5")
        self.faces = {}
        rows = table(folder / "p.csv")
        for i in range(0, len(rows), 4):
            p = [tuple(row[k] for k in ("x", "y", "z")) for row in rows[i : i + 3]]
            u, v = (tuple(2 * (a - b) for a, b in zip(p[k], p[0])) for k in (2, 1))
            origin = tuple(p[0][k] - 0.25 * (u[k] + v[k]) for k in range(3))
            self.faces[int(rows[i]["surface"])] = (origin, u, v, cross(u, v))

    def hits(self, eye, ray):
        """(t, surface, u, v) of faces seen from the front, nearest first."""
        found = []
        for surface, (origin, u, v, normal) in self.faces.items():
            facing = dot(ray, normal)
            if facing >= 0:
                continue
            t = dot(minus(origin, eye), normal) / facing
            x = tuple(e + t * r for e, r in zip(eye, ray))
            w = minus(x, origin)
            n2 = dot(normal, normal)
            s, r = dot(cross(w, v), normal) / n2, dot(cross(u, w), normal) / n2
            if t > 0 and 0 <= s <= 1 and 0 <= r <= 1:
                found.append((t, surface, s, r))
        return sorted(found)


def camera_of(name):
    if name == "side":
        return (0.5, -1.25, 0.5), (0, 1, 0), (0, 0, 1), 0.58
    if name == "above":
        return (0.5, 0.5, 2.25), (0, 0, -1), (0, 1, 0), 0.58
    n = CAMERAS[name]
    return n[:3], unit(minus(n[3:6], n[:3])), (0, 0, 1), math.radians(n[6])


@pytest.mark.parametrize("name", list(CAMERAS))
def test_depth_place_and_surface_agree_with_an_independent_ray_caster(room, tmp_path, name):
    good("render", room, "-o", tmp_path / "v.png", "--camera", name, *DRAFT, *DEVICE,
         *(f"--aov={k}={tmp_path}/{k}.exr" for k in ("depth", "uv", "surface")))
    depth, uv, surface = (pixels(tmp_path / f"{k}.exr") for k in ("depth", "uv", "surface"))
    caster = Caster(room, tmp_path)
    eye, forward, up, angle = camera_of(name)
    right = unit(cross(forward, up))
    down = cross(forward, right)
    random.seed(name)
    step = 2 * math.tan(angle / 2) / SIZE[1]

    def seen(x, y):
        return caster.hits(eye, tuple(
            f + (x - SIZE[0] / 2) * step * r + (y - SIZE[1] / 2) * step * d
            for f, r, d in zip(forward, right, down)))

    compared = edges = 0
    for _ in range(3500):
        x, y = random.randrange(SIZE[0]), random.randrange(SIZE[1])
        i = y * SIZE[0] + x
        corners = [seen(x + a, y + b)[:1] for a in (0, 1) for b in (0, 1)]
        hits = seen(x + 0.5, y + 0.5)[:1]
        if any([h[1] for h in hits] != [h[1] for h in corner] for corner in corners):
            edges += 1  # several surfaces meet here: the pixel is the largest piece's
            continue
        compared += 1
        if not hits:
            assert surface[i][0] == -1
            continue
        t, face, u, v = hits[0]
        assert surface[i][0] == face
        assert depth[i][0] == pytest.approx(t, rel=1e-5)
        assert uv[i] == pytest.approx((u, v), abs=2e-6)
    assert compared > 3200 and compared + edges == 3500


def test_no_seam_of_elements_crosses_a_wall(tmp_path):
    """At 1 % rms the halves of the back wall may differ by 3 % where they meet: seen at once."""
    width, height = 480, 270
    good("room", "-o", tmp_path / "room.glb", "--light", "0.5,0.45,0.6,100")
    found = report("render", tmp_path / "room.glb", "-o", tmp_path / "a.png", *DEVICE,
                   "--size", f"{width}x{height}", "--aov", f"indirect={tmp_path}/i.exr")
    assert found["radiosity"]["engine"] == "links"
    indirect = pixels(tmp_path / "i.exr")
    columns, rows = range(150, 330), range(40, 230)  # of the back wall, without its edges
    at = [y * width + x for y in rows for x in columns]
    steps = [abs(indirect[i][0] / indirect[i - 1][0] - 1) for i in at]
    assert max(steps) < 0.012


def test_the_number_of_threads_changes_no_byte(room, tmp_path):
    files = []
    for threads in (1, 2, 3):
        files.append(tmp_path / f"{threads}.png")
        good("render", room, "-o", files[-1], *DRAFT, *DEVICE, "--threads", threads)
    assert len({file.read_bytes() for file in files}) == 1


def test_views_share_one_adaptation_by_file(room, tmp_path):
    shared = tmp_path / "adaptation.txt"
    first = report("render", room, "-o", tmp_path / "a.png", "--camera", "side", *DRAFT, *DEVICE,
                   "--adaptation", shared)
    assert f"r_mean {first['r_mean']!r}" in shared.read_text()
    second = report("render", room, "-o", tmp_path / "b.png", "--camera", "above", *DRAFT, *DEVICE,
                    "--adaptation", shared)
    alone = report("render", room, "-o", tmp_path / "b.png", "--camera", "above", *DRAFT, *DEVICE)
    assert second["r_mean"] == first["r_mean"] != alone["r_mean"]
    shared.write_text("bright\n")
    refused(3, "render", room, "-o", tmp_path / "b.png", *DEVICE, "--adaptation", shared,
            says="r_mean")


def test_the_mean_is_that_of_the_displayed_pixels(room, tmp_path):
    found = report("render", room, "-o", tmp_path / "a.png", "--mean", "literal", *DRAFT, *DEVICE,
                   "--aov", f"r={tmp_path}/r.exr", "--aov", f"alpha={tmp_path}/alpha.exr")
    values, weights = pixels(tmp_path / "r.exr"), pixels(tmp_path / "alpha.exr")
    logs = sum(w[0] * math.log(r[0]) for r, w in zip(values, weights) if w[0] > 0)
    mean = math.exp(logs / sum(w[0] for w in weights))
    # pixels at edges show the mean of two r, where the true mean takes both: some 0.2 %
    assert found["r_mean"] == pytest.approx(mean, rel=5e-3)


def test_the_gaze_and_all_surfaces_give_other_means(room, tmp_path):
    def mean(*options):
        return report("render", room, "-o", tmp_path / "a.png", *DRAFT, *DEVICE, *options)["r_mean"]

    bright, dark = mean("--gaze", "0.45,0.05,8"), mean("--gaze", "0.75,0.8,8")
    assert bright > 1.5 * dark
    assert mean("--mean-over", "surfaces") != mean()
    assert mean("--mean", "2.5") == 2.5
    refused(2, "render", room, "-o", tmp_path / "a.png", *DEVICE, "--gaze", "2,0,5", says="--gaze")


def linear(stored):
    return stored / 12.92 if stored <= 0.04045 else ((stored + 0.055) / 1.055) ** 2.4


def test_display_luminance_follows_illuminance_and_eq_19_saturates(tmp_path):
    path = panel(tmp_path, (0.6, 0.15, 0.3))
    aovs = [f"--aov={k}={tmp_path}/{k}.exr" for k in ("illuminance", "H", "clip", "alpha")]
    found = report("render", path, "-o", tmp_path / "a.exr", *DRAFT, *DEVICE, *aovs)
    lux, h, clip, alpha = (pixels(tmp_path / f"{k}.exr")
                           for k in ("illuminance", "H", "clip", "alpha"))
    mean_lux = found["r_mean"] / report("info", path)["mean_reflectance"]
    shown = [i for i in range(len(lux)) if alpha[i][0] == 1 and clip[i][0] == 0]
    assert len(shown) > 1000
    for i in shown:  # eq 9: H = (r / r_mean) (Jmax + Jmin) / 2
        assert h[i][0] == pytest.approx(lux[i][0] / mean_lux * (1 + 1 / 23.4) / 2, rel=2e-3)
    good("render", path, "-o", tmp_path / "c.exr", *DRAFT, *DEVICE, "--conventional")
    conventional = pixels(tmp_path / "c.exr")
    saturated = 0
    for i in shown:
        q = lux[i][0] / mean_lux
        for c, texel in enumerate((0.6, 0.15, 0.3)):
            assert conventional[i][c] == pytest.approx(min(q * texel, 1), rel=2e-3)
        saturated += q * 0.6 > 1
    assert saturated > 20


def test_pixels_without_a_surface_are_transparent_where_the_format_can(tmp_path):
    path = panel(tmp_path, (0.5, 0.5, 0.5))
    for name, channels in (("a.png", 4), ("a.tif", 4), ("a.exr", 4), ("a.jpg", 3)):
        good("render", path, "-o", tmp_path / name, *DRAFT, *DEVICE)
        found = pixels(tmp_path / name)
        assert len(found[0]) == channels
        middle = found[SIZE[1] // 2 * SIZE[0] + SIZE[0] // 2]
        if channels == 4:
            assert found[0][3] == 0 and middle[3] > 0
            assert 0 < len([p for p in found if 0 < p[3] < (1 if name == "a.exr" else 255)]) < 700
        else:
            assert max(found[0]) <= 4


def test_bits_and_formats(room, tmp_path):
    for name, bits, kind in (("a.png", 16, "uint16"), ("a.tif", 16, "uint16"),
                             ("a.tif", 32, "float"),
                             ("a.exr", None, "float"), ("a.jpg", None, "uint8")):
        options = () if bits is None else ("--bits", bits)
        good("render", room, "-o", tmp_path / name, *DRAFT, *DEVICE, *options)
        assert kind in oiiotool("--info", "-v", tmp_path / name)
    refused(2, "render", room, "-o", tmp_path / "a.jpg", *DEVICE, "--bits", "16", says="16 bits")


def test_provenance_and_false_colour(room, tmp_path):
    good("render", room, "-o", tmp_path / "a.png", *DRAFT, *DEVICE,
         "--aov", f"false-colour={tmp_path}/f.png")
    info = json.loads(oiiotool("--info", "-v", "--metamatch", "ImageDescription",
                               tmp_path / "a.png")
                      .split("ImageDescription: ")[1].strip().strip('"').encode()
                      .decode("unicode_escape"))
    assert info["command"].startswith("lcor render") and info["contrast"] == 23.4
    assert list(info["inputs"].values()) == [
        "sha256:" + hashlib.sha256(room.read_bytes()).hexdigest()]
    width, height = map(int, oiiotool("--info", tmp_path / "f.png").split(":")[1].split(",")[0]
                        .split("x"))
    assert width > SIZE[0] and height == SIZE[1]
    legend = [p for i, p in enumerate(pixels(tmp_path / "f.png")) if i % width >= SIZE[0]]
    assert legend.count((0, 0, 0)) > 50  # ink of the labels
    assert len(set(legend)) > 40  # the scale's colours


def test_a_lamp_that_emits_is_seen_bright(tmp_path):
    scene = Scene()
    black = scene.material((0.0, 0.0, 0.0), emissiveFactor=[1, 1, 1], doubleSided=True)
    scene.node(mesh=scene.quad([(0.4, 0.4, 0.01), (0.6, 0.4, 0.01),
                                (0.6, 0.6, 0.01), (0.4, 0.6, 0.01)],
                               material=black))
    scene.node(mesh=scene.quad([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
                               material=scene.material((0.3, 0.3, 0.3))))
    scene.light({"type": "point", "intensity": 0.2}, translation=[0.2, 0.2, 1.0])
    (tmp_path / "s.glb").write_bytes(scene.glb())
    good("render", tmp_path / "s.glb", "-o", tmp_path / "a.exr", *DRAFT, *DEVICE,
         "--aov", f"surface={tmp_path}/i.exr")
    seen, shown = pixels(tmp_path / "i.exr"), pixels(tmp_path / "a.exr")
    lamp = [p for p, s in zip(shown, seen) if s[0] == 0 and p[3] == 1]
    wall = [p for p, s in zip(shown, seen) if s[0] == 1 and p[3] == 1]
    assert lamp and min(p[1] for p in lamp) > 0.999
    assert sorted(p[1] for p in wall)[len(wall) // 2] < 0.9


def test_refusals_leave_what_stood_at_the_output(room, tmp_path):
    out = tmp_path / "a.png"
    out.write_text("old")
    for arguments, says in (
        (("--camera", "nowhere"), "side, above"),
        (("--size", "100"), "WIDTHxHEIGHT"),
        (("--aov", "colour=x.exr"), "--aov list"),
        (("--aov", f"depth={tmp_path}/d.png"), "floats"),
        (("--mean-over", "surfaces", "--gaze", "0,0,1"), "--gaze"),
    ):
        refused(2, "render", room, "-o", out, *DEVICE, *arguments, says=says)
    refused(2, "render", room, "-o", out, says="--contrast")
    refused(2, "render", room, *DEVICE, says="-o")
    refused(3, "render", tmp_path / "none.glb", "-o", out, *DEVICE, says="none.glb")
    refused(7, "render", room, "-o", out, "--profile", tmp_path / "none.cgats", says="none.cgats")
    assert out.read_text() == "old"


def test_every_auxiliary_picture_has_its_line_in_the_list_and_is_written(room, tmp_path):
    lines = good("render", "--aov", "list").stdout.splitlines()
    names = [line.split()[0] for line in lines]
    assert {"illuminance", "r", "beta", "k", "H", "depth", "uv", "surface"} <= set(names)
    wanted = [f"--aov={n}={tmp_path}/{n}.{'png' if n == 'false-colour' else 'exr'}" for n in names]
    good("render", room, "-o", tmp_path / "a.png", "--size", "40x30", *DEVICE, *wanted)
    assert len(list(tmp_path.glob("*.exr"))) == len(names) - 1


def test_what_cannot_be_written_is_refused_before_the_scene_is_read(tmp_path):
    scene, picture = tmp_path / "no.glb", tmp_path / "a.png"
    missing = tmp_path / "none" / "a.exr"
    refused(2, "render", scene, "-o", tmp_path / "a.xyz", *DEVICE, says="picture format")
    refused(1, "render", scene, "-o", missing, *DEVICE, says=f"{missing}")
    refused(1, "render", scene, "-o", picture, *DEVICE, "--aov", f"illuminance={missing}",
            says=f"{missing}")
    refused(1, "render", scene, "-o", picture, *DEVICE, "--adaptation", missing, says=f"{missing}")
    table = tmp_path / "e.csv"
    for paths in (("--patches", missing), ("--patches", table, "--report", missing)):
        refused(1, "irradiance", scene, *paths, says=f"{missing}")
    assert list(tmp_path.iterdir()) == []


def test_the_conventional_method_needs_no_device(room, tmp_path):
    for name, device in (("a.tif", ()), ("b.tif", DEVICE)):
        found = report("render", room, "-o", tmp_path / name, "--conventional", *DRAFT, *device)
        assert found["contrast"] == (23.4 if device else None)
        assert found["radiosity"]["channels_reason"] == "all lights have one colour"
    assert pixels(tmp_path / "a.tif") == pixels(tmp_path / "b.tif")


def test_a_picture_larger_than_memory_is_refused_before_the_scene_is_solved(room, tmp_path):
    if os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE") > 50e9:
        pytest.skip("this machine has the memory")
    refused(3, "render", room, "-o", tmp_path / "a.png", *DEVICE, "--size", "65535x65535",
            says="smaller --size")
