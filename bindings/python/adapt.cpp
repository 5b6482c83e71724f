/* SPDX-License-Identifier: MIT */
#include "bind.hpp"
#include "mean.hpp"
#include "rows.hpp"

#include <cstring>

static double contrast_from_density(double d_max, double d_min)
{
    double contrast;
    lcor_error error = {};
    check(lcor_contrast_from_density(d_max, d_min, &contrast, &error), error);
    return contrast;
}

using Curve = lcor_status (*)(double, double, double, double, double, double *, lcor_error *);

/* Eq 8 or its inverse over an array. */
template <Curve curve>
static nb::object map_curve(nb::handle source, double j_mean, double j_min, double j_max,
                            double exponent)
{
    Array in(source, curve == lcor_adapt ? "j" : "h", Kind::real);
    Array out = new_array(in.shape, in.type);
    lcor_status status = LCOR_OK;
    lcor_error error = {};
    {
        nb::gil_scoped_release nogil;
        ValueRows values(in, in.shape, LCOR_F64);
        const size_t rows = row_count(in.shape), n = row_length(in.shape);
        for (size_t row = 0; row < rows && status == LCOR_OK; row++) {
            const auto *j = static_cast<const double *>(values.get(row));
            for (size_t i = 0; i < n && status == LCOR_OK; i++) {
                double h = 0;
                status = curve(j[i], j_mean, j_min, j_max, exponent, &h, &error);
                if (out.type == LCOR_F64)
                    reinterpret_cast<double *>(out.data)[row * n + i] = h;
                else
                    reinterpret_cast<float *>(out.data)[row * n + i] = static_cast<float>(h);
            }
        }
    }
    check(status, error);
    return result(out);
}

static nb::tuple adapt_range(double j_mean, double j_min, double j_max, double exponent)
{
    double j1, j2;
    lcor_error error = {};
    check(lcor_adapt_range(j_mean, j_min, j_max, exponent, &j1, &j2, &error), error);
    return nb::make_tuple(j1, j2);
}

/* Rows of r, and of weights where there are any, in double. */
class Samples
{
  public:
    Samples(nb::handle r, nb::handle weights) : r_(r, "r", Kind::real), shape(r_.shape)
    {
        if (weights.is_none())
            return;
        weights_.emplace(weights, "weights", Kind::real);
        if (!shape.broadcast(weights_->shape) || !(shape == r_.shape))
            throw nb::value_error(("weights of shape " + weights_->shape.text() +
                                   " do not fit r of shape " + r_.shape.text())
                                      .c_str());
    }

    template <typename Visit> void each_row(Visit visit)
    {
        ValueRows r(r_, shape, LCOR_F64);
        std::optional<ValueRows> w;
        if (weights_)
            w.emplace(*weights_, shape, LCOR_F64);
        const size_t rows = row_count(shape), n = row_length(shape);
        for (size_t row = 0; row < rows; row++)
            visit(row, n, static_cast<const double *>(r.get(row)),
                  w ? static_cast<const double *>(w->get(row)) : nullptr);
    }

  private:
    Array r_;
    std::optional<Array> weights_;

  public:
    Shape shape;
};

void Mean::add(nb::handle r, nb::handle weights)
{
    Samples samples(r, weights);
    nb::gil_scoped_release nogil;
    const std::lock_guard<std::mutex> lock(mutex);
    samples.each_row([this](size_t, size_t n, const double *values, const double *w) {
        lcor_mean_add(&value, n, values, w);
    });
}

void Mean::merge(const Mean &other)
{
    lcor_error error = {};
    const Mean copy(other);
    const std::lock_guard<std::mutex> lock(mutex);
    check(lcor_mean_merge(&value, &copy.value, &error), error);
}

double Mean::get(lcor_mean_method method) const
{
    double mean;
    lcor_error error = {};
    const std::lock_guard<std::mutex> lock(mutex);
    check(lcor_mean_get(&value, method, &mean, &error), error);
    return mean;
}

nb::bytes Mean::state() const
{
    const std::lock_guard<std::mutex> lock(mutex);
    return nb::bytes(reinterpret_cast<const char *>(&value), sizeof value);
}

void Mean::set_state(nb::bytes state)
{
    if (state.size() != sizeof value)
        throw nb::value_error("this Mean was saved by another version of lcor");
    const std::lock_guard<std::mutex> lock(mutex);
    std::memcpy(&value, state.c_str(), sizeof value);
}

double Mean::error(lcor_mean_method method) const
{
    const std::lock_guard<std::mutex> lock(mutex);
    return lcor_mean_error(&value, method);
}

void Mean::refine(lcor_mean_method method)
{
    const std::lock_guard<std::mutex> lock(mutex);
    lcor_mean_refine(&value, method);
}

/* Values are read where they lie, once more for each pass: lcor_geometric_mean without a copy. */
static double geometric_mean(nb::handle r, nb::handle weights, lcor_mean_method method)
{
    Samples samples(r, weights);
    double mean = 0;
    lcor_error error = {};
    lcor_status status;
    {
        nb::gil_scoped_release nogil;
        lcor_mean sums;
        lcor_mean_init(&sums);
        for (;;) {
            samples.each_row([&](size_t, size_t n, const double *values, const double *w) {
                lcor_mean_add(&sums, n, values, w);
            });
            status = lcor_mean_get(&sums, method, &mean, &error);
            if (status != LCOR_OK || lcor_mean_error(&sums, method) <= 0)
                break;
            lcor_mean_refine(&sums, method);
        }
    }
    check(status, error);
    return mean;
}

void bind_adapt(nb::module_ &m)
{
    nb::enum_<lcor_mean_method>(m, "MeanMethod")
        .value("adaptive", LCOR_MEAN_ADAPTIVE)
        .value("literal", LCOR_MEAN_LITERAL);
    m.def("contrast_from_density", &contrast_from_density, "d_max"_a, "d_min"_a);
    m.def("contrast_u95", &lcor_contrast_u95, "contrast"_a, "u_d_max"_a, "u_d_min"_a);
    m.def("adapt", &map_curve<lcor_adapt>, "j"_a.none(), "j_mean"_a, "j_min"_a, "j_max"_a,
          "exponent"_a,
          nb::sig("def adapt(j: object, j_mean: float, j_min: float, j_max: float, "
                  "exponent: float) -> typing.Any"));
    m.def("adapt_inverse", &map_curve<lcor_adapt_inverse>, "h"_a.none(), "j_mean"_a, "j_min"_a,
          "j_max"_a, "exponent"_a,
          nb::sig("def adapt_inverse(h: object, j_mean: float, j_min: float, j_max: float, "
                  "exponent: float) -> typing.Any"));
    m.def("adapt_range", &adapt_range,
          nb::sig("def adapt_range(j_mean: float, j_min: float, j_max: float, "
                  "exponent: float) -> tuple[float, float]"));
    m.def("geometric_mean", &geometric_mean, "r"_a.none(), "weights"_a.none(), "method"_a,
          nb::sig("def geometric_mean(r: object, weights: object, method: MeanMethod) -> float"));
    nb::class_<Mean>(m, "Mean")
        .def(nb::init<>())
        .def("add", &Mean::add, "r"_a.none(), "weights"_a.none(),
             nb::sig("def add(self, r: object, weights: object) -> None"))
        .def("merge", &Mean::merge, "other"_a)
        .def("get", &Mean::get, "method"_a)
        .def("error", &Mean::error, "method"_a)
        .def("refine", &Mean::refine, "method"_a)
        .def("state", &Mean::state)
        .def("set_state", &Mean::set_state, "state"_a);
}
