/* SPDX-License-Identifier: MIT */
#include "bind.hpp"
#include "mean.hpp"
#include "rows.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>

namespace
{

using PlanPointer = std::shared_ptr<const lcor_plan>;

/* What of a plan follows from the caller's arrays. */
struct Form {
    lcor_sample in, out, map;
    lcor_layout in_layout, out_layout;

    bool operator==(const Form &other) const
    {
        return in == other.in && out == other.out && map == other.map &&
               in_layout.pixel_step == other.in_layout.pixel_step &&
               in_layout.channel_step == other.in_layout.channel_step &&
               out_layout.pixel_step == other.out_layout.pixel_step &&
               out_layout.channel_step == other.out_layout.channel_step;
    }
};

/* The arrays of one call, broadcast together. */
struct Picture {
    Array rgb, illuminance;
    std::optional<Array> rho;
    Py_ssize_t channel = 0;
    Shape shape;     /* of pixels */
    lcor_sample map; /* type the map rows are read as */

    Picture(nb::handle rgb_source, nb::handle illuminance_source, nb::handle rho_source)
        : rgb(rgb_source, "rgb", Kind::colour),
          illuminance(illuminance_source, "illuminance", Kind::real)
    {
        if (!rho_source.is_none())
            rho.emplace(rho_source, "rho", Kind::real);
        channel = rgb.take_channels();
        shape = rgb.shape;
        broadcast(illuminance);
        if (rho)
            broadcast(*rho);
        const bool all_float = illuminance.type == LCOR_F32 && (!rho || rho->type == LCOR_F32);
        map = all_float ? LCOR_F32 : LCOR_F64;
    }

    void check_output(const Array &out)
    {
        rgb.give_channels();
        check_overlap(out, rgb, true);
        rgb.take_channels();
        check_overlap(out, illuminance, false);
        if (rho)
            check_overlap(out, *rho, false);
    }

    void broadcast(const Array &map)
    {
        const bool channel = has_channel(map.shape);
        if (channel || !shape.broadcast(map.shape))
            throw nb::value_error((std::string(map.name) + " of shape " + map.shape.text() +
                                   " does not fit pixels of shape " + rgb.shape.text() +
                                   (channel ? std::string(": pass ") + map.name + "[..., 0]" : ""))
                                      .c_str());
    }

  private:
    /* A map (H, W, 1) for pixels (H, W): by numpy's rules one picture a row of it when H = W. */
    bool has_channel(const Shape &map) const
    {
        const Shape &pixels = rgb.shape;
        return pixels.n >= 2 && map.n == pixels.n + 1 && map.dim[pixels.n] == 1 &&
               std::equal(map.dim, map.dim + pixels.n, pixels.dim);
    }
};

class Plan
{
  public:
    Plan(double contrast, double r_mean, double rho, double rho_ratio, double exponent,
         lcor_reading reading, lcor_gamut gamut, const Colour &colour, nb::handle tone_curve)
        : colour_(colour)
    {
        /* the C options read 0 as the default */
        if (rho == 0 || rho_ratio == 0 || exponent == 0)
            throw nb::value_error("rho, rho_ratio and exponent must be above 0");
        options_.struct_size = sizeof options_;
        options_.contrast = contrast;
        options_.r_mean = r_mean;
        options_.rho = rho;
        options_.rho_ratio = rho_ratio;
        options_.exponent = exponent;
        options_.reading = reading;
        options_.gamut = gamut;
        options_.colour = &colour_.value;
        if (!tone_curve.is_none())
            set_tone_curve(tone_curve);
        form({LCOR_F32, LCOR_F32, LCOR_F32, {3, 1}, {3, 1}}); /* judges every option */
    }

    nb::tuple apply(nb::handle rgb, nb::handle illuminance, nb::handle rho, nb::handle target)
    {
        return run(lcor_correct_row, rgb, illuminance, rho, target);
    }

    nb::tuple conventional(nb::handle rgb, nb::handle illuminance, nb::handle rho,
                           nb::handle target)
    {
        return run(lcor_conventional_row, rgb, illuminance, rho, target);
    }

    void add_to(Mean &mean, nb::handle rgb, nb::handle illuminance, nb::handle rho,
                nb::handle weights);

  private:
    template <typename Row>
    nb::tuple run(Row row_call, nb::handle rgb, nb::handle illuminance, nb::handle rho,
                  nb::handle target);
    void set_tone_curve(nb::handle source);
    PlanPointer form(const Form &wanted);

    lcor_plan_options options_ = {};
    Colour colour_;
    std::vector<float> tone_curve_;
    std::mutex mutex_;
    std::array<std::pair<Form, PlanPointer>, 4> plans_; /* the forms used last */
    size_t next_ = 0;
};

void Plan::set_tone_curve(nb::handle source)
{
    const Array curve(source, "tone_curve", Kind::real);
    if (curve.shape.n != 1)
        throw nb::value_error("tone_curve must have one dimension");
    const size_t n = row_length(curve.shape);
    ValueRows rows(curve, curve.shape, LCOR_F32);
    const auto *values = static_cast<const float *>(rows.get(0));
    tone_curve_.assign(values, values + n);
    options_.tone_curve = tone_curve_.data();
    options_.tone_size = n;
}

PlanPointer Plan::form(const Form &wanted)
{
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto &[have, plan] : plans_)
        if (plan && have == wanted)
            return plan;
    lcor_plan_options options = options_;
    options.in_type = wanted.in;
    options.out_type = wanted.out;
    options.map_type = wanted.map;
    options.in_layout = wanted.in_layout;
    options.out_layout = wanted.out_layout;
    lcor_plan *plan = nullptr;
    lcor_error error = {};
    check(lcor_plan_new(&options, &plan, &error), error);
    PlanPointer pointer(plan,
                        [](const lcor_plan *p) { lcor_plan_free(const_cast<lcor_plan *>(p)); });
    plans_[next_] = {wanted, pointer};
    next_ = (next_ + 1) % plans_.size();
    return pointer;
}

nb::tuple stats_tuple(const lcor_row_stats &s)
{
    return nb::make_tuple(s.pixels, s.clipped_low, s.clipped_high, s.out_of_gamut, s.non_finite,
                          s.first_bad_row, s.first_bad_pixel);
}

template <typename Row>
nb::tuple Plan::run(Row row_call, nb::handle rgb, nb::handle illuminance, nb::handle rho,
                    nb::handle target)
{
    Picture in(rgb, illuminance, rho);
    Shape wanted = in.shape;
    if (wanted.n == max_dims)
        throw nb::value_error("rgb has more than 32 dimensions");
    wanted.dim[wanted.n++] = 3;
    Array out = target.is_none() ? new_array(wanted, in.rgb.type)
                                 : Array::output(target, "out", Kind::colour, wanted);
    if (!target.is_none())
        in.check_output(out);
    const Py_ssize_t out_channel = out.take_channels();
    PixelRows texels(in.rgb, in.channel, in.shape), pixels(out, out_channel, in.shape);
    const PlanPointer plan = form({in.rgb.type, out.type, in.map, texels.layout, pixels.layout});
    lcor_row_stats stats = {};
    {
        nb::gil_scoped_release nogil;
        ValueRows light(in.illuminance, in.shape, in.map);
        std::optional<ValueRows> reflectance;
        if (in.rho)
            reflectance.emplace(*in.rho, in.shape, in.map);
        const size_t rows = row_count(in.shape), n = row_length(in.shape);
        for (size_t row = 0; row < rows; row++) {
            row_call(plan.get(), row, n, texels.get(row), light.get(row),
                     reflectance ? reflectance->get(row) : nullptr, pixels.target(row), &stats);
            pixels.put(row);
        }
    }
    return nb::make_tuple(out.object, stats_tuple(stats));
}

void Plan::add_to(Mean &mean, nb::handle rgb, nb::handle illuminance, nb::handle rho,
                  nb::handle weights)
{
    Picture in(rgb, illuminance, rho);
    std::optional<Array> w;
    if (!weights.is_none()) {
        w.emplace(weights, "weights", Kind::real);
        in.broadcast(*w);
    }
    PixelRows texels(in.rgb, in.channel, in.shape);
    const PlanPointer plan = form({in.rgb.type, in.rgb.type, in.map, texels.layout, {3, 1}});
    nb::gil_scoped_release nogil;
    ValueRows light(in.illuminance, in.shape, in.map);
    std::optional<ValueRows> reflectance, weight;
    if (in.rho)
        reflectance.emplace(*in.rho, in.shape, in.map);
    if (w)
        weight.emplace(*w, in.shape, LCOR_F64);
    const size_t rows = row_count(in.shape), n = row_length(in.shape);
    std::vector<double> r(n);
    const std::lock_guard<std::mutex> lock(mean.mutex);
    for (size_t row = 0; row < rows; row++) {
        lcor_plan_reflectance_row(plan.get(), n, texels.get(row), light.get(row),
                                  reflectance ? reflectance->get(row) : nullptr, r.data());
        lcor_mean_add(&mean.value, n, r.data(),
                      weight ? static_cast<const double *>(weight->get(row)) : nullptr);
    }
}

} // namespace

void bind_correct(nb::module_ &m)
{
    nb::enum_<lcor_reading>(m, "Reading")
        .value("patch", LCOR_READING_PATCH)
        .value("texel", LCOR_READING_TEXEL);
    nb::enum_<lcor_gamut>(m, "Gamut")
        .value("keep_hue", LCOR_GAMUT_KEEP_HUE)
        .value("clip", LCOR_GAMUT_CLIP);
    nb::class_<Plan>(m, "Plan")
        .def(nb::init<double, double, double, double, double, lcor_reading, lcor_gamut,
                      const Colour &, nb::handle>(),
             "contrast"_a, "r_mean"_a, "rho"_a, "rho_ratio"_a, "exponent"_a, "reading"_a, "gamut"_a,
             "colour"_a, "tone_curve"_a.none(),
             nb::sig("def __init__(self, contrast: float, r_mean: float, rho: float, "
                     "rho_ratio: float, exponent: float, reading: Reading, gamut: Gamut, "
                     "colour: Colour, tone_curve: object) -> None"))
        .def("apply", &Plan::apply, "rgb"_a.none(), "illuminance"_a.none(), "rho"_a.none(),
             "out"_a.none(),
             nb::sig("def apply(self, rgb: object, illuminance: object, rho: object, "
                     "out: object) -> tuple[typing.Any, tuple[int, ...]]"))
        .def("conventional", &Plan::conventional, "rgb"_a.none(), "illuminance"_a.none(),
             "rho"_a.none(), "out"_a.none(),
             nb::sig("def conventional(self, rgb: object, illuminance: object, rho: object, "
                     "out: object) -> tuple[typing.Any, tuple[int, ...]]"))
        .def("add_to", &Plan::add_to, "mean"_a, "rgb"_a.none(), "illuminance"_a.none(),
             "rho"_a.none(), "weights"_a.none(),
             nb::sig("def add_to(self, mean: Mean, rgb: object, illuminance: object, rho: object, "
                     "weights: object) -> None"));
}
