/* SPDX-License-Identifier: MIT */
/* Speed against accuracy of the row calls: every kernel of this build, single thread.
 *
 *   bench_kernel [FILE.json] [MEGAPIXELS] [PATH]
 *
 * PATH: one row of the table below only, for example "f32 clip".
 *
 * Each time is the best of several rounds, in which all kernels and paths take turns, and with them
 * the loop they are compared with, which only reads and writes as many bytes as a float row does: a
 * slow spell of the machine meets all of them. Errors are against the double reference on the first
 * 10^6 pixels. Two pixels in a hundred leave the gamut. */
#include "correct/internal.h"

#include <lcor/lcor.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROW = 4096, ROUNDS = 9, CHECKED = 1000000, KERNELS_MAX = 3 };

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

enum { F32_CLIP, F32_KEEP_HUE, F32_TEXTURE, U8_CLIP, U8_KEEP_HUE, U16, U8_SRGB, F32_SRGB, PATHS };

static const path paths[PATHS] = {
    [F32_CLIP] = {"f32 clip", LCOR_F32, LCOR_GAMUT_CLIP, LCOR_TRANSFER_LINEAR, 0},
    [F32_KEEP_HUE] = {"f32 keep-hue", LCOR_F32, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_LINEAR, 0},
    [F32_TEXTURE] = {"f32 texture planes clip", LCOR_F32, LCOR_GAMUT_CLIP, LCOR_TRANSFER_LINEAR, 1},
    [U8_CLIP] = {"u8 clip", LCOR_U8, LCOR_GAMUT_CLIP, LCOR_TRANSFER_LINEAR, 0},
    [U8_KEEP_HUE] = {"u8 keep-hue", LCOR_U8, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_LINEAR, 0},
    [U16] = {"u16 keep-hue", LCOR_U16, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_LINEAR, 0},
    [U8_SRGB] = {"u8 sRGB keep-hue", LCOR_U8, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_SRGB, 0},
    [F32_SRGB] = {"f32 sRGB keep-hue", LCOR_F32, LCOR_GAMUT_KEEP_HUE, LCOR_TRANSFER_SRGB, 0},
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

static void run(const pictures *p, size_t pixels, const path *what, const lcor_plan *plan)
{
    const size_t size = what->type == LCOR_U8 ? 1 : what->type == LCOR_U16 ? 2 : 4;

    for (size_t at = 0; at < pixels; at += ROW) {
        const size_t n = pixels - at < ROW ? pixels - at : ROW;
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
    lcor_plan *plan = make_plan(&paths[F32_KEEP_HUE], LCOR_F32);
    lcor_row_stats stats;

    memset(&stats, 0, sizeof stats);
    lcor_correct_row(plan, 0, p->n, p->rgb, p->light, NULL, p->out, &stats);
    lcor_plan_free(plan);
    return 100.0 * (double)stats.out_of_gamut / (double)p->n;
}

typedef struct result {
    double ns, rgb, e_max, e_mean, off; /* off: part of codes that differ by one */
    int worst_code;
} result;

/* Of one run of this program. */
typedef struct results {
    lcor_kernel kernels[KERNELS_MAX];
    size_t kernel_count;
    int chosen[PATHS]; /* not 0: measure it */
    result of[PATHS][KERNELS_MAX];
    double bound_ns;
} results;

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

/* Nanoseconds a pixel of the double reference on the checked pixels. */
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
    return start / (double)n * 1e9;
}

static void make_texture(const pictures *p)
{
    lcor_plan *plan = make_plan(&paths[F32_TEXTURE], LCOR_F32);

    for (size_t at = 0; at < p->n; at += ROW)
        lcor_plan_texture_row(plan, p->n - at < ROW ? p->n - at : ROW, p->rgb + 3 * at, p->f + at,
                              p->n);
    lcor_plan_free(plan);
}

static double timed_run(const pictures *p, const path *what, const lcor_kernel *kernel)
{
    lcor_plan *plan = make_plan(what, what->type);
    double t;

    plan->kernel = *kernel;
    t = now();
    run(p, p->n, what, plan);
    t = now() - t;
    lcor_plan_free(plan);
    return t / (double)p->n * 1e9;
}

static void measure_times(const pictures *p, results *r)
{
    make_texture(p);
    r->bound_ns = 1e30;
    for (int w = 0; w < PATHS; w++)
        for (size_t v = 0; v < r->kernel_count; v++)
            r->of[w][v].ns = 1e30;
    for (int i = 0; i < ROUNDS; i++) {
        double t = now();

        only_move(p->rgb, p->light, p->out, p->n);
        r->bound_ns = fmin(r->bound_ns, (now() - t) / (double)p->n * 1e9);
        for (int w = 0; w < PATHS; w++)
            for (size_t v = 0; r->chosen[w] && v < r->kernel_count; v++) {
                t = timed_run(p, &paths[w], &r->kernels[v]);
                r->of[w][v].ns = fmin(r->of[w][v].ns, t);
            }
    }
}

static void report(const result *r, double bound_ns, const char *kernel, const path *what,
                   FILE *json)
{
    static int rows;
    const int codes = what->type != LCOR_F32;

    printf("%-7s %-24s %8.2f %10.2f", kernel, what->name, r->ns, bound_ns / r->ns);
    if (codes)
        printf("   %d code, %.4f %% differ\n", r->worst_code, 100.0 * r->off);
    else
        printf("   RGB %.2g, dE max %.2g mean %.2g\n", r->rgb, r->e_max, r->e_mean);
    fflush(stdout);
    if (json == NULL)
        return;
    fprintf(json, "%s\n   [\"%s\", \"%s\", %.3g, %.3g, ", rows++ == 0 ? "" : ",", kernel,
            what->name, r->ns, bound_ns / r->ns);
    if (codes)
        fprintf(json, "\"%d code, %.2g %%\", \"\", \"\"]", r->worst_code, 100.0 * r->off);
    else
        fprintf(json, "%.2g, %.2g, %.2g]", r->rgb, r->e_max, r->e_mean);
}

/* The errors of each path, and what was measured of it. */
static void report_path(const pictures *p, int w, results *r, FILE *json)
{
    const size_t n = p->n < CHECKED ? p->n : CHECKED;
    result exact;

    memset(&exact, 0, sizeof exact);
    exact.ns = make_exact(p, &paths[w]);
    if (w <= F32_KEEP_HUE)
        report(&exact, r->bound_ns, "double", &paths[w], json);
    for (size_t v = 0; v < r->kernel_count; v++) {
        lcor_plan *plan = make_plan(&paths[w], paths[w].type);

        plan->kernel = r->kernels[v];
        run(p, n, &paths[w], plan);
        lcor_plan_free(plan);
        measure_errors(p, &paths[w], &r->of[w][v]);
        report(&r->of[w][v], r->bound_ns, r->kernels[v].name, &paths[w], json);
    }
}

/* Keep-hue over clip, and bytes over floats. */
static void report_ratios(const pictures *p, const results *r, FILE *json)
{
    const double share = outside(p);

    printf("\nkernel  f32: keep-hue over clip  clip: u8 over f32   (%.2f %% out of gamut)\n",
           share);
    if (json != NULL)
        fprintf(
            json,
            "]},\n {\"title\": \"Keeping hue against clipping, bytes against floats\",\n "
            "\"note\": \"Ratios of the times above; %.2f %% of the pixels are out of gamut.\",\n "
            "\"command\": \"build/bench/bench/bench_kernel\",\n \"columns\": [\"kernel\", "
            "\"f32: keep-hue over clip\", \"clip: u8 over f32\"],\n \"rows\": [",
            share);
    for (size_t v = 0; v < r->kernel_count; v++) {
        const double clip = r->of[F32_CLIP][v].ns, hue = r->of[F32_KEEP_HUE][v].ns / clip;
        const double bytes = r->of[U8_CLIP][v].ns / clip;

        printf("%-7s %23.2f %18.2f\n", r->kernels[v].name, hue, bytes);
        if (json != NULL)
            fprintf(json, "%s[\"%s\", %.2f, %.2f]", v > 0 ? ", " : "", r->kernels[v].name, hue,
                    bytes);
    }
}

int main(int argc, char **argv)
{
    static results r;
    FILE *json = NULL;
    pictures p;

    p.n = (size_t)(argc > 2 ? strtol(argv[2], NULL, 10) : 16) << 20;
    if (p.n == 0 || p.n > (size_t)1 << 30) {
        fprintf(stderr, "bench_kernel: megapixels must be 1 to 1024\n");
        return 2;
    }
    if (argc > 1 && (json = fopen(argv[1], "w")) == NULL) {
        fprintf(stderr, "bench_kernel: cannot write %s\n", argv[1]);
        return 1;
    }
    while (r.kernel_count < KERNELS_MAX &&
           lcor_internal_kernel(r.kernel_count, &r.kernels[r.kernel_count]))
        r.kernel_count++;
    for (int w = 0; w < PATHS; w++)
        r.chosen[w] = argc <= 3 || strcmp(argv[3], paths[w].name) == 0;
    make_pictures(&p);
    measure_times(&p, &r);
    printf(
        "%zu megapixels, interleaved, one thread; \"of memory\" is the rate against a loop that\n"
        "only reads 16 bytes and writes 12 a pixel, in the same run\n\n",
        p.n >> 20);
    printf("%-7s %-24s %8s %10s   %s\n", "kernel", "path", "ns/pixel", "of memory", "error");
    if (json != NULL)
        fprintf(
            json,
            "{\"tables\": [{\"title\": \"Row calls: speed against accuracy\",\n \"note\": "
            "\"%zu megapixels of random colour, one thread, best of %d rounds in which all take "
            "turns; 'of memory' is the rate against a loop that only reads 16 bytes and writes "
            "12 a pixel; errors against double.\",\n \"command\": "
            "\"build/bench/bench/bench_kernel\",\n \"columns\": [\"kernel\", \"path\", "
            "\"ns/pixel\", \"of memory\", \"RGB\", \"dE max\", \"dE mean\"],\n \"rows\": [",
            p.n >> 20, ROUNDS);
    for (int w = 0; w < PATHS; w++)
        if (r.chosen[w])
            report_path(&p, w, &r, json);
    if (argc <= 3)
        report_ratios(&p, &r, json);
    if (json != NULL && (fprintf(json, "]}]}\n") < 0 || fclose(json) != 0)) {
        fprintf(stderr, "bench_kernel: cannot write %s\n", argv[1]);
        return 1;
    }
    return 0;
}
