/* SPDX-License-Identifier: MIT */
/* The rooms of the module; one file each. */
#ifndef LCOR_PYTHON_BIND_HPP
#define LCOR_PYTHON_BIND_HPP

#include <lcor/lcor.h>

#include <nanobind/nanobind.h>

/* A colour space, read-only once made. */
struct Colour {
    lcor_colour value;
};

void bind_colour(nanobind::module_ &m);
void bind_adapt(nanobind::module_ &m);
void bind_correct(nanobind::module_ &m);
void bind_scene(nanobind::module_ &m);
void bind_radiosity(nanobind::module_ &m);
void bind_view(nanobind::module_ &m);
void bind_profile(nanobind::module_ &m);

#endif
