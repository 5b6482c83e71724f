/* SPDX-License-Identifier: MIT */
/* Plans for the tests of the correction. */
#ifndef LCOR_PLANNING_H
#define LCOR_PLANNING_H

#include "testing.h"

#include "correct/internal.h"
#include <lcor/correct.h>

/* The paper's device and eq 1, linear, all samples of one type, maps to match. */
static inline lcor_plan_options plain_options(lcor_sample type)
{
    lcor_plan_options o;

    memset(&o, 0, sizeof o);
    o.struct_size = sizeof o;
    o.contrast = 23.4;
    o.r_mean = 0.35;
    o.rho = 0.35;
    o.in_type = o.out_type = type;
    o.map_type = type == LCOR_F64 ? LCOR_F64 : LCOR_F32;
    return o;
}

static inline lcor_plan *make_plan(const lcor_plan_options *o)
{
    lcor_plan *plan = NULL;
    lcor_error e;

    if (lcor_plan_new(o, &plan, &e) != LCOR_OK)
        fail_msg("%s", e.text);
    return plan;
}

/* The test hook: run a plan on one kernel of this build, not on the best. */
static inline void force_kernel(lcor_plan *plan, const lcor_kernel *kernel)
{
    plan->kernel = *kernel;
}

#endif
