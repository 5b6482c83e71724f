/* SPDX-License-Identifier: MIT */
/* Speed against accuracy of the row calls: every kernel of this build, single thread.
 *
 *   bench_kernel [FILE.json] [MEGAPIXELS] [PATH]
 *
 * PATH: one row of the table below only, for example "f32 clip".
 *
 * Each time is the best of several runs; the loop it is compared with, which only reads and writes
 * as many bytes as a float row does, runs between them. Errors are against the double reference on
 * the first 10^6 pixels. Two pixels in a hundred leave the gamut. */
#include "correct/internal.h"

#include <lcor/lcor.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROW = 4096, RUNS = 5, CHECKED = 1000000 };

typedef struct pictures {
    size_t n;
    float *rgb, *light, *f, *out;
    uint8_t *rgb8;
    uint16_t *rgb16;
    double *exact;
} pictures;

typedef struct path {
    const char *name;
    lcor_sample type;
    lcor_gamut gamut;
    lcor_transfer transfer;
    int texture;
} path;

static const path PATHS[] = {
    {"f32 clip", LCOR_F32, LCOR_GAMUT_CLIP, LCOR_TRANSFER_LINEAR, 0},
    {"f32 keep-hue", LCOR_F32, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_LINEAR, 0},
    {"f32 texture planes clip", LCOR_F32, LCOR_GAMUT_CLIP, LCOR_TRANSFER_LINEAR, 1},
    {"u8 clip", LCOR_U8, LCOR_GAMUT_CLIP, LCOR_TRANSFER_LINEAR, 0},
    {"u8 keep-hue", LCOR_U8, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_LINEAR, 0},
    {"u16 keep-hue", LCOR_U16, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_LINEAR, 0},
    {"u8 sRGB keep-hue", LCOR_U8, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_SRGB, 0},
    {"f32 sRGB keep-hue", LCOR_F32, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_SRGB, 0},
};

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void *need(void *memory)
{
    if (memory == NULL) {
        fprintf(stderr, "bench_kernel: not enough memory; give a smaller number of megapixels\n");
        exit(1);
    }
    return memory;
}

static void make_pictures(pictures *p)
{
    uint64_t s = UINT64_C(88172645463325252);

    p->rgb = need(malloc(3 * p->n * sizeof *p->rgb));
    p->light = need(malloc(p->n * sizeof *p->light));
    p->f = need(malloc(3 * p->n * sizeof *p->f));
    p->out = need(calloc(3 * p->n, sizeof *p->out));
    p->rgb8 = need(malloc(3 * p->n));
    p->rgb16 = need(malloc(3 * p->n * sizeof *p->rgb16));
    p->exact = need(malloc(3 * CHECKED * sizeof *p->exact));
    for (size_t i = 0; i < 4 * p->n; i++) {
        float v;

        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        v = (float)(s >> 40) / 16777216.0f;
        if (i < 3 * p->n) {
            p->rgb[i] = v;
            p->rgb8[i] = (uint8_t)(s >> 56);
            p->rgb16[i] = (uint16_t)(s >> 48);
        } else {
            p->light[i - 3 * p->n] = 2.2f * v;
        }
    }
    for (size_t i = 0; i < p->n; i += 250) { /* of the random ones 1.7 % do */
        static const uint8_t outside[3] = {246, 235, 19};

        for (size_t k = 0; k < 3; k++) {
            p->rgb8[3 * i + k] = outside[k];
            p->rgb16[3 * i + k] = (uint16_t)(outside[k] * 257);
            p->rgb[3 * i + k] = (float)outside[k] / 255.0f;
        }
        p->light[i] = 0.757f;
    }
}

static lcor_plan *make_plan(const path *what, lcor_sample type)
{
    lcor_plan_options o;
    lcor_colour colour;
    lcor_error e;
    lcor_plan *plan;

    memset(&o, 0, sizeof o);
    o.struct_size = sizeof o;
    o.contrast = 23.4;
    o.r_mean = o.rho = 0.35;
    o.gamut = what->gamut;
    o.in_type = o.out_type = type;
    o.map_type = LCOR_F32;
    o.colour = &colour;
    if (lcor_colour_init(&colour, LCOR_PRIMARIES_NTSC, NULL, what->transfer, 1.0,
                         LCOR_LIGHTNESS_CIE, &e) != LCOR_OK ||
        lcor_plan_new(&o, &plan, &e) != LCOR_OK) {
        fprintf(stderr, "bench_kernel: %s\n", e.text);
        exit(1);
    }
    return plan;
}

static const void *texels_of(const pictures *p, lcor_sample type, size_t pixel)
{
    if (type == LCOR_U8)
        return p->rgb8 + 3 * pixel;
    return type == LCOR_U16 ? (const void *)(p->rgb16 + 3 * pixel)
                            : (const void *)(p->rgb + 3 * pixel);
}

static void run(const pictures *p, const path *what, const lcor_plan *plan)
{
    const size_t size = what->type == LCOR_U8 ? 1 : what->type == LCOR_U16 ? 2 : 4;

    for (size_t at = 0; at < p->n; at += ROW) {
        const size_t n = p->n - at < ROW ? p->n - at : ROW;
        void *out = (char *)p->out + 3 * at * size;

        if (what->texture)
            lcor_correct_texture_row(plan, 0, n, p->f + at, p->n, p->light + at, NULL, out, NULL);
        else
            lcor_correct_row(plan, 0, n, texels_of(p, what->type, at), p->light + at, NULL, out,
                             NULL);
    }
}

/* For the machine's best instruction set, as the kernels are. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define BEST __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BEST
#endif

/* Reads 16 bytes and writes 12 for each pixel, and one multiplication each so that it must. */
BEST static void only_move(const float *restrict rgb, const float *restrict light,
                           float *restrict out, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        out[3 * i] = rgb[3 * i] * light[i];
        out[3 * i + 1] = rgb[3 * i + 1] * light[i];
        out[3 * i + 2] = rgb[3 * i + 2] * light[i];
    }
}

/* Percent of the pixels that leave the gamut. */
static double outside(const pictures *p)
{
    lcor_plan *plan = make_plan(&PATHS[1], LCOR_F32);
    lcor_row_stats stats;

    memset(&stats, 0, sizeof stats);
    lcor_correct_row(plan, 0, p->n, p->rgb, p->light, NULL, p->out, &stats);
    lcor_plan_free(plan);
    return 100.0 * (double)stats.out_of_gamut / (double)p->n;
}

typedef struct result {
    double ns, bound_ns, rgb, e_max, e_mean, off; /* off: part of codes that differ by one */
    int worst_code;
} result;

static double delta_e(const lcor_colour *c, const double *a, const double *b)
{
    double x[3], y[3];

    lcor_lab_from_rgb_row_f64(c, 1, a, x);
    lcor_lab_from_rgb_row_f64(c, 1, b, y);
    return sqrt((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
                (x[2] - y[2]) * (x[2] - y[2]));
}

static void measure_errors(const pictures *p, const path *what, result *r)
{
    const size_t n = p->n < CHECKED ? p->n : CHECKED;
    lcor_colour c;

    lcor_colour_init(&c, LCOR_PRIMARIES_NTSC, NULL, what->transfer, 1.0, LCOR_LIGHTNESS_CIE, NULL);
    for (size_t i = 0; i < n; i++) {
        double v[3], e;

        for (size_t k = 3 * i; k < 3 * i + 3; k++) {
            const double x = p->exact[k];
            int d = 0;

            if (what->type == LCOR_U8)
                d = ((const uint8_t *)p->out)[k] - (int)(x * 255.0 + 0.5);
            else if (what->type == LCOR_U16)
                d = ((const uint16_t *)p->out)[k] - (int)(x * 65535.0 + 0.5);
            else
                v[k % 3] = (double)p->out[k];
            r->off += d != 0;
            r->worst_code = abs(d) > r->worst_code ? abs(d) : r->worst_code;
        }
        if (what->type != LCOR_F32)
            continue;
        for (size_t k = 0; k < 3; k++)
            r->rgb = fmax(r->rgb, fabs(v[k] - p->exact[3 * i + k]));
        e = delta_e(&c, v, p->exact + 3 * i);
        r->e_max = fmax(r->e_max, e);
        r->e_mean += e / (double)n;
    }
    r->off /= 3.0 * (double)n;
}

/* Seconds of the double reference on the checked pixels. */
static double make_exact(const pictures *p, const path *what)
{
    const size_t n = p->n < CHECKED ? p->n : CHECKED;
    lcor_plan *plan = make_plan(what, LCOR_F64);
    double start;

    for (size_t i = 0; i < 3 * n; i++)
        p->exact[i] = what->type == LCOR_U8    ? p->rgb8[i] / 255.0
                      : what->type == LCOR_U16 ? p->rgb16[i] / 65535.0
                                               : (double)p->rgb[i];
    start = now();
    lcor_correct_row(plan, 0, n, p->exact, p->light, NULL, p->exact, NULL);
    start = now() - start;
    lcor_plan_free(plan);
    return start;
}

static result measure(const pictures *p, const path *what, const lcor_kernel *kernel)
{
    lcor_plan *plan = make_plan(what, what->type);
    result r;

    memset(&r, 0, sizeof r);
    r.ns = r.bound_ns = 1e30;
    plan->kernel = kernel;
    if (what->texture)
        for (size_t at = 0; at < p->n; at += ROW)
            lcor_plan_texture_row(plan, p->n - at < ROW ? p->n - at : ROW, p->rgb + 3 * at,
                                  p->f + at, p->n);
    for (int i = 0; i < RUNS; i++) {
        double t = now();

        only_move(p->rgb, p->light, p->out, p->n);
        r.bound_ns = fmin(r.bound_ns, (now() - t) / (double)p->n * 1e9);
        t = now();
        run(p, what, plan);
        r.ns = fmin(r.ns, (now() - t) / (double)p->n * 1e9);
    }
    measure_errors(p, what, &r);
    lcor_plan_free(plan);
    return r;
}

static void report(const result *r, const char *kernel, const path *what, FILE *json, int first)
{
    const int codes = what->type != LCOR_F32;

    printf("%-7s %-24s %8.2f %10.2f", kernel, what->name, r->ns, r->bound_ns / r->ns);
    if (codes)
        printf("   %d code, %.4f %% differ\n", r->worst_code, 100.0 * r->off);
    else
        printf("   RGB %.2g, dE max %.2g mean %.2g\n", r->rgb, r->e_max, r->e_mean);
    fflush(stdout);
    if (json == NULL)
        return;
    fprintf(json, "%s\n   [\"%s\", \"%s\", %.3g, %.3g, ", first ? "" : ",", kernel, what->name,
            r->ns, r->bound_ns / r->ns);
    if (codes)
        fprintf(json, "\"%d code, %.2g %%\", \"\", \"\"]", r->worst_code, 100.0 * r->off);
    else
        fprintf(json, "%.2g, %.2g, %.2g]", r->rgb, r->e_max, r->e_mean);
}

/* Keep-hue over clip, from the times of the first two paths. */
static void report_gamut(const pictures *p, double ns[2][8], FILE *json)
{
    const lcor_kernel *kernel;
    const double share = outside(p);

    printf("\nkernel  keep-hue over clip, %.2f %% of the pixels out of gamut\n", share);
    if (json != NULL)
        fprintf(json,
                "]},\n {\"title\": \"Keeping hue against clipping\",\n \"note\": \"Time of f32 "
                "keep-hue over that of f32 clip, %.2f %% of the pixels out of gamut.\",\n "
                "\"command\": \"build/bench/bench/bench_kernel\",\n \"columns\": [\"kernel\", "
                "\"times\"],\n \"rows\": [",
                share);
    for (size_t v = 0; (kernel = lcor_internal_kernel(v)) != NULL; v++) {
        printf("%-7s %.2f\n", kernel->name, ns[1][v] / ns[0][v]);
        if (json != NULL)
            fprintf(json, "%s[\"%s\", %.2f]", v > 0 ? ", " : "", kernel->name, ns[1][v] / ns[0][v]);
    }
}

int main(int argc, char **argv)
{
    FILE *json = NULL;
    double gamut_ns[2][8] = {{0.0}};
    pictures p;
    int first = 1;

    p.n = (size_t)(argc > 2 ? strtol(argv[2], NULL, 10) : 16) << 20;
    if (p.n == 0 || p.n > (size_t)1 << 30) {
        fprintf(stderr, "bench_kernel: megapixels must be 1 to 1024\n");
        return 2;
    }
    if (argc > 1 && (json = fopen(argv[1], "w")) == NULL) {
        fprintf(stderr, "bench_kernel: cannot write %s\n", argv[1]);
        return 1;
    }
    make_pictures(&p);
    printf(
        "%zu megapixels, interleaved, one thread; \"of memory\" is the rate against a loop that\n"
        "only reads 16 bytes and writes 12 a pixel, in the same run\n\n",
        p.n >> 20);
    printf("%-7s %-24s %8s %10s   %s\n", "kernel", "path", "ns/pixel", "of memory", "error");
    if (json != NULL)
        fprintf(json,
                "{\"tables\": [{\"title\": \"Row calls: speed against accuracy\",\n \"note\": "
                "\"%zu megapixels of random colour, one thread, best of %d; 'of memory' is the "
                "rate against a loop that only reads 16 bytes and writes 12 a pixel; errors "
                "against double.\",\n \"command\": \"build/bench/bench/bench_kernel\",\n "
                "\"columns\": [\"kernel\", \"path\", \"ns/pixel\", \"of memory\", \"RGB\", "
                "\"dE max\", \"dE mean\"],\n \"rows\": [",
                p.n >> 20, RUNS);
    for (size_t w = 0; w < sizeof PATHS / sizeof PATHS[0]; w++) {
        const lcor_kernel *kernel;
        double seconds;

        if (argc > 3 && strcmp(argv[3], PATHS[w].name) != 0)
            continue;
        seconds = make_exact(&p, &PATHS[w]);

        if (w < 2) {
            result r;

            memset(&r, 0, sizeof r);
            r.ns = seconds / (double)(p.n < CHECKED ? p.n : CHECKED) * 1e9;
            report(&r, "double", &PATHS[w], json, first);
            first = 0;
        }
        for (size_t v = 0; (kernel = lcor_internal_kernel(v)) != NULL; v++) {
            const result r = measure(&p, &PATHS[w], kernel);

            report(&r, kernel->name, &PATHS[w], json, first);
            first = 0;
            if (w < 2)
                gamut_ns[w][v] = r.ns;
        }
    }
    if (argc <= 3)
        report_gamut(&p, gamut_ns, json);
    if (json != NULL && (fprintf(json, "]}]}\n") < 0 || fclose(json) != 0)) {
        fprintf(stderr, "bench_kernel: cannot write %s\n", argv[1]);
        return 1;
    }
    return 0;
}
