/* SPDX-License-Identifier: MIT */
#include "bind.hpp"
#include "scene.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/unique_ptr.h>

#include <cstdint>
#include <vector>

namespace
{

struct View {
    std::shared_ptr<SceneHandle> scene;
    lcor_view *view = nullptr;
    size_t width = 0, height = 0, pieces = 0;

    View() = default;
    View(const View &) = delete;
    View &operator=(const View &) = delete;
    ~View() { lcor_view_free(view); }

    /* visit(y, span, first piece, count) for every span from the upper left on */
    template <typename Visit> void each_span(Visit visit) const
    {
        size_t piece = 0;
        for (size_t y = 0; y < height; y++) {
            size_t count = 0;
            const lcor_span *spans = lcor_view_row(view, y, &count);
            for (size_t i = 0; i < count; i++) {
                const size_t n = spans[i].x1 - spans[i].x0;
                visit(y, spans[i], piece, n);
                piece += n;
            }
        }
    }
};

std::unique_ptr<View> make_view(const Scene &scene, const Vec3 &position, const Vec3 &forward,
                                const Vec3 &up, double fov_y, double height, double z_near,
                                double z_far, size_t size_x, size_t size_y, int lines,
                                const nb::bytes &cull_back)
{
    lcor_camera camera = {};
    std::copy(position.begin(), position.end(), camera.position);
    std::copy(forward.begin(), forward.end(), camera.forward);
    std::copy(up.begin(), up.end(), camera.up);
    camera.fov_y = fov_y;
    camera.height = height;
    camera.z_near = z_near;
    camera.z_far = z_far;
    camera.size_x = size_x;
    camera.size_y = size_y;
    lcor_view_options options = {};
    options.struct_size = sizeof options;
    options.lines = lines;
    if (cull_back.size()) {
        if (cull_back.size() != lcor_scene_surface_count(scene.handle->scene))
            throw nb::value_error("cull_back takes one flag for each surface");
        options.cull_back = static_cast<const unsigned char *>(cull_back.data());
    }
    auto view = std::make_unique<View>();
    view->scene = scene.handle;
    view->width = size_x;
    view->height = size_y;
    const InUse in_use(scene.handle->users);
    lcor_error error = {};
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        status = lcor_view_new(scene.handle->scene, &camera, &options, &view->view, &error);
        if (status == LCOR_OK)
            view->each_span(
                [&](size_t, const lcor_span &, size_t, size_t n) { view->pieces += n; });
    }
    check(status, error);
    return view;
}

Array list(size_t n, Py_ssize_t width, lcor_sample type)
{
    Shape shape;
    shape.n = width > 1 ? 2 : 1;
    shape.dim[0] = static_cast<Py_ssize_t>(n);
    shape.dim[1] = width;
    return new_array(shape, type);
}

double *doubles(const Array &array) { return reinterpret_cast<double *>(array.data); }

/* pixel (y, x), surface, coverage, uv, du, dv, depth of every piece */
nb::tuple pieces(const View &self)
{
    Array pixel = list(self.pieces, 2, LCOR_U16), coverage = list(self.pieces, 1, LCOR_F32);
    Array surface = list(self.pieces, 1, LCOR_F64);
    Array uv = list(self.pieces, 2, LCOR_F64), du = list(self.pieces, 2, LCOR_F64);
    Array dv = list(self.pieces, 2, LCOR_F64), depth = list(self.pieces, 1, LCOR_F64);
    {
        nb::gil_scoped_release nogil;
        std::vector<lcor_place> places(self.width);
        self.each_span([&](size_t y, const lcor_span &span, size_t first, size_t n) {
            lcor_view_places(self.view, y, &span, span.x0, n, places.data());
            for (size_t i = 0; i < n; i++) {
                const lcor_place &place = places[i];
                const size_t at = first + i;
                reinterpret_cast<uint16_t *>(pixel.data)[2 * at] = static_cast<uint16_t>(y);
                reinterpret_cast<uint16_t *>(pixel.data)[2 * at + 1] =
                    static_cast<uint16_t>(span.x0 + i);
                reinterpret_cast<float *>(coverage.data)[at] = span.coverage;
                doubles(surface)[at] = static_cast<double>(span.surface);
                doubles(depth)[at] = place.depth;
                for (size_t k = 0; k < 2; k++) {
                    doubles(uv)[2 * at + k] = place.uv[k];
                    doubles(du)[2 * at + k] = place.du[k];
                    doubles(dv)[2 * at + k] = place.dv[k];
                }
            }
        });
    }
    return nb::make_tuple(pixel.object, surface.object, coverage.object, uv.object, du.object,
                          dv.object, depth.object);
}

struct Field {
    lcor_field *field = nullptr;
    Field() = default;
    Field(const Field &) = delete;
    Field &operator=(const Field &) = delete;
    ~Field() { lcor_field_free(field); }
};

/* Irradiance of every piece. */
nb::object irradiance(View &self, Solution &solution, double tolerance, bool direct, int threads)
{
    const auto channels = lcor_solution_report(solution.solution)->channels;
    Array out = list(self.pieces, channels, LCOR_F64);
    Threads team(threads);
    lcor_field_options options = {};
    options.struct_size = sizeof options;
    options.tolerance = tolerance;
    options.parallel = team.parallel();
    const InUse scene_in_use(self.scene->users), in_use(solution.users);
    lcor_error error = {};
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        Field field;
        status = lcor_field_new(solution.solution, self.view, &options, &field.field, &error);
        std::vector<lcor_place> places(self.width);
        std::vector<double> uv(2 * self.width);
        self.each_span([&](size_t y, const lcor_span &span, size_t first, size_t n) {
            if (status != LCOR_OK)
                return;
            lcor_view_places(self.view, y, &span, span.x0, n, places.data());
            for (size_t i = 0; i < n; i++) {
                uv[2 * i] = places[i].uv[0];
                uv[2 * i + 1] = places[i].uv[1];
            }
            double *values = doubles(out) + first * static_cast<size_t>(channels);
            status = lcor_field_at(field.field, span.surface, n, uv.data(),
                                   direct ? nullptr : values, direct ? values : nullptr, &error);
        });
    }
    check(status, error);
    return out.object;
}

} // namespace

void bind_view(nb::module_ &m)
{
    nb::class_<View>(m, "View")
        .def_ro("pieces_count", &View::pieces)
        .def("pieces", &pieces, nb::sig("def pieces(self) -> tuple[typing.Any, ...]"))
        .def("irradiance", &irradiance,
             nb::sig("def irradiance(self, solution: Solution, tolerance: float, direct: bool, "
                     "threads: int) -> typing.Any"));
    m.def("make_view", &make_view);
}
