# SPDX-License-Identifier: MIT
"""What lcor makes of glTF scenes: geometry, reflectance, light, and files that are broken."""

import json
import math
import random

import pytest
from gltf_scene import QUAD, QUAD_UV, Scene, png
from lcor_run import DATA, SANITIZED, good, lcor, refused, report, table

CORNELL_BOX = DATA / "scenes/cornell_bevy_orig.glb"


def save(path, scene, binary=True):
    path = path / ("s.glb" if binary else "s.gltf")
    path.write_bytes(scene.glb() if binary else scene.gltf())
    return path


def lit(**material):
    """A unit quad under a lamp 2 above its middle."""
    scene = Scene()
    scene.node(mesh=scene.quad(material=scene.material(**material)))
    scene.light({"type": "point", "intensity": 8.0}, translation=[0.5, 0.5, 2.0])
    return scene


def at(tmp_path, path, points, *options):
    """E_direct, E_total at points (x, y, z, nx, ny, nz)."""
    wanted = tmp_path / "p.csv"
    wanted.write_text("x,y,z,nx,ny,nz\n" + "".join(",".join(map(str, p)) + "\n" for p in points))
    run = good("irradiance", path, "--points", wanted, "-o", tmp_path / "e.csv", *options)
    return table(tmp_path / "e.csv"), run.stderr


def reflectance(path, *options):
    return report("info", path, *options)["mean_reflectance"]


@pytest.mark.parametrize("name", ["lightCulling", "spotLightTest"])
def test_direct_light_of_real_scenes_is_exact(tmp_path, name):
    points = DATA / f"scenes/{name}.csv"
    good(
        "irradiance",
        DATA / f"scenes/{name}.gltf",
        "--points",
        points,
        "-o",
        tmp_path / "e.csv",
        "--space",
        "ntsc",
        "--tolerance",
        "0.1",
    )
    rows = table(tmp_path / "e.csv")
    assert len(rows) == 200 and sum(row["E_direct"] > 0 for row in rows) > 20
    for row in rows:
        assert row["E_direct"] == pytest.approx(row["E_total_range_window"], rel=1e-5, abs=1e-9)


@pytest.fixture(scope="module")
def cornell_box(tmp_path_factory):
    """What the Cornell box's surfaces get: report and rows of the engine that lcor chooses."""
    out = tmp_path_factory.mktemp("cornell") / "e.csv"
    result = report("irradiance", CORNELL_BOX, "--patches", out, "--tolerance", "0.05")
    return result, table(out)


def check_cornell_box(rows):
    absorbed = sum(row["area"] * row["E_total"] for row in rows)
    # 100 cd/m2 on two sides of 130 x 105; some of it leaves through the open front.
    emitted = 2 * math.pi * 100 * 130 * 105
    assert 0.2 * emitted < absorbed < 3 * emitted
    # The boxes' undersides lie on the floor: no light comes there. Everything else is lit.
    sealed = [row for row in rows if row["ny"] < -0.99 and abs(row["y"]) < 1e-3]
    assert len(sealed) == 2
    assert max(row["E_total"] for row in sealed) < 1e-3 * absorbed / sum(r["area"] for r in rows)
    assert all(row["E_total"] > 0 for row in rows if row not in sealed)


def test_cornell_box_solves_and_keeps_its_power(cornell_box):
    result, rows = cornell_box
    assert result["engine"] == "gather"  # soft shadows of two-sided boxes: links take longer
    estimated = result["estimated_seconds"]
    assert 0 < estimated["gather"] < estimated["links"]
    assert (result["surfaces"], result["emitters"], result["lights"]) == (21, 1, 0)
    check_cornell_box(rows)
    assert min(row["E_total"] for row in rows) == 0


@pytest.mark.skipif(SANITIZED, reason="long; C tests run the engine under sanitizers")
def test_cornell_box_by_links_comes_near_even_where_they_do_not_converge(tmp_path, cornell_box):
    good("irradiance", CORNELL_BOX, "--patches", tmp_path / "e.csv", "--tolerance", "0.2",
         "--engine", "links", "--max-seconds", 100)
    rows = table(tmp_path / "e.csv")
    check_cornell_box(rows)
    power = apart = 0.0
    for links, chosen in zip(rows, cornell_box[1], strict=True):
        power += chosen["area"] * chosen["E_total"]
        apart += chosen["area"] * abs(links["E_total"] - chosen["E_total"])
    assert apart < 0.2 * power


def test_few_points_are_found_by_paths(tmp_path):
    points = [(-343.56, 165, -272.2, 0.2963, 0, 0.9551), (-185, 165, -169, 0, 1, 0)]
    told = tmp_path / "r.json"
    rows, said = at(tmp_path, CORNELL_BOX, points, "--tolerance", "0.02", "--report", told)
    result = json.loads(told.read_text())
    assert result["engine"] == "paths" and "by engine paths" in said
    assert 0 < result["estimated_seconds"]["paths"] < result["estimated_seconds"]["gather"]
    others, said = at(tmp_path, CORNELL_BOX, points, "--tolerance", "0.02", "--engine", "gather")
    assert "by engine gather" in said
    for row, other in zip(rows, others, strict=True):
        assert row["E_total"] == pytest.approx(other["E_total"], rel=0.1) and row["E_total"] > 0


def test_paper_room_agrees_with_the_reference(tmp_path):
    good("room", "-o", tmp_path / "room.glb", "--patches", 50)
    good("irradiance", tmp_path / "room.glb", "--patches", tmp_path / "e.csv")
    rows = table(tmp_path / "e.csv")
    assert len(rows) == 15000
    # Face means of a solution trusted to 1e-5: floor, ceiling, x0, x1, y0, y1.
    means = [3.703416, 5.333192, 5.627462, 3.558356, 4.809449, 3.819415]
    for face, mean in enumerate(means):
        values = [row["E_total"] for row in rows if row["surface"] == face]
        assert sum(values) / len(values) == pytest.approx(mean, rel=0.02)
    # Every face looks inwards.
    assert all(
        row[n] * (0.5 - row[x]) >= 0
        for row in rows
        for n, x in (("nx", "x"), ("ny", "y"), ("nz", "z"))
    )


def test_both_containers_and_files_beside_the_scene_give_the_same(tmp_path):
    scene = lit()
    binary = save(tmp_path, scene)
    text = save(tmp_path, scene, binary=False)
    beside = tmp_path / "beside.gltf"
    (tmp_path / "my data.bin").write_bytes(scene.buffer)
    scene.document["buffers"] = [{"byteLength": len(scene.buffer), "uri": "my%20data.bin"}]
    buffer, scene.buffer = scene.buffer, b""
    beside.write_bytes(scene.gltf())
    assert buffer
    tables = []
    for path in (binary, text, beside):
        good("irradiance", path, "--patches", tmp_path / "e.csv", "--patches", 4)
        tables.append((tmp_path / "e.csv").read_bytes())
    assert tables[0] == tables[1] == tables[2]


def test_candela_give_lux_on_the_side_asked_for(tmp_path):
    path = save(tmp_path, lit())
    rows, _ = at(
        tmp_path, path, [(0.5, 0.5, 0, 0, 0, 1), (0.5, 0.5, 0, 0, 0, -1), (0.5, 1.5, 0, 0, 0, 2)]
    )
    assert rows[0]["E_direct"] == pytest.approx(2.0, rel=1e-9)
    assert rows[1]["E_direct"] == 0
    # Normals of any length; cosine and distance both count beside the middle.
    assert rows[2]["E_direct"] == pytest.approx(8 * 2 / 5**1.5, rel=1e-9)


def test_light_option_adds_a_lamp(tmp_path):
    scene = Scene()
    scene.node(mesh=scene.quad(material=scene.material()))
    path = save(tmp_path, scene)
    rows, _ = at(
        tmp_path, path, [(0.5, 0.5, 0, 0, 0, 1)], "--light", "0.5,0.5,1,3", "--light", "0.5,0.5,2,4"
    )
    assert rows[0]["E_direct"] == pytest.approx(4.0, rel=1e-9)
    refused(
        2, "irradiance", path, "--patches", tmp_path / "e.csv", "--light", "1,2,3", says="--light"
    )
    refused(
        2,
        "irradiance",
        path,
        "--patches",
        tmp_path / "e.csv",
        "--light",
        "1,2,3,-4",
        says="negative",
    )


def test_node_transforms_reach_geometry_and_light(tmp_path):
    scene = Scene()
    # A quad turned to face +x, twice as large, below a parent that moves it; the mirrored scale of
    # the other one keeps it facing the lamp.
    inner = scene.node(
        False,
        mesh=scene.quad(material=scene.material()),
        rotation=[0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4)],
        scale=[2, 2, 2],
    )
    scene.node(children=[inner], translation=[0, 10, 0])
    scene.node(mesh=scene.quad(material=scene.material()), scale=[1, 1, -1], translation=[0, 0, 50])
    lamp = scene.light({"type": "point", "intensity": 4.0}, scale=[3, 3, 3])
    scene.document["scenes"][0]["nodes"].remove(lamp)
    scene.node(children=[lamp], translation=[2, 11, -1])
    path = save(tmp_path, scene)
    info = report("info", path)
    assert info["area"] == pytest.approx(5.0, rel=1e-6)
    assert info["low"] == pytest.approx([0, 0, -2], abs=1e-6)
    rows, _ = at(tmp_path, path, [(0, 11, -1, 1, 0, 0)])
    assert rows[0]["E_direct"] == pytest.approx(1.0, rel=1e-6)
    good("irradiance", path, "--patches", tmp_path / "e.csv", "--one-sided")
    assert [round(row["nz"]) for row in table(tmp_path / "e.csv")] == [0, -1]


def test_a_light_that_takes_light_away_is_none_and_said(tmp_path):
    scene = lit()
    scene.light({"type": "point", "intensity": -5.0}, translation=[0.5, 0.5, 1])
    assert "intensity must be 0 or more" in good("info", save(tmp_path, scene)).stderr


def test_directional_and_spot_lights(tmp_path):
    scene = Scene()
    scene.node(mesh=scene.quad(material=scene.material()))
    scene.light({"type": "directional", "intensity": 7.0})
    path = save(tmp_path, scene)
    assert at(tmp_path, path, [(0.5, 0.5, 0, 0, 0, 1)])[0][0]["E_direct"] == pytest.approx(7)
    scene = Scene()
    scene.node(mesh=scene.quad(material=scene.material()))
    scene.light(
        {"type": "spot", "intensity": 4.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
        translation=[0, 0, 2],
    )
    path = save(tmp_path, scene)
    rows, _ = at(tmp_path, path, [(0, 0, 0, 0, 0, 1), (0.9, 0, 0, 0, 0, 1)])
    assert rows[0]["E_direct"] == pytest.approx(1.0) and rows[1]["E_direct"] == 0


def test_reflectance_is_the_mean_of_what_is_drawn(tmp_path):
    def luminance(r, g, b):
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    assert reflectance(save(tmp_path, lit(rgb=(0.2, 0.5, 0.1)))) == pytest.approx(
        luminance(0.2, 0.5, 0.1), rel=1e-3
    )
    # Two rows of pixels, black and sRGB 188 (linear 0.5029).
    grey = ((188 / 255 + 0.055) / 1.055) ** 2.4
    image = png(2, 2, bytes([0] * 6 + [188] * 6))
    scene = lit()
    scene.node(mesh=scene.quad(material=scene.textured(image)), translation=[0, 0, -1])
    info = report("info", save(tmp_path, scene))
    assert info["mean_reflectance"] == pytest.approx((0.5 + grey / 2) / 2, rel=1e-3)
    # Only the lower half of the picture on the surface.
    scene = lit()
    lower = scene.mesh(
        QUAD,
        [0, 1, 2, 0, 2, 3],
        [(0, 1), (1, 1), (1, 0.5), (0, 0.5)],
        material=scene.textured(image),
    )
    scene.node(mesh=lower, translation=[0, 0, -1])
    assert reflectance(save(tmp_path, scene)) == pytest.approx((0.5 + grey) / 2, rel=1e-3)
    # Vertex colours multiply.
    scene = Scene()
    colours = scene.accessor([(1, 1, 1), (0, 0, 0), (0, 0, 0), (1, 1, 1)])
    scene.node(mesh=scene.quad(material=scene.material(), attributes={"COLOR_0": colours}))
    assert reflectance(save(tmp_path, scene)) == pytest.approx(0.25, rel=1e-3)


def test_measured_reflectance_and_patches_in_extras(tmp_path):
    for place in ("primitive", "mesh", "node", "material"):
        scene = lit()
        extras = {"lcor_reflectance": 0.7, "lcor_patches": [3, 2]}
        document = scene.document
        holder = {
            "primitive": document["meshes"][0]["primitives"][0],
            "mesh": document["meshes"][0],
            "node": document["nodes"][0],
            "material": document["materials"][0],
        }[place]
        holder["extras"] = extras
        info = report("info", save(tmp_path, scene))
        assert info["mean_reflectance"] == pytest.approx(0.7, rel=1e-6)
        assert info["patches"] == (1 if place == "material" else 6)
    scene = lit()
    scene.document["meshes"][0]["primitives"][0]["extras"] = {"lcor_reflectance": 1.5}
    refused(3, "info", save(tmp_path, scene), says="lcor_reflectance")
    scene.document["meshes"][0]["primitives"][0]["extras"] = {"lcor_patches": [0, 2]}
    refused(3, "info", save(tmp_path, scene), says="lcor_patches")


def test_default_material_is_nearly_white_with_a_warning(tmp_path):
    scene = Scene()
    scene.node(mesh=scene.quad())
    run = good("info", save(tmp_path, scene), "--json")
    assert reflectance(tmp_path / "s.glb") == pytest.approx(0.98, rel=1e-6)
    assert "taken as 0.98" in run.stderr


def test_triangles_pair_up_only_into_parallelograms_of_one_look(tmp_path):
    info = report("info", save(tmp_path, lit()))
    assert (info["surfaces"], info["parallelograms"]) == (1, 1)
    # A kite stays two triangles; so does a square whose texture has a seam along the diagonal.
    scene = Scene()
    scene.node(
        mesh=scene.quad([(0, 0, 0), (1, 0, 0), (2, 2, 0), (0, 1, 0)], material=scene.material())
    )
    seam = [QUAD[0], QUAD[1], QUAD[2], QUAD[0], QUAD[2], QUAD[3]]
    uv = [QUAD_UV[0], QUAD_UV[1], QUAD_UV[2], (5, 5), (6, 4), (5, 4)]
    scene.node(mesh=scene.mesh(seam, None, uv, material=scene.material()))
    assert report("info", save(tmp_path, scene))["parallelograms"] == 0
    # A grid of squares, its triangles in any order, becomes the squares.
    points = [(x, y, 0) for y in range(4) for x in range(4)]
    triangles = []
    for y in range(3):
        for x in range(3):
            a = 4 * y + x
            triangles += [(a, a + 1, a + 5), (a, a + 5, a + 4)]
    random.Random(1).shuffle(triangles)
    scene = Scene()
    scene.node(
        mesh=scene.mesh(points, [i for t in triangles for i in t], material=scene.material())
    )
    info = report("info", save(tmp_path, scene))
    assert (info["surfaces"], info["parallelograms"], info["area"]) == (9, 9, pytest.approx(9))


def test_triangles_without_area_are_counted(tmp_path):
    scene = lit()
    scene.node(
        mesh=scene.mesh(
            [(0, 0, 0), (1, 1, 1), (2, 2, 2), (5, 5, 5), (5, 5, 5), (6, 5, 5)],
            material=scene.material(),
        )
    )
    run = good("info", save(tmp_path, scene), "--json")
    assert report("info", tmp_path / "s.glb")["triangles_without_area"] == 2
    assert "triangles without area are left out: 2 of 4" in run.stderr


def test_surfaces_with_the_same_corners_are_one_wall(tmp_path):
    """Each of two back to back reflects on its own side; of equal ones the first does."""

    def between_plates(*twins):
        scene = Scene()
        grey, light = scene.material((0.7, 0.7, 0.7)), scene.material((0.9, 0.9, 0.9))
        for z in (0, 0.3):
            scene.node(mesh=scene.quad(material=grey), translation=[0, 0, z])
        for twin in twins:
            scene.node(mesh=scene.quad([QUAD[k] for k in twin], material=light))
        scene.light({"type": "point", "intensity": 8.0}, translation=[0.5, 0.5, 0.2])
        rows, said = at(tmp_path, save(tmp_path, scene), [(0.3, 0.4, 0, 0, 0, 1)])
        return rows[0]["E_total"], "on another one are left out: 1" in said

    alone, _ = between_plates()
    for twins, left_out in (((3, 2, 1, 0),), False), (((0, 1, 2, 3), (2, 1, 0, 3)), True):
        assert between_plates(*twins) == (pytest.approx(alone, rel=0.01), left_out)


@pytest.mark.parametrize("mode, triangles", [(4, 1), (5, 2), (6, 2)])
def test_lists_strips_and_fans_without_indices(tmp_path, mode, triangles):
    scene = Scene()
    points = [QUAD[0], QUAD[1], QUAD[3], QUAD[2]] if mode == 5 else QUAD
    scene.node(mesh=scene.mesh(points, material=scene.material(), mode=mode))
    info = report("info", save(tmp_path, scene))
    assert (info["triangles"], info["area"]) == (triangles, pytest.approx(triangles / 2))


def test_emission_is_exitance_and_goes_to_both_sides_unless_told(tmp_path):
    scene = Scene()
    glow = scene.material(
        (0, 0, 0),
        emissiveFactor=[0.5, 0.5, 0.5],
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 20}},
    )
    scene.document["extensionsUsed"] = ["KHR_materials_emissive_strength"]
    scene.node(mesh=scene.quad(material=glow))
    for z in (1, -1):
        scene.node(mesh=scene.quad(material=scene.material((0, 0, 0))), translation=[0, 0, z])
    path = save(tmp_path, scene)
    for option, sides in (((), 2), (("--one-sided",), 1)):
        good("irradiance", path, "--patches", tmp_path / "e.csv", "--tolerance", "0.001", *option)
        rows, _ = at(
            tmp_path,
            path,
            [(0.5, 0.5, 1, 0, 0, -1), (0.5, 0.5, -1, 0, 0, 1)],
            "--tolerance",
            "0.001",
            *option,
        )
        # Closed form at the middle under a unit square at distance 1: pi L times the form factor.
        a = 0.5 / math.sqrt(1.25)
        factor = 4 / (2 * math.pi) * 2 * a * math.atan(0.5 / math.sqrt(1.25))
        expected = math.pi * 10 * factor
        assert rows[0]["E_total"] == pytest.approx(expected, rel=0.01)
        assert rows[1]["E_total"] == pytest.approx(expected if sides == 2 else 0, rel=0.01)


def test_lights_of_different_colour_ask_for_three_channels(tmp_path):
    scene = lit(rgb=(0.8, 0.2, 0.2))
    assert report("info", save(tmp_path, scene))["channels"] == 1
    scene.light({"type": "point", "intensity": 8.0, "color": [0, 1, 0]}, translation=[0.5, 0.5, 3])
    path = save(tmp_path, scene)
    assert report("info", path)["channels"] == 3
    rows, _ = at(tmp_path, path, [(0.5, 0.5, 0, 0, 0, 1)])
    assert rows[0]["E_red"] == pytest.approx(2) and rows[0]["E_green"] == pytest.approx(2 + 8 / 9)
    assert rows[0]["E_total"] == pytest.approx(2 + 0.7152 * 8 / 9, rel=1e-3)
    rows, _ = at(tmp_path, path, [(0.5, 0.5, 0, 0, 0, 1)], "--channels", "1")
    assert "E_red" not in rows[0] and rows[0]["E_total"] == pytest.approx(
        2 + 0.7152 * 8 / 9, rel=1e-3
    )


def test_unsupported_features_are_named_once_each(tmp_path):
    scene = lit()
    scene.document["extensionsUsed"] = ["FOO_bar", "KHR_lights_punctual"]
    scene.add("animations", {"channels": [], "samplers": []})
    for _ in range(3):
        scene.node(mesh=scene.mesh(QUAD, mode=1, material=scene.material(alphaMode="BLEND")))
    run = good("info", save(tmp_path, scene), "--json")
    lines = run.stderr.splitlines()
    for feature in ("FOO_bar", "animations", "points and lines", "alphaMode BLEND"):
        assert sum(feature in line for line in lines) == 1, (feature, lines)
    assert len(report("info", tmp_path / "s.glb")["warnings"]) == 4


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "FOO_required"])
def test_a_required_extension_that_is_not_read_is_an_error(tmp_path, name):
    scene = lit()
    primitive = {"attributes": {"POSITION": 0}, "indices": 0, "extensions": {name: {}}}
    scene.node(mesh=scene.add("meshes", {"primitives": [primitive]}))
    scene.document["accessors"][0].pop("bufferView")  # the data stand in the extension
    scene.document["extensionsUsed"] = scene.document["extensionsRequired"] = [name]
    refused(3, "info", save(tmp_path, scene), says=f"requires the extension {name}")


def test_a_required_extension_that_is_read_is_fine(tmp_path):
    scene = lit()
    scene.document["extensionsRequired"] = ["KHR_lights_punctual", "KHR_texture_transform"]
    assert good("info", save(tmp_path, scene)).stderr == ""


def test_broken_texture_is_a_warning_and_the_factor_stays(tmp_path):
    scene = lit()
    material = scene.textured(b"no picture at all")
    scene.document["materials"][material]["pbrMetallicRoughness"]["baseColorFactor"] = [
        0.3,
        0.3,
        0.3,
        1,
    ]
    scene.node(mesh=scene.quad(material=material), translation=[0, 0, 1])
    run = good("info", save(tmp_path, scene), "--json")
    assert "neither JPEG, PNG nor WebP" in run.stderr
    assert reflectance(tmp_path / "s.glb") == pytest.approx(0.4, rel=1e-6)
    scene.document["images"][0] = {"uri": "gone.png"}
    run = good("info", save(tmp_path, scene, binary=False), "--json")
    assert "no such file 'gone.png'" in run.stderr


def test_the_room_is_binary_and_must_be_called_so(tmp_path):
    refused(2, "room", "-o", tmp_path / "room.gltf", says="call it .glb")


def test_textures_of_the_room_stand_in_the_file(tmp_path):
    image = tmp_path / "t.png"
    image.write_bytes(png(2, 1, bytes([255, 255, 255, 0, 0, 0])))
    room = tmp_path / "room.glb"
    good("room", "-o", room, "--texture", f"floor={image}", "--texture", f"x0={image}")
    info = report("info", room)
    assert info["textures"] == 1 and info["cameras"] == ["side", "above"]
    assert info["mean_reflectance"] == pytest.approx((0.5 + 0.8 + 0.5 + 3 * 0.5) / 6, rel=1e-3)
    good(
        "room",
        "-o",
        room,
        "--texture",
        f"floor={image}",
        "--reflectance",
        "0.1,0.8,0.5,0.5,0.5,0.5",
    )
    assert reflectance(room) == pytest.approx((0.1 + 0.8 + 4 * 0.5) / 6, rel=1e-3)
    refused(2, "room", "-o", room, "--texture", f"roof={image}", says="no face 'roof'")
    refused(3, "room", "-o", room, "--texture", f"floor={__file__}", says="neither JPEG nor PNG")
    refused(2, "room", "-o", room, "--light", "2,0,0,1", says="inside")
    refused(2, "room", "-o", room, "--box", "0,1,0,1,0,2,0.5", says="--box")


def test_box_in_the_room_looks_outwards_and_throws_shadow(tmp_path):
    room = tmp_path / "room.glb"
    good("room", "-o", room, "--box", "0.25,0.5,0.25,0.5,0,0.25,0.6", "--patches", 5)
    info = report("info", room)
    assert info["surfaces"] == 12 and info["area"] == pytest.approx(6 + 6 * 0.0625, rel=1e-5)
    rows, _ = at(tmp_path, room, [(0.3, 0.4, 0.25, 0, 0, 1), (0.3, 0.4, 0, 0, 0, 1)])
    assert rows[0]["E_direct"] == pytest.approx(1 / 0.45**2, rel=1e-5) and rows[1]["E_direct"] == 0


@pytest.mark.parametrize(
    "says, text",
    [
        ("no scene lcor reads", b""),
        ("no scene lcor reads", b"hello"),
        ("cut short", b"glTF\2\0\0\0"),
        ("cannot read scene", b'{"asset": '),
        ("cannot read scene", b"{}"),
        ("glTF 1.0", b'{"asset": {"version": "1.0"}}'),
        ("no surface", b'{"asset": {"version": "2.0"}}'),
        (
            "nests",
            b'{"asset": {"version": "2.0"}, "extras": ' + b"[" * 100000 + b"]" * 100000 + b"}",
        ),
        ("gone.bin", b'{"asset":{"version":"2.0"},"buffers":[{"uri":"gone.bin","byteLength":9}]}'),
    ],
)
def test_files_that_are_no_scene(tmp_path, says, text):
    path = tmp_path / "s.gltf"
    path.write_bytes(text)
    refused(3, "info", path, says=says)


def broken(change):
    scene = lit()
    change(scene.document)
    return scene


@pytest.mark.parametrize(
    "says, change",
    [
        ("its own ancestor", lambda d: d["nodes"][0].update(children=[0])),
        (
            "two parents",
            lambda d: (
                d["nodes"].append({"children": [0, 0]}) or d["scenes"][0]["nodes"].__setitem__(0, 2)
            ),
        ),
        ("no mesh", lambda d: d["nodes"][0].update(mesh=7)),
        ("no material", lambda d: d["meshes"][0]["primitives"][0].update(material=9)),
        ("accessor", lambda d: d["accessors"][0].update(count=1 << 40)),
        ("past the end", lambda d: d["accessors"][0].update(count=90)),
        ("vertex", lambda d: d["accessors"][0].update(count=2)),
        ("outside the buffer", lambda d: d["bufferViews"][0].update(byteOffset=1 << 30)),
        (
            "not finite",
            lambda d: d["nodes"][0].update(translation=[1e200, 0, 0], scale=[1e200, 1e200, 1e200]),
        ),
        ("no camera", lambda d: d["nodes"][0].update(camera=3)),
        (
            "light that is not there",
            lambda d: d["extensions"]["KHR_lights_punctual"].update(lights=[]),
        ),
        (
            "Draco",
            lambda d: d["meshes"][0]["primitives"][0].update(
                extensions={"KHR_draco_mesh_compression": {}}
            ),
        ),
    ],
)
def test_broken_references_name_what_is_wrong(tmp_path, says, change):
    line = refused(3, "info", save(tmp_path, broken(change), binary=False))
    assert says.lower() in line.lower() and "s.gltf" in line


def test_every_cut_and_many_mutations_end_cleanly(tmp_path):
    original = (CORNELL_BOX).read_bytes()
    chance = random.Random(7)
    path = tmp_path / "m.glb"
    for i in range(24):
        data = bytearray(original)
        if i % 3 == 0:
            data = data[: chance.randrange(len(data))]
        else:
            for _ in range(chance.choice((1, 4, 30))):
                data[chance.randrange(len(data))] = chance.randrange(256)
        path.write_bytes(bytes(data))
        run = lcor("info", path)
        assert run.returncode in (0, 3), (i, run.returncode, run.stderr)


def test_points_file_keeps_its_columns_and_names_bad_lines(tmp_path):
    path = save(tmp_path, lit())
    points = tmp_path / "p.csv"
    points.write_text("name,nz,ny,nx,z,y,x\r\ndesk,1,0,0,0,0.5,0.5\r\n")
    good("irradiance", path, "--points", points, "-o", tmp_path / "e.csv")
    header, row = (tmp_path / "e.csv").read_text().splitlines()
    assert header == "name,nz,ny,nx,z,y,x,E_direct,E_total"
    assert row.startswith("desk,1,0,0,0,0.5,0.5,2")
    good("irradiance", path, "--points", tmp_path / "e.csv", "-o", tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == (tmp_path / "e.csv").read_text()
    points.write_text('name,x,y,z,nx,ny,nz\n"desk, left",0.5,0.5,0,0,0,1\n')
    good("irradiance", path, "--points", points, "-o", tmp_path / "e.csv")
    row = (tmp_path / "e.csv").read_text().splitlines()[1]
    assert row.startswith('"desk, left",0.5,0.5,0,0,0,1,2')
    for text, says in [
        ("", "empty"),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,1,7\n", "line 2: 7 columns instead of 6"),
        ("x,y,z\n1,2,3\n", "no column nx"),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,0\n", "normal has no length"),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,oops,0,0,1\n", "line 3"),
        ("1,2,3,0,0,nan\n", "line 1"),
    ]:
        points.write_text(text)
        refused(3, "irradiance", path, "--points", points, "-o", tmp_path / "e.csv", says=says)


def test_threads_change_no_byte(tmp_path):
    good("room", "-o", tmp_path / "s.glb", "--patches", 5)
    out = []
    for n in (1, 2, 5):
        good(
            "irradiance",
            tmp_path / "s.glb",
            "--patches",
            tmp_path / "e.csv",
            "--threads",
            n,
            "--tolerance",
            "0.1",
        )
        out.append((tmp_path / "e.csv").read_bytes())
    assert out[0] == out[1] == out[2]
