/* SPDX-License-Identifier: MIT */
/* lcor._core: the C calls with numpy arrays for rows. Names, defaults and documentation are in the
 * Python files beside this one. */
#include "bind.hpp"

NB_MODULE(_core, m)
{
    m.def("version", &lcor_version);
    bind_colour(m);
    bind_adapt(m);
    bind_correct(m);
    bind_scene(m);
    bind_radiosity(m);
    bind_view(m);
    bind_profile(m);
}
