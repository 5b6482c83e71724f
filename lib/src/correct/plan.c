/* SPDX-License-Identifier: MIT */
#include "correct/internal.h"
#include "correct/sample.h"

#include "base/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

static LCOR_COLD lcor_status check_numbers(const lcor_plan_options *o, lcor_error *err)
{
    if (!(o->contrast > 1.0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "contrast must be > 1 (eq 13a)");
    if (!(o->r_mean >= 0.0 && o->r_mean <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "r_mean must be finite and >= 0 (section 4.3)");
    if (!(o->rho >= 0.0 && o->rho <= 1.0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "rho must be in 0..1 (section 4.2)");
    if (!(o->rho_ratio >= 0.0 && o->rho_ratio <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "rho_ratio must be finite and >= 0 (section 5.2)");
    if (!(o->exponent >= 0.0 && o->exponent <= DBL_MAX))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1,
                                  "exponent must be finite and >= 0 (t of eq 8)");
    return LCOR_OK;
}

static LCOR_COLD lcor_status check_choices(const lcor_plan_options *o, lcor_error *err)
{
    if ((unsigned)o->reading > LCOR_READING_TEXEL)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "unknown reading %d", (int)o->reading);
    if ((unsigned)o->gamut > LCOR_GAMUT_CLIP)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "unknown gamut rule %d", (int)o->gamut);
    if ((unsigned)o->in_type > LCOR_U16 || (unsigned)o->out_type > LCOR_U16)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "unknown sample type %d or %d",
                                  (int)o->in_type, (int)o->out_type);
    if (o->map_type != LCOR_F32 && o->map_type != LCOR_F64)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "map_type must be LCOR_F32 or LCOR_F64, not %d",
                                  (int)o->map_type);
    return LCOR_OK;
}

/* Channels of one pixel, or of neighbours, must not fall on one another. */
static LCOR_COLD lcor_status check_layout(lcor_layout *layout, const char *which, lcor_error *err)
{
    const size_t p = layout->pixel_step, c = layout->channel_step;

    if (p == 0 && c == 0) {
        layout->pixel_step = 3;
        layout->channel_step = 1;
        return LCOR_OK;
    }
    if (p == 0 || c == 0 || (p < c && c % p != 0 && c < 3 * p) || (p >= c && p < 2 * c + 1) ||
        p > (size_t)-1 / 64 || c > (size_t)-1 / 64)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "%s: samples overlap (interleaved is {3, 1}, planar {1, size})",
                                  which);
    return LCOR_OK;
}

static LCOR_COLD lcor_status check_tone(const lcor_plan_options *o, lcor_error *err)
{
    if ((o->tone_curve == NULL) != (o->tone_size == 0) || o->tone_size == 1 ||
        o->tone_size > (1u << 24))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "tone_curve needs a tone_size of 2 or more, and only then");
    for (size_t i = 0; i < o->tone_size; i++)
        if (!(o->tone_curve[i] >= 0.0f && o->tone_curve[i] <= 1.0f) ||
            (i > 0 && o->tone_curve[i] < o->tone_curve[i - 1]))
            return lcor_internal_fail(err, LCOR_ERR_DOMAIN, (long)i,
                                      "tone_curve[%zu] must be in 0..1 and not below the one "
                                      "before it",
                                      i);
    return LCOR_OK;
}

static LCOR_COLD void digest(lcor_plan *p, const lcor_plan_options *o)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            p->f_from_rgb[3 * i + j] = p->colour.to_xyz[3 * i + j] / p->colour.white[i];
            p->rgb_from_f[3 * i + j] = p->colour.from_xyz[3 * i + j] * p->colour.white[j];
        }
    p->gain = 0.5 * (1.0 + 2.0 / (o->contrast - 1.0));
    p->r_mean = o->r_mean;
    p->rho = o->rho > 0.0 ? o->rho : 0.5;
    p->rho_ratio = o->rho_ratio > 0.0 ? o->rho_ratio : 1.0;
    p->exponent = o->exponent > 0.0 ? o->exponent : 1.0;
    p->reading = o->reading;
    p->gamut = o->gamut;
    p->in_type = o->in_type;
    p->out_type = o->out_type;
    p->map_type = o->map_type;
    p->tone_size = o->tone_size;
}

static int is_moderate(double x) { return x == 0.0 || (x > 1e-25 && x < 1e25); }

/* Stored values are `unit` times 0..1. */
static LCOR_COLD void set_transfer(const lcor_colour *c, double unit, lcor_kernel_constants *k)
{
    k->srgb = (lcor_srgb){.top = (float)(1e12 * unit), /* its power stays far from infinity */
                          .knee = (float)(0.04045 * unit),
                          .slope = (float)(1.0 / 12.92 / unit),
                          .scale = (float)(1.0 / 1.055 / unit),
                          .offset = 0.055f / 1.055f};
    k->decode = (lcor_power){.top = 18446744073709551616.0f, /* 2^64 */
                             .scale = (float)(1.0 / unit),
                             .exponent = (float)c->gamma};
    k->encode = (lcor_power){.top = 1.0f, .scale = 1.0f, .exponent = (float)(1.0 / c->gamma)};
}

/* sRGB and gamma are so steep near black that errors of light show there, the more the larger the
 * factors that light is multiplied with: as a share of Ynew, below what a channel has to be exact.
 */
static LCOR_COLD float steep_below(const lcor_kernel_constants *k)
{
    float largest = 0.0f;

    for (int i = 0; i < 3; i++) {
        const float sum = fabsf(k->n[i][0]) + fabsf(k->n[i][1]);

        largest = sum > largest ? sum : largest;
    }
    return 0.008f * largest * largest;
}

/* Constants of the float path; in_double stays where that path would lose accuracy. */
static LCOR_COLD void prepare_kernel(lcor_plan *p)
{
    lcor_kernel_constants *k = &p->k;
    const double slope = p->r_mean > 0.0 ? p->gain / p->r_mean : 0.0;
    const int steep = p->gain > 16.0; /* float T would be off by 1e-6 and more */
    const int linear = p->colour.transfer == LCOR_TRANSFER_LINEAR;
    const double unit = lcor_internal_unit(p->in_type);

    lcor_internal_kernel(0, &p->kernel);
    p->in_double = 1;
    if (p->colour.lightness != LCOR_LIGHTNESS_CIE || p->in_type == LCOR_F64 ||
        p->out_type == LCOR_F64 || p->colour.gamma < 0.1 || p->colour.gamma > 10.0 ||
        p->rho_ratio < 1e-6 || p->rho_ratio > 1e6 || p->rho < 1e-6 ||
        (p->reading == LCOR_READING_TEXEL && (p->exponent != 1.0 || steep)))
        return;
    for (int i = 0; i < 9; i++) {
        if (!(fabs(p->f_from_rgb[i]) < 1e3 && fabs(p->rgb_from_f[i]) < 1e3))
            return;
        k->m[i / 3][i % 3] = (float)(linear ? p->f_from_rgb[i] / unit : p->f_from_rgb[i]);
    }
    for (size_t i = 0; i < 3; i++) {
        k->n[i][0] = (float)p->rgb_from_f[3 * i];
        k->n[i][1] = (float)p->rgb_from_f[3 * i + 2];
    }
    p->settles = p->gamut == LCOR_GAMUT_KEEP_HUE;
    k->dark = 4e-6f;
    if (!linear && p->out_type == LCOR_F32 && p->tone_size == 0) {
        p->settles = 1;
        k->dark = steep_below(k);
    }
    k->offset = (float)(0.5 - p->gain);
    k->w = p->reading == LCOR_READING_TEXEL ? k->offset : 0.0f;
    k->ratio = (float)p->rho_ratio;
    k->over_rho = (float)(p->rho_ratio / p->rho);
    set_transfer(&p->colour, unit, k);
    p->decode_by_power = !linear && p->in_type != LCOR_U8;
    p->float_maps = p->map_type == LCOR_F32 && p->exponent == 1.0 && !steep && is_moderate(slope);
    if (p->float_maps) {
        k->slope = (float)slope;
        k->slope_rho = (float)(slope * p->rho);
        k->slope_texel = (float)(slope * p->rho_ratio);
    }
    p->in_double = 0;
}

LCOR_COLD lcor_status lcor_plan_new(const lcor_plan_options *options, lcor_plan **out,
                                    lcor_error *err)
{
    lcor_plan_options o;
    lcor_plan p, *plan;
    lcor_status status;
    size_t size, codes = 0;
    double *linear;
    float *floats;

    if (options == NULL || out == NULL)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "options or out is NULL");
    if (options->struct_size != sizeof o)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "options.struct_size must be sizeof(lcor_plan_options)");
    o = *options;
    memset(&p, 0, sizeof p);
    if ((status = check_numbers(&o, err)) != LCOR_OK ||
        (status = check_choices(&o, err)) != LCOR_OK ||
        (status = check_layout(&o.in_layout, "in_layout", err)) != LCOR_OK ||
        (status = check_layout(&o.out_layout, "out_layout", err)) != LCOR_OK ||
        (status = check_tone(&o, err)) != LCOR_OK ||
        (status = lcor_internal_allocator(&o.allocator, &p.allocator, err)) != LCOR_OK)
        return status;
    if (o.colour != NULL)
        p.colour = *o.colour;
    else if ((status = lcor_colour_init(&p.colour, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_LINEAR,
                                        1.0, LCOR_LIGHTNESS_CIE, err)) != LCOR_OK)
        return status;
    p.in = o.in_layout;
    p.out = o.out_layout;
    digest(&p, &o);

    prepare_kernel(&p);
    if (p.in_type == LCOR_U8 && p.colour.transfer != LCOR_TRANSFER_LINEAR)
        codes = 256;
    size = sizeof p + codes * (sizeof *linear + sizeof *floats) +
           o.tone_size * sizeof *o.tone_curve; /* bounded */
    plan = lcor_internal_alloc(&p.allocator, size);
    if (plan == NULL)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a plan of %zu bytes",
                                  size);
    linear = (double *)(void *)(plan + 1);
    floats = (float *)(void *)(linear + codes);
    for (size_t i = 0; i < codes; i++) {
        linear[i] = lcor_transfer_to_linear(&p.colour, (double)i / 255.0);
        floats[i] = (float)linear[i];
    }
    p.decode_table = codes != 0 ? linear : NULL;
    p.decode_floats = floats;
    if (o.tone_size != 0)
        p.tone = memcpy(floats + codes, o.tone_curve, o.tone_size * sizeof *o.tone_curve);
    *plan = p;
    *out = plan;
    return LCOR_OK;
}

void lcor_plan_free(lcor_plan *plan)
{
    if (plan != NULL) {
        const lcor_allocator allocator = plan->allocator;

        lcor_internal_free(&allocator, plan);
    }
}
