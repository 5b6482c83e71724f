/* SPDX-License-Identifier: MIT */
#include "bind.hpp"
#include "rows.hpp"
#include "scene.hpp"

#include <nanobind/stl/unique_ptr.h>

#include <stdexcept>

static std::unique_ptr<Solution> solve(const Scene &scene, double tolerance, lcor_norm norm,
                                       lcor_engine engine, uint64_t points, int channels,
                                       double max_seconds, uint64_t max_bytes, int threads,
                                       nb::handle callback)
{
    if (tolerance == 0) /* the C options read 0 as the default */
        throw nb::value_error("tolerance must be 1e-5 .. 1");
    auto solution = std::make_unique<Solution>(scene, threads, callback);
    lcor_radiosity_options options = {};
    options.struct_size = sizeof options;
    options.tolerance = tolerance;
    options.norm = norm;
    options.engine = engine;
    options.points = points;
    options.channels = channels;
    options.max_seconds = max_seconds;
    options.max_bytes = max_bytes;
    options.parallel = solution->threads.parallel();
    options.progress = solution->progress.progress();

    const InUse in_use(scene.handle->users);
    lcor_error error = {};
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        status = lcor_radiosity_solve(scene.handle->scene, &options, &solution->solution, &error);
    }
    check(status, error);
    return solution;
}

static void update(Solution &self)
{
    if (self.users)
        throw std::runtime_error(
            "the solution is being read by another call: update it afterwards");
    const InUse scene_in_use(self.scene->users), in_use(self.users);
    lcor_error error = {};
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        status = lcor_solution_update(self.solution, &error);
    }
    check(status, error);
}

static nb::dict report(const Solution &self)
{
    static const char *const engines[] = {"auto", "links", "gather", "paths"};
    const lcor_radiosity_report *r = lcor_solution_report(self.solution);
    nb::dict d;
    d["error_rms"] = r->error_rms;
    d["error_max"] = r->error_max;
    d["energy_defect"] = r->energy_defect;
    d["converged"] = r->converged != 0;
    d["iterations"] = r->iterations;
    d["channels"] = r->channels;
    d["engine"] = engines[r->engine];
    d["links"] = r->links;
    d["elements"] = r->elements;
    d["rays"] = r->rays;
    d["bytes"] = r->bytes;
    d["seconds"] = r->seconds;
    d["models"] = r->models;
    d["engine_reason"] = lcor_reason_text(r->engine_reason);
    d["visibility_reason"] = lcor_reason_text(r->visibility_reason);
    d["channels_reason"] = lcor_reason_text(r->channels_reason);
    d["links_seconds"] = r->links_seconds;
    d["gather_seconds"] = r->gather_seconds;
    d["paths_seconds"] = r->paths_seconds;
    d["pairs_apart"] = r->pairs_apart;
    d["pairs_open"] = r->pairs_open;
    d["pairs_tested"] = r->pairs_tested;
    d["surfaces_merged"] = r->surfaces_merged;
    d["merged_into"] = r->merged_into;
    return d;
}

/* Values of n places; three of each when the solution has three channels. */
static Array new_values(const Solution &self, Shape shape)
{
    if (shape.n < max_dims && lcor_solution_report(self.solution)->channels == 3)
        shape.dim[shape.n++] = 3;
    return new_array(shape, LCOR_F64);
}

static nb::object patches(Solution &self, size_t surface, lcor_value value, bool direct)
{
    size_t count = 0;
    lcor_error error = {};
    check(lcor_scene_patch_count(self.scene->scene, surface, &count, &error), error);
    Shape shape;
    shape.n = 1;
    shape.dim[0] = static_cast<Py_ssize_t>(count);
    Array out = new_values(self, shape);
    auto *values = reinterpret_cast<double *>(out.data);
    const InUse scene_in_use(self.scene->users), in_use(self.users);
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        status = lcor_solution_patches(self.solution, surface, value, direct ? nullptr : values,
                                       direct ? values : nullptr, &error);
    }
    check(status, error);
    return out.object;
}

static nb::object at(Solution &self, nb::handle point_source, nb::handle normal_source, bool direct)
{
    Array points(point_source, "points", Kind::real), normals(normal_source, "normals", Kind::real);
    const Py_ssize_t point_channel = points.take_channels();
    const Py_ssize_t normal_channel = normals.take_channels();
    Shape shape = points.shape;
    if (!shape.broadcast(normals.shape))
        throw nb::value_error(("normals for " + normals.shape.text() +
                               " places do not fit points for " + points.shape.text())
                                  .c_str());
    Array out = new_values(self, shape);
    const auto channels = static_cast<size_t>(lcor_solution_report(self.solution)->channels);
    const InUse scene_in_use(self.scene->users), in_use(self.users);
    lcor_error error = {};
    lcor_status status = LCOR_OK;
    {
        nb::gil_scoped_release nogil;
        TripleRows p(points, point_channel, shape), d(normals, normal_channel, shape);
        const size_t rows = row_count(shape), n = row_length(shape);
        auto *values = reinterpret_cast<double *>(out.data);
        for (size_t row = 0; row < rows && status == LCOR_OK; row++, values += n * channels)
            status = lcor_solution_at(self.solution, n, p.get(row), d.get(row),
                                      direct ? nullptr : values, direct ? values : nullptr, &error);
    }
    check(status, error);
    return result(out);
}

void bind_radiosity(nb::module_ &m)
{
    nb::enum_<lcor_norm>(m, "Norm").value("rms", LCOR_NORM_RMS).value("max", LCOR_NORM_MAX);
    nb::enum_<lcor_engine>(m, "Engine")
        .value("auto", LCOR_ENGINE_AUTO)
        .value("links", LCOR_ENGINE_LINKS)
        .value("gather", LCOR_ENGINE_GATHER)
        .value("paths", LCOR_ENGINE_PATHS);
    nb::enum_<lcor_value>(m, "Value")
        .value("average", LCOR_VALUE_AVERAGE)
        .value("centre", LCOR_VALUE_CENTRE);
    nb::class_<Solution>(m, "Solution")
        .def("update", &update)
        .def("report", &report, nb::sig("def report(self) -> dict[str, typing.Any]"))
        .def("patches", &patches,
             nb::sig("def patches(self, surface: int, value: Value, direct: bool) -> typing.Any"))
        .def("at", &at, "points"_a.none(), "normals"_a.none(), "direct"_a,
             nb::sig("def at(self, points: object, normals: object, direct: bool) -> typing.Any"));
    m.def("solve", &solve, "scene"_a, "tolerance"_a, "norm"_a, "engine"_a, "points"_a, "channels"_a,
          "max_seconds"_a, "max_bytes"_a, "threads"_a, "progress"_a.none(),
          nb::sig("def solve(scene: Scene, tolerance: float, norm: Norm, engine: Engine, "
                  "points: int, channels: int, max_seconds: float, max_bytes: int, "
                  "threads: int, progress: object) -> Solution"));
}
