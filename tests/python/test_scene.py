# SPDX-License-Identifier: MIT
import copy
import csv
import math
import pickle
import threading
import warnings

import lcor
import numpy as np
import pytest

FACES = {
    "floor": ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
    "ceiling": ((0, 0, 1), (0, 1, 0), (1, 0, 0)),
    "x0": ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
    "x1": ((1, 0, 0), (0, 0, 1), (0, 1, 0)),
    "y0": ((0, 0, 0), (0, 0, 1), (1, 0, 0)),
    "y1": ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
}
RHO = {"floor": 0.3, "ceiling": 0.8}


def room(patches=4, light=True, **options):
    scene = lcor.Scene()
    for face, (origin, u, v) in FACES.items():
        rho = options.get("reflectance", RHO.get(face, 0.5))
        emission = options.get("emission", 0.0)
        scene.add_quad(origin, u, v, rho, emission, (patches, patches))
    if light:
        scene.add_point_light((0.3, 0.4, 0.7), options.get("intensity", 1.0))
    return scene


def test_the_papers_room_agrees_with_the_reference(source):
    with open(source / "tests/data/reference/paper_room_50x50.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    solution = lcor.solve_radiosity(room(50), tolerance=0.01)
    assert solution.report["converged"]
    error, area = 0.0, 0
    for surface, face in enumerate(FACES):
        mine = [r for r in rows if r["face"] == face]
        expected = np.array([float(r["E_avg"]) for r in mine]).reshape(50, 50)
        _, u, v = FACES[face]
        if u.index(1) > v.index(1):  # the table counts i along the earlier axis
            expected = expected.T
        got = solution.irradiance(surface)
        error += (((got - expected) / expected) ** 2).sum()
        area += got.size
    assert math.sqrt(error / area) < 0.01


def test_furnace_has_its_closed_form():
    scene = room(3, light=False, reflectance=0.75, emission=1.0)
    solution = lcor.solve_radiosity(scene, tolerance=1e-3)
    np.testing.assert_allclose(solution.irradiance(0), 4.0, rtol=2e-3)
    assert (solution.direct(0) == 0).all()


def test_one_patch_over_another_has_the_lambert_value():
    scene = lcor.Scene()
    floor = scene.add_quad((-0.005, -0.005, 0), (0.01, 0, 0), (0, 0.01, 0), 0.0)
    scene.add_point_light((0, 0, 2), 8.0)
    solution = lcor.solve_radiosity(scene)
    assert solution.irradiance(floor)[0, 0] == pytest.approx(2.0, rel=1e-4)
    assert solution.at([0, 0, 0.0], [0, 0, 1.0]) == pytest.approx(2.0, rel=1e-9)
    assert solution.direct_at([[0, 0, 0.0]], [[0, 0, -1.0]])[0] == 0.0


def test_points_and_patches_agree():
    scene = room(5)
    solution = lcor.solve_radiosity(scene, tolerance=1e-3)
    centres, areas, normal = scene.patches(0)
    assert centres.shape == (5, 5, 3) and areas.sum() == pytest.approx(1) and normal == (0, 0, 1)
    np.testing.assert_allclose(
        solution.at(centres, normal), solution.irradiance(0, "centre"), rtol=0.01
    )
    assert solution.at(centres, np.array(normal)).shape == (5, 5)


def test_colour_needs_three_channels():
    solution = lcor.solve_radiosity(room(2, intensity=(1.0, 0.5, 0.25)))
    assert solution.report["channels"] == 3
    total = solution.irradiance(0)
    assert total.shape == (2, 2, 3)
    np.testing.assert_allclose(total[..., 1] / total[..., 0], 0.5, rtol=1e-9)
    assert solution.at([[0.5, 0.5, 0.0]], [0, 0, 1.0]).shape == (1, 3)


def test_updates_follow_light_and_reflectance():
    scene = room(3)
    solution = lcor.solve_radiosity(scene, tolerance=1e-3)
    before = solution.irradiance(1).copy()
    scene.set_light(0, scene.point_light((0.3, 0.4, 0.7), 2.0))
    np.testing.assert_allclose(solution.update().irradiance(1), 2 * before, rtol=1e-6)
    for surface in range(6):
        scene.set_surface(surface, reflectance=0.0)
    solution.update()
    np.testing.assert_allclose(solution.irradiance(1), solution.direct(1), rtol=1e-6)


def test_threads_do_not_change_bits():
    one = lcor.solve_radiosity(room(6), tolerance=1e-3, threads=1)
    two = lcor.solve_radiosity(room(6), tolerance=1e-3, threads=2)
    for surface in range(6):
        np.testing.assert_array_equal(one.irradiance(surface), two.irradiance(surface))


@pytest.mark.parametrize("engine", ["links", "gather", "paths"])
def test_each_engine_meets_the_tolerance(engine):
    exact = lcor.solve_radiosity(room(6), tolerance=1e-3)
    solution = lcor.solve_radiosity(room(6), tolerance=0.02, engine=engine)
    assert solution.report["engine"] == engine and solution.report["converged"]
    assert (solution.report["rays"] > 0) == (engine != "links")
    got, expected = ([s.irradiance(i) for i in range(6)] for s in (solution, exact))
    assert np.sqrt(np.mean((np.array(got) / expected - 1) ** 2)) < 0.02
    place = [[0.5, 0.5, 0.0]], [0, 0, 1.0]
    assert solution.at(*place) == pytest.approx(exact.at(*place), rel=0.05)


def test_the_scene_chooses_its_engine_and_says_why():
    report = lcor.solve_radiosity(room()).report
    assert report["engine"] == "links" and 0 < report["links_seconds"] < report["gather_seconds"]
    assert report["pairs_open"] == 30 and report["pairs_tested"] == report["pairs_apart"] == 0
    asked = lcor.solve_radiosity(room(), engine="links").report
    assert asked["links_seconds"] == asked["gather_seconds"] == 0
    assert len({asked["engine_reason"], report["engine_reason"], report["visibility_reason"],
                report["channels_reason"]}) == 4
    scene = lcor.Scene()
    for i in range(100):  # upright, each hiding others
        scene.add_quad((i % 10, i // 10, 0), (0.9 * (i % 2), 0.9 - 0.9 * (i % 2), 0), (0, 0, 0.5))
    scene.add_point_light((5, 5, 3), 10.0)
    report = lcor.solve_radiosity(scene, tolerance=0.1).report
    assert report["engine"] == "gather" and report["paths_seconds"] == np.inf
    report = lcor.solve_radiosity(scene, tolerance=0.1, points=1).report
    assert report["engine"] == "paths" and report["paths_seconds"] < report["gather_seconds"]


def test_triangles_and_polygons_have_lists_of_patches():
    scene = lcor.Scene()
    triangle = scene.add_triangle((0, 0, 0), (1, 0, 0), (0, 1, 0), patches=3)
    polygon = scene.add_polygon([(0, 0, 2), (0, 1, 2), (1, 1, 2), (1.5, 0.5, 2)], patches=2)
    scene.add_point_light((0.2, 0.2, 1))
    solution = lcor.solve_radiosity(scene)
    assert solution.irradiance(triangle).shape == (9,)
    assert solution.irradiance(polygon).shape == (8,)
    assert scene.patches(triangle).areas.sum() == pytest.approx(0.5)
    assert scene.surface_count == 2 and scene.light_count == 1


def test_other_lights():
    scene = lcor.Scene()
    floor = scene.add_quad((-0.5, -0.5, 0), (1, 0, 0), (0, 1, 0), 0.0)
    scene.add_directional_light((0, 0, -3), 7.0)
    assert lcor.solve_radiosity(scene).irradiance(floor)[0, 0] == pytest.approx(7.0, rel=1e-6)
    scene = lcor.Scene()
    floor = scene.add_quad((-0.5, -0.5, 0), (1, 0, 0), (0, 1, 0), 0.0)
    scene.add_spot_light((0, 0, 2), (0, 0, -1), 8.0, 0.5, 0.6)
    assert lcor.solve_radiosity(scene).direct_at([0, 0, 0.0], [0, 0, 1.0]) == pytest.approx(2.0)


def test_rays():
    hit = room().intersect((0.5, 0.25, 0.5), (0, 0, -2))
    assert hit.surface == 0 and hit.front and (hit.t, hit.u, hit.v) == (0.25, 0.5, 0.25)
    assert room().intersect((0.5, 0.5, 0.5), (0, 0, -2), t_max=0.1) is None


@pytest.mark.parametrize(
    "build, text",
    [
        (lambda s: None, "surface"),
        (lambda s: s.add_quad((0, 0, 0), (1, 0, 0), (2, 0, 0)), "area"),
        (lambda s: s.add_quad((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0), "reflectance"),
        (lambda s: s.add_quad((0, 0, math.nan), (1, 0, 0), (0, 1, 0)), "finite"),
        (lambda s: s.add_quad((0, 0), (1, 0, 0), (0, 1, 0)), "origin takes 3 numbers"),
        (lambda s: s.add_polygon([(0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 0)]), "plan"),
    ],
)
def test_bad_scenes_are_named(build, text):
    scene = lcor.Scene()
    with pytest.raises(ValueError, match=text):
        build(scene)
        scene.commit()


def test_bad_questions_are_refused():
    scene = room()
    with pytest.raises(ValueError, match="tolerance"):
        lcor.solve_radiosity(scene, tolerance=2.0)
    with pytest.raises(ValueError, match='norm must be "rms" or "max"'):
        lcor.solve_radiosity(scene, norm="mean")
    with pytest.raises(ValueError, match="tolerance"):
        lcor.solve_radiosity(scene, tolerance=0)
    with pytest.raises(TypeError, match="tolerance must be a number"):
        lcor.solve_radiosity(scene, tolerance="1e-2")
    with pytest.raises(ValueError, match="threads"):
        lcor.solve_radiosity(scene, threads=0)
    with pytest.raises(ValueError, match="max_bytes"):
        lcor.solve_radiosity(scene, max_bytes=-1)
    with pytest.raises(ValueError, match="points"):
        lcor.solve_radiosity(scene, points=-1)
    solution = lcor.solve_radiosity(scene)
    for missing in (17, -1):
        with pytest.raises(ValueError, match=f"surface {missing}: the scene has 6"):
            solution.irradiance(missing)
    with pytest.raises(TypeError, match="surface must be a whole number"):
        solution.irradiance(0.0)
    with pytest.raises(ValueError, match="surface 6"):
        scene.set_surface(6, 0.5)
    with pytest.raises(ValueError, match="light 1: the scene has 1"):
        scene.set_light(1, scene.point_light((0, 0, 1)))
    with pytest.raises(ValueError, match="kind must be"):
        solution.irradiance(0, "corner")


def test_normals_of_any_length_are_taken_and_nonsense_is_refused():
    solution = lcor.solve_radiosity(room())
    point = [0.5, 0.5, 0.0]
    assert solution.at(point, [0, 0, 2.5]) == solution.at(point, [0, 0, 1])
    assert solution.at(np.zeros((0, 3)), point).shape == (0,)
    for bad in (math.nan, math.inf):
        with pytest.raises(ValueError, match="point 1 is not finite"):
            solution.at([point, [0.5, bad, 0.5]], [0, 0, 1.0])
        with pytest.raises(ValueError, match="normal 0 has no direction"):
            solution.at(point, [0, 0, bad])
    with pytest.raises(ValueError, match="normal 0 has no direction"):
        solution.at(point, [0, 0, 0.0])
    with pytest.raises(ValueError, match=r"normals for \(2,\) places do not fit points for \(3,\)"):
        solution.at(np.zeros((3, 3)), np.ones((2, 3)))


def test_patches_are_one_number_or_two():
    scene = lcor.Scene()
    quad, triangle = ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 0, 1), (1, 0, 1), (0, 1, 1))
    grids = {3: (3, 3), (2, 5): (2, 5)}
    quads = {scene.add_quad(*quad, patches=given): grid for given, grid in grids.items()}
    quads[scene.add_quad(*quad, patches=np.array([4, 1]))] = (4, 1)
    triangles = [scene.add_triangle(*triangle, patches=given) for given in (3, (3, 3))]
    assert {surface: scene.patches(surface).areas.shape for surface in quads} == quads
    assert [scene.patches(surface).areas.shape for surface in triangles] == [(9,), (9,)]
    for bad in ((0, 1), -1, 2.0, (1, 2, 3), "ab", None):
        with pytest.raises(ValueError, match="patches"):
            lcor.Scene().add_quad((0, 0, 0), (1, 0, 0), (0, 1, 0), patches=bad)
    with pytest.raises(ValueError, match="of a triangle is one number"):
        lcor.Scene().add_triangle((0, 0, 0), (1, 0, 0), (0, 1, 0), patches=(2, 3))


def test_scenes_stay_where_they_are():
    for call in (copy.copy, copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="build it again"):
            call(room())


def test_threads_may_commit_one_scene_together():
    scene = room(6)
    threads = [threading.Thread(target=scene.commit) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert scene.patches(0).areas.shape == (6, 6)


def test_progress_can_cancel_and_raise():
    seen = []

    def progress(done):
        seen.append(done)

    lcor.solve_radiosity(room(), progress=progress)
    assert seen == sorted(seen) and all(0 <= done <= 1 for done in seen) and seen
    with pytest.raises(lcor.Cancelled):
        lcor.solve_radiosity(room(), progress=lambda done: True)

    def fail(done):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        lcor.solve_radiosity(room(), progress=fail)


def test_scene_cannot_change_while_it_is_read():
    scene = room()

    def meddle(done):
        scene.add_point_light((0, 0, 0))

    with pytest.raises(RuntimeError, match="being read"):
        lcor.solve_radiosity(scene, progress=meddle)


def test_limits_warn_and_say_how_close():
    scene = room(20)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solution = lcor.solve_radiosity(scene, tolerance=1e-5, max_bytes=1)
    if not solution.report["converged"]:
        assert issubclass(caught[0].category, lcor.NotConvergedWarning)
        assert "estimated error" in str(caught[0].message)
    else:
        assert not caught
