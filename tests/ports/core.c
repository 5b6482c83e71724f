/* SPDX-License-Identifier: MIT */
/* The portable core of liblcor (base, colour, adapt, correct, profile) on any processor: golden
 * vectors against their tolerances, then hashes of what every kind of row gives for the same float
 * input, the same from every instruction set that the processor has. All lines but those that begin
 * with '#' must be the same on every port. */
#include "port.h"

#include "correct/internal.h"

#include <lcor/adapt.h>
#include <lcor/colour.h>
#include <lcor/correct.h>
#include <lcor/profile.h>

#include <math.h>
#include <stdint.h>
#include <string.h>

#define PIXELS 259 /* no multiple of any block */

/* One line of tests/data/golden/pixel_cie.csv; run.sh makes the include file from it. */
static const struct golden {
    char reading;
    double rgb[3], alpha, rho, r_mean, contrast, out[3];
} golden[] = {
#include "golden.inc"
};

static int failures;

/* ---- output: text and whole numbers only ---- */

static void put_number(uint64_t x, unsigned base)
{
    char digits[24], *p = digits + sizeof digits;
    *--p = '\0';
    do
        *--p = "0123456789abcdef"[x % base];
    while ((x /= base) > 0);
    port_write(p);
}

static void line(const char *name, const char *detail, uint64_t value, unsigned base)
{
    port_write(name);
    port_write(" ");
    port_write(detail);
    port_write(" ");
    put_number(value, base);
    port_write("\n");
}

/* FNV-1a */
static uint64_t hash(const void *data, size_t size)
{
    const unsigned char *p = data;
    uint64_t h = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < size; i++)
        h = (h ^ p[i]) * UINT64_C(1099511628211);
    return h;
}

/* ---- memory: a fixed block, so that rows that allocate are found out ---- */

static union {
    double align;
    unsigned char bytes[3 << 20];
} arena;
static size_t arena_used, allocations;

static void *arena_alloc(size_t size, void *user)
{
    (void)user;
    allocations++;
    size = (size + 15) / 16 * 16;
    if (size > sizeof arena.bytes - arena_used)
        return NULL;
    arena_used += size;
    return arena.bytes + arena_used - size;
}

static void arena_free(void *p, void *user) { (void)p, (void)user; }

static const lcor_allocator allocator = {arena_alloc, arena_free, NULL};

/* ---- golden vectors ---- */

static void check_golden(void)
{
    double worst32 = 0.0, worst64 = 0.0;
    const size_t count = sizeof golden / sizeof golden[0];
    for (size_t i = 0; i < count; i++) {
        const struct golden *g = &golden[i];
        for (int wide = 0; wide < 2; wide++) {
            lcor_plan_options o;
            lcor_plan *plan = NULL;
            double out64[3];
            float in32[3], out32[3];
            const float light32 = (float)g->alpha, rho32 = (float)g->rho;
            memset(&o, 0, sizeof o);
            o.struct_size = sizeof o;
            o.contrast = g->contrast;
            o.r_mean = g->r_mean;
            o.reading = g->reading == 'B' ? LCOR_READING_TEXEL : LCOR_READING_PATCH;
            o.in_type = o.out_type = wide ? LCOR_F64 : LCOR_F32;
            o.map_type = wide ? LCOR_F64 : LCOR_F32;
            o.allocator = allocator;
            arena_used = 0;
            if (lcor_plan_new(&o, &plan, NULL) != LCOR_OK) {
                failures++;
                continue;
            }
            for (int k = 0; k < 3; k++)
                in32[k] = (float)g->rgb[k];
            if (wide)
                lcor_correct_row(plan, 0, 1, g->rgb, &g->alpha, &g->rho, out64, NULL);
            else
                lcor_correct_row(plan, 0, 1, in32, &light32, &rho32, out32, NULL);
            for (int k = 0; k < 3; k++) {
                const double error = fabs((wide ? out64[k] : (double)out32[k]) - g->out[k]);
                double *worst = wide ? &worst64 : &worst32;
                if (!(error <= *worst))
                    *worst = error;
            }
        }
    }
    failures += !(worst32 <= 3e-6) + !(worst64 <= 1e-13);
    line("golden", "vectors", count, 10);
    line("golden", "worst error of float rows, 1e-9", (uint64_t)(worst32 * 1e9), 10);
    line("golden", "worst error of double rows, 1e-18", (uint64_t)(worst64 * 1e18), 10);
}

/* ---- rows ---- */

static uint32_t random_state = 1;

static double random_unit(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (double)(random_state >> 8) * (1.0 / 16777216.0);
}

static double texels[3 * PIXELS]; /* room for any sample type */
static double corrected[3 * PIXELS];
static double corrected_again[3 * PIXELS];
static float light[PIXELS];
static const size_t sample_size[] = {4, 8, 1, 2}; /* by lcor_sample */

static void make_texels(lcor_sample type)
{
    unsigned char *bytes = (unsigned char *)texels;
    for (size_t i = 0; i < 3 * PIXELS; i++) {
        const double x = i < 9 ? (double)(i / 3 % 2) : random_unit();
        const float f = (float)x;
        const uint8_t u8 = (uint8_t)(x * 255.0);
        const uint16_t u16 = (uint16_t)(x * 65535.0);
        const void *from = type == LCOR_F32   ? (const void *)&f
                           : type == LCOR_F64 ? (const void *)&x
                           : type == LCOR_U8  ? (const void *)&u8
                                              : (const void *)&u16;
        memcpy(bytes + i * sample_size[type], from, sample_size[type]);
    }
}

/* Kernels other than the one that plans choose give the same row. */
static void check_kernels(lcor_plan *plan, size_t size)
{
    lcor_kernel kernel;

    for (size_t v = 1; lcor_internal_kernel(v, &kernel); v++) {
        plan->kernel = kernel;
        lcor_correct_row(plan, 0, PIXELS, texels, light, NULL, corrected_again, NULL);
        if (memcmp(corrected, corrected_again, size) != 0) {
            port_write("# other bytes from the kernel ");
            port_write(kernel.name);
            port_write("\n");
            failures++;
        }
    }
}

/* One kind of row; *stack becomes the deepest of all. */
static void check_row(const char *name, lcor_sample in, lcor_sample out, lcor_reading reading,
                      lcor_gamut gamut, const lcor_colour *colour, double exponent, size_t *stack)
{
    lcor_plan_options o;
    lcor_plan *plan = NULL;
    lcor_row_stats stats;
    memset(&o, 0, sizeof o);
    memset(&stats, 0, sizeof stats);
    o.struct_size = sizeof o;
    o.contrast = 23.4;
    o.r_mean = reading == LCOR_READING_TEXEL ? 0.25 : 0.4;
    o.exponent = exponent;
    o.reading = reading;
    o.gamut = gamut;
    o.colour = colour;
    o.in_type = in;
    o.out_type = out;
    o.allocator = allocator;
    arena_used = 0;
    if (lcor_plan_new(&o, &plan, NULL) != LCOR_OK) {
        failures++;
        return;
    }
    random_state = 1;
    make_texels(in);
    for (size_t i = 0; i < PIXELS; i++)
        light[i] = (float)(2.5 * random_unit());
    const size_t before = allocations;
    port_stack_paint();
    lcor_correct_row(plan, 0, PIXELS, texels, light, NULL, corrected, &stats);
    const size_t used = port_stack_used();
    *stack = used > *stack ? used : *stack;
    failures += allocations != before;
    check_kernels(plan, 3 * PIXELS * sample_size[out]);
    line("row", name, hash(corrected, 3 * PIXELS * sample_size[out]), 16);
    line("row", "pixels too dark, too light, outside the gamut",
         stats.clipped_low * 1000000 + stats.clipped_high * 1000 + stats.out_of_gamut, 10);
}

static void check_rows(void)
{
    static const char *const names[4][4] = {
        {"f32-f32", "f32-f64", "f32-u8", "f32-u16"},
        {"f64-f32", "f64-f64", "f64-u8", "f64-u16"},
        {"u8-f32", "u8-f64", "u8-u8", "u8-u16"},
        {"u16-f32", "u16-f64", "u16-u8", "u16-u16"},
    };
    lcor_colour srgb;
    size_t stack = 0;
    failures += lcor_colour_init(&srgb, LCOR_PRIMARIES_SRGB, NULL, LCOR_TRANSFER_SRGB, 1.0,
                                 LCOR_LIGHTNESS_CIE, NULL) != LCOR_OK;
    for (int in = 0; in < 4; in++) {
        for (int out = 0; out < 4; out++) {
            const lcor_sample i = (lcor_sample)in, o = (lcor_sample)out;
            const char *name = names[in][out];
            check_row(name, i, o, LCOR_READING_PATCH, LCOR_GAMUT_KEEP_HUE, NULL, 1.0, &stack);
            check_row(name, i, o, LCOR_READING_TEXEL, LCOR_GAMUT_CLIP, &srgb, 1.0, &stack);
            check_row(name, i, o, LCOR_READING_PATCH, LCOR_GAMUT_KEEP_HUE, &srgb, 0.7, &stack);
        }
    }
    line("#", "stack of the deepest row call, bytes:", stack, 10);
    failures += stack > 4096;
}

/* ---- the rest of the core ---- */

static void check_mean(void)
{
    static lcor_mean mean;
    static double r[PIXELS];
    double m[2] = {0.0, 0.0};
    lcor_mean_init(&mean);
    random_state = 7;
    for (int part = 0; part < 10; part++) {
        for (size_t i = 0; i < PIXELS; i++)
            r[i] = i % 50 ? random_unit() : 0.0;
        lcor_mean_add(&mean, PIXELS, r, NULL);
    }
    failures += lcor_mean_get(&mean, LCOR_MEAN_ADAPTIVE, &m[0], NULL) != LCOR_OK;
    failures += lcor_mean_get(&mean, LCOR_MEAN_LITERAL, &m[1], NULL) != LCOR_OK;
    line("mean", "adaptive", hash(&m[0], sizeof m[0]), 16);
    line("mean", "literal", hash(&m[1], sizeof m[1]), 16);
}

static void check_lab(void)
{
    lcor_colour colour;
    failures += lcor_colour_init(&colour, LCOR_PRIMARIES_NTSC, NULL, LCOR_TRANSFER_SRGB, 1.0,
                                 LCOR_LIGHTNESS_CIE, NULL) != LCOR_OK;
    random_state = 3;
    make_texels(LCOR_F32);
    lcor_lab_from_rgb_row_f32(&colour, PIXELS, (const float *)texels, (float *)corrected);
    line("lab", "f32", hash(corrected, 3 * PIXELS * sizeof(float)), 16);
    lcor_rgb_from_lab_row_f32(&colour, PIXELS, (const float *)corrected, (float *)corrected);
    line("rgb", "f32", hash(corrected, 3 * PIXELS * sizeof(float)), 16);
}

static void check_profile(void)
{
    static const char text[] = "CGATS.17\nNUMBER_OF_FIELDS 5\nBEGIN_DATA_FORMAT\n"
                               "SAMPLE_ID RGB_R RGB_G RGB_B D_VIS\nEND_DATA_FORMAT\n"
                               "NUMBER_OF_SETS 4\nBEGIN_DATA\n1 255 255 255 0.05\n"
                               "2 255 255 255 0.07\n3 0 0 0 1.43\n4 0 0 0 1.45\nEND_DATA\n";
    static char printed[4096];
    lcor_profile *profile = NULL;
    size_t size = 0;
    arena_used = 0;
    if (lcor_profile_parse(text, sizeof text - 1, &allocator, &profile, NULL) != LCOR_OK) {
        failures++;
        return;
    }
    line("profile", "contrast, 1e-6", (uint64_t)(lcor_profile_contrast(profile) * 1e6 + 0.5), 10);
    failures += lcor_profile_format(profile, printed, sizeof printed, &size, NULL) != LCOR_OK;
    line("profile", "text", hash(printed, size), 16);
    lcor_profile_free(profile);
}

int main(void)
{
    lcor_kernel best;

    lcor_internal_kernel(0, &best);
    port_write("# kernel ");
    port_write(best.name);
    port_write("\n");
    check_golden();
    check_rows();
    check_mean();
    check_lab();
    check_profile();
    line("failures", "", (uint64_t)failures, 10);
    return failures != 0;
}
