/* SPDX-License-Identifier: MIT */
/* The solver against path tracing in twenty random scenes, and the path tracer against closed
 * forms.
 *
 * A test fails by chance once in 1 / `chance` runs of another seed at most: bounds follow from the
 * number of comparisons by the tails of the normal (P(|z| > t) <= exp(-t^2/2)) and of the
 * chi-square distribution (P(X > n + 2 sqrt(n x) + 2 x) <= exp(-x), Laurent and Massart). */
#include "random_scenes.h"

#include <lcor/radiosity.h>

/* Builds without optimisation or with a sanitizer take fewer scenes and paths: the bounds widen
 * with the standard error by themselves. */
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
enum { SCENES = 20, PATHS = 12000 };
#else
enum { SCENES = 4, PATHS = 4000 };
#endif

enum { POINTS = 12, AVERAGES = 4, SAMPLES = POINTS + AVERAGES, PATCHES = 4 };

static const double chance = 1e-6;

/* Cluttered scenes cost engine links seconds: past this it answers with what it has and says how
 * good that is. Bytes, not seconds, so that the outcome is the same on every machine. */
static const uint64_t bytes_enough = 32 << 20;

/* Largest |z| that n comparisons may show. */
static double normal_bound(double n) { return sqrt(2 * log(n / chance)); }

/* Largest mean of n squared z, looked at in `tests` groups. */
static double mean_square_bound(double n, double tests)
{
    const double x = log(tests / chance);

    return 1 + 2 * sqrt(x / n) + 2 * x / n;
}

/* Irradiance at a point of a surface, or of a whole surface, by path tracing. */
typedef struct sample {
    int surface, whole;
    double x[3], n[3], direct[3]; /* of a point, exact */
    tracer_mean total[3], straight[3];
} sample;

static tracer_scene scenes[SCENES];
static sample samples[SCENES][SAMPLES];

static void trace(const tracer_scene *scene, sample *s, long paths, uint64_t *state)
{
    const tracer_surface *surface = &scene->surfaces[s->surface];

    if (!s->whole)
        tracer_direct(scene, s->x, s->n, s->surface, s->direct);
    for (long i = 0; i < paths; i++) {
        double direct[3], sum[3];

        if (s->whole) {
            tracer_random_point(surface, state, s->x);
            tracer_direct(scene, s->x, s->n, s->surface, direct);
        } else {
            memcpy(direct, s->direct, sizeof direct);
        }
        memcpy(sum, direct, sizeof sum);
        tracer_path(scene, s->x, s->n, s->surface, state, sum);
        for (int c = 0; c < 3; c++) {
            tracer_mean_add(&s->total[c], sum[c]);
            tracer_mean_add(&s->straight[c], direct[c]);
        }
    }
}

/* Surfaces are drawn by area, points over them and their lit sides. */
static void place(const tracer_scene *scene, sample *s, int whole, uint64_t *state)
{
    const tracer_surface *surface;
    double area = 0, at;
    int back;

    for (int i = 0; i < scene->surface_count; i++)
        area += scene->surfaces[i].area;
    at = area * random_unit(state);
    s->surface = 0;
    while (s->surface < scene->surface_count - 1 && at > scene->surfaces[s->surface].area)
        at -= scene->surfaces[s->surface++].area;
    surface = &scene->surfaces[s->surface];
    s->whole = whole;
    back = !whole && surface->two_sided && random_unit(state) < 0.5;
    tracer_random_point(surface, state, s->x);
    for (int k = 0; k < 3; k++)
        s->n[k] = back ? -surface->normal[k] : surface->normal[k];
}

static int trace_all(void **unused)
{
    (void)unused;
    memset(samples, 0, sizeof samples);
    for (int i = 0; i < SCENES; i++) {
        uint64_t state = 77777u + (uint64_t)i;

        random_scene(&scenes[i], i);
        for (int j = 0; j < SAMPLES; j++) {
            place(&scenes[i], &samples[i][j], j >= POINTS, &state);
            trace(&scenes[i], &samples[i][j], PATHS, &state);
        }
    }
    return 0;
}

/* Mean of a surface's patches, whose areas are equal. */
static void surface_average(const lcor_scene *scene, const lcor_solution *solution, int surface,
                            int channels, double total[3], double direct[3])
{
    double *values, *straight;
    lcor_error err;
    size_t count;

    assert_int_equal(lcor_scene_patch_count(scene, (size_t)surface, &count, &err), LCOR_OK);
    values = calloc(6 * count, sizeof *values);
    assert_non_null(values);
    straight = values + 3 * count;
    assert_int_equal(lcor_solution_patches(solution, (size_t)surface, LCOR_VALUE_AVERAGE, values,
                                           straight, &err),
                     LCOR_OK);
    memset(total, 0, 3 * sizeof *total);
    memset(direct, 0, 3 * sizeof *direct);
    for (size_t i = 0; i < count * (size_t)channels; i++) {
        total[i % (size_t)channels] += values[i] / (double)count;
        direct[i % (size_t)channels] += straight[i] / (double)count;
    }
    free(values);
}

/* What a scene's comparisons came to. */
typedef struct verdict {
    double square, sum; /* of z over the n comparisons */
    double worst, worst_direct;
    int n;
    double allowed; /* relative rms error promised: the tolerance, or what is reported above it */
} verdict;

/* Compares channel c: channels share their paths, so only one of a sample is looked at. */
static void compare(verdict *v, int number, const sample *s, const double *total,
                    const double *direct, int c, double mean)
{
    const double truth = s->total[c].mean, allowed = v->allowed * fmax(truth, 0.02 * mean);
    const double noise = tracer_standard_error(&s->total[c]);
    const double z = (total[c] - truth) / sqrt(noise * noise + allowed * allowed);

    if (s->whole) {
        const double straight = tracer_standard_error(&s->straight[c]) + 0.1 * allowed;
        const double off = fabs(direct[c] - s->straight[c].mean);

        v->worst_direct = fmax(v->worst_direct, off > 0 ? off / straight : 0);
    } else {
        check_near(direct[c], s->direct[c], 1e-9 * (s->direct[c] + mean), "direct light");
    }
    if (fabs(z) > 3)
        print_message("scene %d, surface %d%s, (%g, %g, %g): %g, by paths %g +- %g\n", number,
                      s->surface, s->whole ? " whole" : "", s->x[0], s->x[1], s->x[2], total[c],
                      truth, noise);
    v->square += z * z;
    v->sum += z;
    v->worst = fmax(v->worst, fabs(z));
    v->n++;
}

static verdict check_scene(int number, lcor_engine engine, double tolerance)
{
    lcor_scene *scene = tracer_library_scene(&scenes[number], PATCHES);
    lcor_radiosity_options options;
    lcor_solution *solution = NULL;
    lcor_error err;
    verdict v = {0, 0, 0, 0, 0, 0};
    double mean = 0;
    int channels;

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.tolerance = tolerance;
    options.engine = engine;
    options.max_bytes = engine == LCOR_ENGINE_LINKS ? bytes_enough : 0;
    if (lcor_radiosity_solve(scene, &options, &solution, &err) != LCOR_OK)
        fail_msg("scene %d: %s", number, err.text);
    channels = lcor_solution_report(solution)->channels;
    assert_int_equal(lcor_solution_report(solution)->engine, engine);
    v.allowed = fmax(tolerance, lcor_solution_report(solution)->error_rms);
    for (int j = 0; j < SAMPLES; j++)
        mean += samples[number][j].total[0].mean / SAMPLES;
    for (int j = 0; j < SAMPLES; j++) {
        const sample *s = &samples[number][j];
        double total[3], direct[3];

        if (s->whole)
            surface_average(scene, solution, s->surface, channels, total, direct);
        else
            assert_int_equal(lcor_solution_at(solution, 1, s->x, s->n, total, direct, &err),
                             LCOR_OK);
        compare(&v, number, s, total, direct, j % channels, mean);
    }
    print_message("scene %d: %d surfaces, %d comparisons, rms z %.2f, worst %.2f, direct %.2f, "
                  "reported rms %.4f\n",
                  number, scenes[number].surface_count, v.n, sqrt(v.square / v.n), v.worst,
                  v.worst_direct, lcor_solution_report(solution)->error_rms);
    lcor_solution_free(solution);
    lcor_scene_free(scene);
    return v;
}

/* In every `step`th scene. */
static void check_engine(lcor_engine engine, double tolerance, int step)
{
    verdict all = {0, 0, 0, 0, 0, 0};

    for (int i = 0; i < SCENES; i += step) {
        const verdict v = check_scene(i, engine, tolerance);

        assert_true(v.square / v.n <= mean_square_bound(v.n, SCENES));
        all.square += v.square;
        all.sum += v.sum;
        all.worst = fmax(all.worst, v.worst);
        all.worst_direct = fmax(all.worst_direct, v.worst_direct);
        all.n += v.n;
    }
    print_message("%d comparisons: rms z %.2f, mean z %.3f, worst %.2f\n", all.n,
                  sqrt(all.square / all.n), all.sum / all.n, all.worst);
    assert_true(all.square / all.n <= mean_square_bound(all.n, 1));
    assert_true(fabs(all.sum / all.n) <= normal_bound(1) / sqrt(all.n));
    assert_true(all.worst <= normal_bound(all.n));
    assert_true(all.worst_direct <= normal_bound(all.n));
}

static void engine_links_agrees_with_path_tracing(void **unused)
{
    (void)unused;
    check_engine(LCOR_ENGINE_LINKS, 0.03, 1);
}

static void engine_gather_agrees_with_path_tracing(void **unused)
{
    (void)unused;
    check_engine(LCOR_ENGINE_GATHER, 0.02, 1);
}

static void engine_paths_agrees_with_path_tracing(void **unused)
{
    (void)unused;
    check_engine(LCOR_ENGINE_PATHS, 0.03, 4);
}

/* A closed room of emission 1 and reflectance rho has B = 1 / (1 - rho) everywhere, E = B. */
static void the_tracer_finds_the_white_furnace(void **unused)
{
    const double zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    uint64_t state = 4;
    tracer_scene room;
    sample s;

    (void)unused;
    memset(&room, 0, sizeof room);
    memset(&s, 0, sizeof s);
    random_cuboid(&room, zero, one, 1, 63u, 0, &state);
    for (int i = 0; i < room.surface_count; i++)
        for (int c = 0; c < 3; c++) {
            room.surfaces[i].rho[c] = 0.5;
            room.surfaces[i].emission[c] = 1;
        }
    place(&room, &s, 0, &state);
    trace(&room, &s, 10 * PATHS, &state);
    check_near(s.total[0].mean, 2, normal_bound(1) * tracer_standard_error(&s.total[0]), "furnace");
    assert_true(tracer_standard_error(&s.total[0]) < 0.02);
}

/* A square emitter over a point, whole and half hidden: Lambert's form factor. With `front` 0 the
 * emitter turns its back, with `triangles` it is made of two. */
static void check_view_factor(int triangles, int two_sided, int front, double hidden)
{
    const double pi = acos(-1), a = 0.5, root = sqrt(1 + a * a);
    const double truth = front || two_sided ? 4 / pi * a / root * atan(a / root) * (1 - hidden) : 0;
    const double corner[3] = {-a, -a, 1}, far[3] = {a, a, 1}, x[3] = {2 * a, 0, 0};
    const double y[3] = {0, 2 * a, 0}, minus_x[3] = {-2 * a, 0, 0}, minus_y[3] = {0, -2 * a, 0};
    const double low[3] = {0, -2, 0.3}, wide[3] = {4, 0, 0}, deep[3] = {0, 4, 0};
    const double up[3] = {0, 0, 1}, origin[3] = {0, 0, 0};
    tracer_mean mean = {0, 0, 0};
    tracer_scene scene;
    uint64_t state = 5;

    memset(&scene, 0, sizeof scene);
    (void)tracer_add(&scene, corner, front ? y : x, front ? x : y, triangles);
    if (triangles)
        (void)tracer_add(&scene, far, front ? minus_y : minus_x, front ? minus_x : minus_y, 1);
    for (int i = 0; i < scene.surface_count; i++) {
        scene.surfaces[i].two_sided = two_sided;
        for (int c = 0; c < 3; c++)
            scene.surfaces[i].emission[c] = 1;
    }
    if (hidden > 0)
        (void)tracer_add(&scene, low, wide, deep, 0);
    for (int i = 0; i < 10 * PATHS; i++) {
        double sum[3] = {0, 0, 0};

        tracer_path(&scene, origin, up, TRACER_NONE, &state, sum);
        tracer_mean_add(&mean, sum[0]);
    }
    check_near(mean.mean, truth, normal_bound(6) * tracer_standard_error(&mean), "form factor");
    /* Each path brings 0 or 1. */
    assert_true(tracer_standard_error(&mean) <= 0.5 / sqrt((double)(mean.n - 1)));
}

static void the_tracer_finds_form_factors(void **unused)
{
    (void)unused;
    check_view_factor(0, 0, 1, 0);
    check_view_factor(1, 0, 1, 0);
    check_view_factor(0, 0, 0, 0);
    check_view_factor(1, 1, 0, 0);
    check_view_factor(0, 0, 1, 0.5);
    check_view_factor(1, 1, 1, 0.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_tracer_finds_the_white_furnace),
        cmocka_unit_test(the_tracer_finds_form_factors),
        cmocka_unit_test(engine_links_agrees_with_path_tracing),
        cmocka_unit_test(engine_gather_agrees_with_path_tracing),
        cmocka_unit_test(engine_paths_agrees_with_path_tracing),
    };

    return cmocka_run_group_tests_name("path tracer", tests, trace_all, NULL);
}
