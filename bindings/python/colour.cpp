/* SPDX-License-Identifier: MIT */
#include "bind.hpp"
#include "rows.hpp"

#include <cmath>

static Colour make_colour(lcor_primaries primaries, nb::handle matrix, lcor_transfer transfer,
                          double gamma, lcor_lightness lightness)
{
    Colour colour;
    lcor_error error = {};
    double numbers[9];
    const bool custom = !matrix.is_none();
    if (custom) {
        const Array array(matrix, "space", Kind::real);
        Shape wanted;
        wanted.n = 2;
        wanted.dim[0] = wanted.dim[1] = 3;
        if (!(array.shape == wanted))
            throw nb::value_error(
                ("space has shape " + array.shape.text() + ", a matrix has (3, 3)").c_str());
        ValueRows rows(array, wanted, LCOR_F64);
        for (size_t i = 0; i < 3; i++) {
            const auto *row = static_cast<const double *>(rows.get(i));
            std::copy(row, row + 3, numbers + 3 * i);
        }
    }
    check(lcor_colour_init(&colour.value, primaries, custom ? numbers : nullptr, transfer, gamma,
                           lightness, &error),
          error);
    return colour;
}

/* Integer samples become float32 0..1, since L*a*b* has no integer scale. */
static void scale_row(const Array &array, const void *from, size_t n, float *to)
{
    if (array.type == LCOR_U8) {
        const auto *p = static_cast<const uint8_t *>(from);
        for (size_t i = 0; i < 3 * n; i++)
            to[i] = static_cast<float>(p[i]) / 255.0f;
    } else {
        const auto *p = static_cast<const uint16_t *>(from);
        for (size_t i = 0; i < 3 * n; i++)
            to[i] = static_cast<float>(p[i]) / 65535.0f;
    }
}

template <bool to_lab>
static void convert_row(const lcor_colour *colour, lcor_sample type, size_t n, const void *in,
                        void *out)
{
    constexpr auto f64 = to_lab ? lcor_lab_from_rgb_row_f64 : lcor_rgb_from_lab_row_f64;
    constexpr auto f32 = to_lab ? lcor_lab_from_rgb_row_f32 : lcor_rgb_from_lab_row_f32;
    if (type == LCOR_F64)
        f64(colour, n, static_cast<const double *>(in), static_cast<double *>(out));
    else
        f32(colour, n, static_cast<const float *>(in), static_cast<float *>(out));
}

template <bool to_lab>
static nb::object convert_colours(nb::handle source, const Colour &colour, nb::handle target)
{
    Array in(source, to_lab ? "rgb" : "lab", to_lab ? Kind::colour : Kind::real);
    const bool integers = in.type == LCOR_U8 || in.type == LCOR_U16;
    const lcor_sample type = integers ? LCOR_F32 : in.type;
    Array out = target.is_none() ? new_array(in.shape, type)
                                 : Array::output(target, "out", Kind::real, in.shape);
    if (out.type != type)
        throw nb::type_error("out and the input differ in type: pass out of the input's type");
    check_overlap(out, in, true);
    const Py_ssize_t in_channel = in.take_channels(), out_channel = out.take_channels();
    {
        nb::gil_scoped_release nogil;
        PixelRows from(in, in_channel, in.shape, true), to(out, out_channel, in.shape, true);
        const size_t rows = row_count(in.shape), n = row_length(in.shape);
        std::vector<float> scaled(integers ? 3 * n : 0);
        for (size_t row = 0; row < rows; row++) {
            const void *texels = from.get(row);
            if (integers) {
                scale_row(in, texels, n, scaled.data());
                texels = scaled.data();
            }
            convert_row<to_lab>(&colour.value, type, n, texels, to.target(row));
            to.put(row);
        }
    }
    return out.object;
}

/* One number from each colour. */
template <double (*function)(const double[3])> static nb::object reduce_colours(nb::handle source)
{
    Array lab(source, "lab", Kind::real);
    const Py_ssize_t channel = lab.take_channels();
    Array out = new_array(lab.shape, lab.type);
    {
        nb::gil_scoped_release nogil;
        TripleRows from(lab, channel, lab.shape);
        const size_t rows = row_count(lab.shape), n = row_length(lab.shape);
        for (size_t row = 0; row < rows; row++) {
            const double *colours = from.get(row);
            for (size_t i = 0; i < n; i++) {
                const double value = function(colours + 3 * i);
                if (lab.type == LCOR_F64)
                    reinterpret_cast<double *>(out.data)[row * n + i] = value;
                else
                    reinterpret_cast<float *>(out.data)[row * n + i] = static_cast<float>(value);
            }
        }
    }
    return result(out);
}

void bind_colour(nb::module_ &m)
{
    nb::enum_<lcor_primaries>(m, "Primaries")
        .value("ntsc", LCOR_PRIMARIES_NTSC)
        .value("srgb", LCOR_PRIMARIES_SRGB)
        .value("custom", LCOR_PRIMARIES_CUSTOM);
    nb::enum_<lcor_transfer>(m, "Transfer")
        .value("linear", LCOR_TRANSFER_LINEAR)
        .value("srgb", LCOR_TRANSFER_SRGB)
        .value("gamma", LCOR_TRANSFER_GAMMA);
    nb::enum_<lcor_lightness>(m, "Lightness")
        .value("cie", LCOR_LIGHTNESS_CIE)
        .value("paper", LCOR_LIGHTNESS_PAPER);
    nb::class_<Colour>(m, "Colour")
        .def_static("make", &make_colour, "primaries"_a, "matrix"_a.none(), "transfer"_a, "gamma"_a,
                    "lightness"_a);
    m.def("rgb_to_lab", &convert_colours<true>, "rgb"_a.none(), "colour"_a, "out"_a.none(),
          nb::sig("def rgb_to_lab(rgb: object, colour: Colour, out: object) -> typing.Any"));
    m.def("lab_to_rgb", &convert_colours<false>, "lab"_a.none(), "colour"_a, "out"_a.none(),
          nb::sig("def lab_to_rgb(lab: object, colour: Colour, out: object) -> typing.Any"));
    m.def("hue", &reduce_colours<lcor_hue>, "lab"_a.none(),
          nb::sig("def hue(lab: object) -> typing.Any"));
    m.def("chroma", &reduce_colours<lcor_chroma>, "lab"_a.none(),
          nb::sig("def chroma(lab: object) -> typing.Any"));
}
