# SPDX-License-Identifier: MIT
import lcor
import numpy as np
import pytest


@pytest.fixture
def scene():
    scene = lcor.Scene()
    scene.add_quad((-2, -2, 0), (4, 0, 0), (0, 4, 0), reflectance=0.5)
    scene.add_quad((0, -1, 0.5), (1, 0, 0), (0, 2, 0), reflectance=0.2)
    scene.add_point_light((-1.5, 0, 2), 10.0)
    return scene


@pytest.fixture
def camera():
    return lcor.Camera.look((0, 0, 5), (0, 0, 0), up=(0, 1, 0), size=(64, 48), fov_y=0.5)


def test_pieces_cover_the_picture(scene, camera):
    view = lcor.View(scene, camera)
    np.testing.assert_allclose(view.image(view.coverage * 0 + 1), 1.0, atol=1e-6)
    assert set(view.surface) == {0, 1} and len(view) == len(view.depth) == len(view.uv)
    assert (view.depth[view.surface == 1] < view.depth[view.surface == 0].min()).all()


def test_places_agree_with_rays(scene, camera):
    view = lcor.View(scene, camera)
    whole = np.flatnonzero(view.coverage == 1)[::97]
    forward, up, right = np.array([0, 0, -1.0]), np.array([0, 1.0, 0]), np.array([1.0, 0, 0])
    half = np.tan(0.25)
    for i in whole:
        x = (2 * (view.x[i] + 0.5) / 64 - 1) * half * 64 / 48
        y = (1 - 2 * (view.y[i] + 0.5) / 48) * half
        hit = scene.intersect((0, 0, 5), forward + x * right + y * up)
        assert hit.surface == view.surface[i]
        np.testing.assert_allclose(view.uv[i], (hit.u, hit.v), atol=1e-6)
        assert view.depth[i] == pytest.approx(hit.t, rel=1e-6)


def test_irradiance_of_pieces_agrees_with_points(scene, camera):
    solution = lcor.solve_radiosity(scene, tolerance=1e-3)
    view = lcor.View(scene, camera)
    got = view.irradiance(solution)
    assert got.shape == (len(view),)
    origin, size = np.array([[-2, -2, 0], [0, -1, 0.5]]), np.array([[4, 4], [1, 2]])
    pick = np.arange(0, len(view), 53)
    points = origin[view.surface[pick]]
    points[:, :2] += view.uv[pick] * size[view.surface[pick]]
    expected = solution.at(points, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(got[pick], expected, rtol=0.02, atol=0.02 * expected.mean())
    assert (view.irradiance(solution, direct=True) <= got + 1e-9).all()
    np.testing.assert_array_equal(got, view.irradiance(solution, threads=2))


def test_a_picture_is_corrected_through_its_view(scene, camera):
    view = lcor.View(scene, camera)
    light = view.irradiance(lcor.solve_radiosity(scene))
    rho = np.array([0.5, 0.2])[view.surface]
    mean = lcor.geometric_mean(light * rho, view.coverage)
    texels = np.repeat(rho[:, None], 3, axis=1)
    out, _ = lcor.Plan(23.4, mean).apply(texels, light, rho)
    picture = view.image(out)
    assert picture.shape == (48, 64, 3) and 0 <= picture.min() < picture.max() <= 1


def test_background_shows_where_nothing_is(scene):
    camera = lcor.Camera((0, 0, 5), (0, 0, -1), up=(0, 1, 0), size=(40, 20), fov_y=0, height=5)
    view = lcor.View(scene, camera)
    picture = view.image(np.ones(len(view)), background=0.5)
    assert picture[0, 0] == 0.5 and picture[10, 20] == pytest.approx(1.0)


def test_bad_cameras_are_refused(scene):
    with pytest.raises(ValueError):
        lcor.View(scene, lcor.Camera((0, 0, 5), (0, 0, 0)))
    with pytest.raises(ValueError, match="takes 3 numbers"):
        lcor.View(scene, lcor.Camera((0, 0), (0, 0, -1)))


def test_backs_are_culled_on_request(scene, camera):
    below = lcor.Camera.look((0, 0, -5), (0, 0, 0), up=(0, 1, 0), size=(8, 6), fov_y=0.2)
    assert len(lcor.View(scene, below)) >= 48
    assert len(lcor.View(scene, below, cull_back=True)) == 0
    assert set(lcor.View(scene, below, cull_back=[True, False]).surface) == {1}
    with pytest.raises(ValueError, match="one flag for each surface"):
        lcor.View(scene, camera, cull_back=[True])
