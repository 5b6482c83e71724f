/* SPDX-License-Identifier: MIT */
#include "scene.hpp"
#include "bind.hpp"
#include "rows.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

SceneHandle::SceneHandle()
{
    lcor_error error = {};
    check(lcor_scene_new(nullptr, &scene, &error), error);
}

lcor_parallel Threads::parallel()
{
    return count_ > 1 ? lcor_parallel{run, this} : lcor_parallel{nullptr, nullptr};
}

void Threads::run(void *user, size_t n, void (*task)(void *, size_t), void *arg)
{
    std::atomic<size_t> next{0};
    const auto work = [&] {
        for (size_t i; (i = next.fetch_add(1)) < n;)
            task(arg, i);
    };
    const size_t wanted = std::min(n, static_cast<size_t>(static_cast<Threads *>(user)->count_));
    std::vector<std::thread> others;
    try {
        for (size_t i = 1; i < wanted; i++)
            others.emplace_back(work);
    } catch (const std::system_error &) {
        /* the system gives no more threads: those we have do the work */
    }
    work();
    for (std::thread &thread : others)
        thread.join();
}

int Progress::report(void *user, double done)
{
    const nb::gil_scoped_acquire gil;
    const nb::object &callback = static_cast<Progress *>(user)->callback_;
    if (PyErr_CheckSignals())
        return 1;
    if (callback.is_none())
        return 0;
    try {
        return nb::cast<bool>(nb::bool_(callback(done)));
    } catch (nb::python_error &raised) {
        raised.restore();
        return 1;
    }
}

static lcor_surface surface_of(const Vec3 &reflectance, const Vec3 &emission, size_t nu, size_t nv,
                               bool two_sided)
{
    lcor_surface surface = {};
    std::copy(reflectance.begin(), reflectance.end(), surface.reflectance);
    std::copy(emission.begin(), emission.end(), surface.emission);
    surface.patches[0] = nu;
    surface.patches[1] = nv;
    surface.two_sided = two_sided;
    return surface;
}

static lcor_scene *writable(Scene &self)
{
    if (self.handle->users)
        throw std::runtime_error("the scene is being read by another call: change it afterwards");
    return self.handle->scene;
}

static size_t add_polygon(Scene &self, const std::vector<Vec3> &corners, const Vec3 &reflectance,
                          const Vec3 &emission, size_t nu, size_t nv, bool two_sided)
{
    const lcor_surface surface = surface_of(reflectance, emission, nu, nv, two_sided);
    size_t id = 0;
    lcor_error error = {};
    check(lcor_scene_add_polygon(writable(self), corners.size(), corners.data()->data(), &surface,
                                 &id, &error),
          error);
    return id;
}

using AddThree = lcor_status (*)(lcor_scene *, const double *, const double *, const double *,
                                 const lcor_surface *, size_t *, lcor_error *);

template <AddThree add>
static size_t add_three(Scene &self, const Vec3 &a, const Vec3 &b, const Vec3 &c,
                        const Vec3 &reflectance, const Vec3 &emission, size_t nu, size_t nv,
                        bool two_sided)
{
    const lcor_surface surface = surface_of(reflectance, emission, nu, nv, two_sided);
    size_t id = 0;
    lcor_error error = {};
    check(add(writable(self), a.data(), b.data(), c.data(), &surface, &id, &error), error);
    return id;
}

static void set_surface(Scene &self, size_t id, const Vec3 &reflectance, const Vec3 &emission,
                        size_t nu, size_t nv, bool two_sided)
{
    const lcor_surface surface = surface_of(reflectance, emission, nu, nv, two_sided);
    lcor_error error = {};
    check(lcor_scene_set_surface(writable(self), id, &surface, &error), error);
}

static lcor_light light_of(lcor_light_kind kind, const Vec3 &position, const Vec3 &direction,
                           const Vec3 &intensity, double inner_cone, double outer_cone,
                           double range)
{
    lcor_light light = {};
    light.kind = kind;
    std::copy(position.begin(), position.end(), light.position);
    std::copy(direction.begin(), direction.end(), light.direction);
    std::copy(intensity.begin(), intensity.end(), light.intensity);
    light.inner_cone = inner_cone;
    light.outer_cone = outer_cone;
    light.range = range;
    return light;
}

static size_t add_light(Scene &self, const lcor_light &light)
{
    size_t id = 0;
    lcor_error error = {};
    check(lcor_scene_add_light(writable(self), &light, &id, &error), error);
    return id;
}

static void set_light(Scene &self, size_t id, const lcor_light &light)
{
    lcor_error error = {};
    check(lcor_scene_set_light(writable(self), id, &light, &error), error);
}

static void commit(Scene &self)
{
    if (self.handle->committed)
        return;
    const InUse in_use(self.handle->users);
    lcor_error error = {};
    lcor_status status = LCOR_OK;
    {
        nb::gil_scoped_release nogil;
        const std::lock_guard<std::mutex> lock(self.handle->committing);
        if (!self.handle->committed)
            status = lcor_scene_commit(self.handle->scene, nullptr, &error);
        self.handle->committed = status == LCOR_OK;
    }
    check(status, error);
}

static nb::tuple patches(const Scene &self, size_t surface)
{
    size_t count = 0;
    lcor_error error = {};
    check(lcor_scene_patch_count(self.handle->scene, surface, &count, &error), error);
    Shape list;
    list.n = 1;
    list.dim[0] = static_cast<Py_ssize_t>(count);
    Shape triples = list;
    triples.dim[triples.n++] = 3;
    Array centres = new_array(triples, LCOR_F64), areas = new_array(list, LCOR_F64);
    Vec3 normal;
    const InUse in_use(self.handle->users);
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        status = lcor_scene_patch_geometry(
            self.handle->scene, surface, reinterpret_cast<double *>(centres.data),
            reinterpret_cast<double *>(areas.data), normal.data(), &error);
    }
    check(status, error);
    return nb::make_tuple(centres.object, areas.object, nb::cast(normal));
}

static nb::object intersect(const Scene &self, const Vec3 &origin, const Vec3 &direction,
                            double t_max)
{
    lcor_hit hit;
    if (!lcor_scene_intersect(self.handle->scene, origin.data(), direction.data(), t_max, &hit))
        return nb::none();
    return nb::make_tuple(hit.surface, hit.t, hit.u, hit.v, hit.front != 0);
}

void bind_scene(nb::module_ &m)
{
    nb::enum_<lcor_light_kind>(m, "LightKind")
        .value("point", LCOR_LIGHT_POINT)
        .value("spot", LCOR_LIGHT_SPOT)
        .value("directional", LCOR_LIGHT_DIRECTIONAL);
    nb::class_<lcor_light>(m, "Light").def_static("make", &light_of);
    nb::class_<Scene>(m, "Scene")
        .def(nb::init<>())
        .def("add_quad", &add_three<lcor_scene_add_quad>)
        .def("add_triangle", &add_three<lcor_scene_add_triangle>)
        .def("add_polygon", &add_polygon)
        .def("set_surface", &set_surface)
        .def("add_light", &add_light)
        .def("set_light", &set_light)
        .def("commit", &commit)
        .def_prop_ro("committed", [](const Scene &self) { return self.handle->committed.load(); })
        .def_prop_ro("surface_count",
                     [](const Scene &self) { return lcor_scene_surface_count(self.handle->scene); })
        .def_prop_ro("light_count",
                     [](const Scene &self) { return lcor_scene_light_count(self.handle->scene); })
        .def("patches", &patches,
             nb::sig(
                 "def patches(self, surface: int) -> tuple[typing.Any, typing.Any, list[float]]"))
        .def("intersect", &intersect,
             nb::sig("def intersect(self, origin: collections.abc.Sequence[float], "
                     "direction: collections.abc.Sequence[float], t_max: float) "
                     "-> tuple[int, float, float, float, bool] | None"));
}
