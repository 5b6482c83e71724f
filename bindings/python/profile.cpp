/* SPDX-License-Identifier: MIT */
#include "array.hpp"
#include "bind.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace
{

struct Profile {
    lcor_profile *profile = nullptr;

    Profile()
    {
        lcor_error error = {};
        check(lcor_profile_new(nullptr, &profile, &error), error);
    }
    explicit Profile(lcor_profile *parsed) : profile(parsed) {}
    Profile(const Profile &) = delete;
    Profile &operator=(const Profile &) = delete;
    ~Profile() { lcor_profile_free(profile); }
};

std::unique_ptr<Profile> parse(const nb::bytes &text, lcor_profile_black black)
{
    lcor_profile *profile = nullptr;
    lcor_error error = {};
    check(lcor_profile_import(text.c_str(), text.size(), black, nullptr, &profile, &error), error);
    return std::make_unique<Profile>(profile);
}

nb::bytes format(const Profile &self)
{
    size_t size = 0;
    lcor_error error = {};
    check(lcor_profile_format(self.profile, nullptr, 0, &size, &error), error);
    std::vector<char> text(size + 1);
    check(lcor_profile_format(self.profile, text.data(), text.size(), &size, &error), error);
    return nb::bytes(text.data(), size);
}

nb::dict evaluate(const Profile &self)
{
    lcor_profile_result r = {};
    lcor_error error = {};
    check(lcor_profile_evaluate(self.profile, &r, &error), error);
    nb::dict d;
    d["contrast"] = r.contrast;
    d["contrast_u95"] = r.contrast_u95;
    d["d_min"] = r.d_min;
    d["d_max"] = r.d_max;
    d["u_min"] = r.u_min;
    d["u_max"] = r.u_max;
    d["n_min"] = r.n_min;
    d["n_max"] = r.n_max;
    return d;
}

nb::object tone_curve(const Profile &self, size_t n)
{
    Shape shape;
    shape.n = 1;
    shape.dim[0] = static_cast<Py_ssize_t>(n);
    Array out = new_array(shape, LCOR_F32);
    lcor_error error = {};
    check(lcor_profile_tone_curve(self.profile, n, reinterpret_cast<float *>(out.data), &error),
          error);
    return out.object;
}

/* The numbers of one field, in the order of the C struct; None where not known. */
nb::object numbers(const double *values, size_t n, bool known)
{
    if (!known)
        return nb::none();
    nb::list list;
    for (size_t i = 0; i < n; i++)
        list.append(values[i]);
    return nb::tuple(list);
}

nb::dict reading(const Profile &self, size_t index)
{
    lcor_profile_reading r = {};
    lcor_error error = {};
    check(lcor_profile_reading_get(self.profile, index, &r, &error), error);
    nb::dict d;
    d["id"] = r.id ? r.id : "";
    d["name"] = r.name ? r.name : "";
    d["rgb"] = numbers(r.rgb, 3, r.has & LCOR_HAS_RGB);
    d["cmyk"] = numbers(r.cmyk, 4, r.has & LCOR_HAS_CMYK);
    d["density"] = numbers(r.density, 3, r.has & LCOR_HAS_COLOUR_DENSITY);
    d["visual"] = r.has & LCOR_HAS_VISUAL ? nb::cast(r.density[3]) : nb::none();
    d["xyz"] = numbers(r.xyz, 3, r.has & LCOR_HAS_XYZ);
    d["rejected"] = r.rejected != 0;
    return d;
}

/* Fill `out` from a Python sequence; returns `flag`, or 0 for None. */
unsigned take(nb::handle source, double *out, size_t n, unsigned flag, const char *name)
{
    if (source.is_none())
        return 0;
    const nb::tuple values = nb::tuple(nb::borrow(source));
    if (values.size() != n)
        throw nb::value_error(
            (std::string(name) + " takes " + std::to_string(n) + " numbers").c_str());
    for (size_t i = 0; i < n; i++)
        out[i] = nb::cast<double>(nb::float_(values[i]));
    return flag;
}

void add(Profile &self, nb::handle rgb, nb::handle cmyk, nb::handle density,
         std::optional<double> visual, nb::handle xyz, const std::optional<std::string> &id,
         const std::string &name)
{
    lcor_profile_reading r = {};
    r.id = id ? id->c_str() : nullptr;
    r.name = name.c_str();
    r.has = take(rgb, r.rgb, 3, LCOR_HAS_RGB, "rgb") |
            take(cmyk, r.cmyk, 4, LCOR_HAS_CMYK, "cmyk") |
            take(density, r.density, 3, LCOR_HAS_COLOUR_DENSITY, "density") |
            take(xyz, r.xyz, 3, LCOR_HAS_XYZ, "xyz");
    if (visual) {
        r.density[3] = *visual;
        r.has |= LCOR_HAS_VISUAL;
    }
    lcor_error error = {};
    check(lcor_profile_reading_add(self.profile, &r, &error), error);
}

void reject(Profile &self, size_t index, bool rejected)
{
    lcor_error error = {};
    check(lcor_profile_reading_reject(self.profile, index, rejected, &error), error);
}

void set_keyword(Profile &self, const std::string &name, const std::optional<std::string> &value)
{
    lcor_error error = {};
    check(lcor_profile_keyword_set(self.profile, name.c_str(), value ? value->c_str() : nullptr,
                                   &error),
          error);
}

nb::dict keywords(const Profile &self)
{
    nb::dict d;
    for (size_t i = 0; i < lcor_profile_keyword_count(self.profile); i++) {
        const char *name = lcor_profile_keyword_name(self.profile, i);
        d[name] = lcor_profile_keyword(self.profile, name);
    }
    return d;
}

void set_resolution(Profile &self, double step)
{
    lcor_error error = {};
    check(lcor_profile_resolution_set(self.profile, step, &error), error);
}

} // namespace

void bind_profile(nb::module_ &m)
{
    nb::enum_<lcor_profile_black>(m, "Black")
        .value("full", LCOR_BLACK_FULL)
        .value("darkest", LCOR_BLACK_DARKEST);
    nb::class_<Profile>(m, "Profile")
        .def(nb::init<>())
        .def_static("parse", &parse)
        .def("format", &format)
        .def("evaluate", &evaluate, nb::sig("def evaluate(self) -> dict[str, typing.Any]"))
        .def("tone_curve", &tone_curve, nb::sig("def tone_curve(self, n: int) -> typing.Any"))
        .def("reading", &reading, nb::sig("def reading(self, index: int) -> dict[str, typing.Any]"))
        .def("add", &add, "rgb"_a.none(), "cmyk"_a.none(), "density"_a.none(), "visual"_a.none(),
             "xyz"_a.none(), "id"_a.none(), "name"_a,
             nb::sig("def add(self, rgb: object, cmyk: object, density: object, "
                     "visual: float | None, xyz: object, id: str | None, name: str) -> None"))
        .def("reject", &reject)
        .def("set_keyword", &set_keyword, "name"_a, "value"_a.none())
        .def("keywords", &keywords, nb::sig("def keywords(self) -> dict[str, str]"))
        .def_prop_ro("contrast",
                     [](const Profile &self) { return lcor_profile_contrast(self.profile); })
        .def_prop_ro("contrast_u95",
                     [](const Profile &self) { return lcor_profile_contrast_u95(self.profile); })
        .def_prop_ro("count", [](const Profile &self) { return lcor_profile_count(self.profile); })
        .def_prop_ro("grey_levels",
                     [](const Profile &self) { return lcor_profile_grey_levels(self.profile); })
        .def_prop_rw(
            "resolution", [](const Profile &self) { return lcor_profile_resolution(self.profile); },
            &set_resolution)
        .def_prop_ro("black",
                     [](const Profile &self) { return lcor_profile_black_get(self.profile); });
}
