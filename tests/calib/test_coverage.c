/* SPDX-License-Identifier: MIT */
/* Does the stated 95 % interval of the contrast hold it in 95 % of measurements? Random devices,
 * measured by random instruments as lccal does it: noise, rounding to the instrument's step,
 * rejection, median, Student's t. */
#include "testing.h"

#include "instrument/instrument.h"
#include "session/judge.h"

#include <lcor/profile.h>

#define LN10 2.302585092994046

typedef struct device {
    double d_min, d_max;
    double noise[2]; /* standard deviation of a reading of white and of black */
    double step;     /* the instrument's resolution, */
    bool rounds;     /* and whether its readings are rounded to it */
    double outliers; /* share of readings that went wrong by 0.05 to 0.14 */
    size_t readings;
} device;

static double normal(uint64_t *state)
{
    const double u = 1.0 - random_unit(state), angle = 6.283185307179586 * random_unit(state);
    return sqrt(-2.0 * log(u)) * cos(angle);
}

static double between(uint64_t *state, double low, double high)
{
    return low + (high - low) * random_unit(state);
}

static double log_between(uint64_t *state, double low, double high)
{
    return exp(between(state, log(low), log(high)));
}

static double measure(const device *d, int black, uint64_t *state)
{
    double value = (black ? d->d_max : d->d_min) + d->noise[black] * normal(state);
    if (random_unit(state) < d->outliers)
        value += between(state, 0.05, 0.14) * (random_unit(state) < 0.5 ? -1.0 : 1.0);
    return d->rounds ? floor(value / d->step + 0.5) * d->step : value;
}

/* 1 the interval holds the contrast, 0 it does not, -1 lccal would have refused the readings. */
static int trial(const device *d, uint64_t *state)
{
    lcor_profile *profile = NULL;
    assert_int_equal(lcor_profile_new(NULL, &profile, NULL), LCOR_OK);
    assert_int_equal(lcor_profile_resolution_set(profile, d->step, NULL), LCOR_OK);
    int refused = 0;
    for (int black = 0; black < 2; black++) {
        double values[32];
        bool accepted[32];
        for (size_t i = 0; i < d->readings; i++)
            values[i] = measure(d, black, state);
        refused |= judge_patch(values, d->readings, accepted) != VERDICT_GOOD;
        for (size_t i = 0; i < d->readings; i++) {
            const double level = black ? 0.0 : 255.0;
            const lcor_profile_reading r = {.has = LCOR_HAS_RGB | LCOR_HAS_VISUAL,
                                            .rejected = !accepted[i],
                                            .rgb = {level, level, level},
                                            .density = {0.0, 0.0, 0.0, values[i]}};
            assert_int_equal(lcor_profile_reading_add(profile, &r, NULL), LCOR_OK);
        }
    }
    const double contrast = lcor_profile_contrast(profile);
    const double u95 = lcor_profile_contrast_u95(profile);
    lcor_profile_free(profile);
    if (refused)
        return -1;
    return fabs(contrast - pow(10.0, d->d_max - d->d_min)) <= u95;
}

/* Two or three decimals on a display, and densities sent as floating-point numbers. */
static const struct {
    double step;
    bool rounds;
} resolutions[] = {{0.01, true}, {0.001, true}, {FLOAT_DENSITY_STEP, false}};

static void set_resolution(device *d, size_t which)
{
    d->step = resolutions[which].step;
    d->rounds = resolutions[which].rounds;
}

static device random_device(uint64_t *state)
{
    device d = {.readings = 5};
    set_resolution(&d, random_bits(state) % 3);
    d.d_min = between(state, 0.02, 0.12);
    d.d_max = d.d_min + log10(log_between(state, 6.0, 300.0));
    d.noise[0] = log_between(state, 0.001, 0.02);
    d.noise[1] = d.noise[0] * between(state, 1.0, 2.0);
    return d;
}

typedef struct tally {
    int held, judged, refused;
} tally;

static void count(tally *t, int outcome)
{
    t->refused += outcome < 0;
    t->judged += outcome >= 0;
    t->held += outcome > 0;
}

static void check_coverage(const char *what, tally t, double low, double high)
{
    const double share = (double)t.held / t.judged;
    print_message("%-44s %.2f %% of %d, %d refused\n", what, 100.0 * share, t.judged, t.refused);
    if (!(share >= low && share <= high))
        fail_msg("%s: coverage %.4f is outside %.2f..%.2f", what, share, low, high);
}

static void the_interval_holds_the_contrast_of_95_in_100_random_devices(void **unused)
{
    (void)unused;
    uint64_t state = 20261122;
    tally t = {0};
    for (int i = 0; i < 10000; i++) {
        const device d = random_device(&state);
        count(&t, trial(&d, &state));
    }
    check_coverage("random devices, 5 readings", t, 0.93, 0.97);
}

static void it_does_with_other_numbers_of_readings(void **unused)
{
    (void)unused;
    uint64_t state = 7;
    tally t = {0};
    for (int i = 0; i < 10000; i++) {
        device d = random_device(&state);
        d.readings = 3 + (size_t)(random_bits(&state) % 13);
        count(&t, trial(&d, &state));
    }
    check_coverage("random devices, 3 to 15 readings", t, 0.93, 0.97);
}

static void one_reading_in_fifty_gone_wrong_does_no_harm(void **unused)
{
    (void)unused;
    uint64_t state = 8;
    tally t = {0};
    for (int i = 0; i < 10000; i++) {
        device d = random_device(&state);
        d.outliers = 0.02;
        count(&t, trial(&d, &state));
    }
    check_coverage("2 % of the readings wrong", t, 0.93, 0.98);
}

/* A coarse step hides small noise: then the interval is a little wide, never narrow. */
static void each_step_and_noise_is_covered(void **unused)
{
    (void)unused;
    static const double noises[] = {0.0, 0.001, 0.003, 0.006, 0.01, 0.02};
    static const size_t readings[] = {3, 5, 10};
    uint64_t state = 9;
    for (size_t s = 0; s < 3; s++)
        for (size_t k = 0; k < 6; k++)
            for (size_t n = 0; n < 3; n++) {
                tally t = {0};
                char what[80];
                for (int i = 0; i < 600; i++) {
                    device d = random_device(&state);
                    set_resolution(&d, s);
                    d.noise[0] = d.noise[1] = noises[k];
                    d.readings = readings[n];
                    count(&t, trial(&d, &state));
                }
                snprintf(what, sizeof what, "step %.3f%s, noise %.3f, %zu readings",
                         resolutions[s].step, resolutions[s].rounds ? "" : " (float)", noises[k],
                         readings[n]);
                check_coverage(what, t, 0.93, 1.0);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_interval_holds_the_contrast_of_95_in_100_random_devices),
        cmocka_unit_test(it_does_with_other_numbers_of_readings),
        cmocka_unit_test(one_reading_in_fifty_gone_wrong_does_no_harm),
        cmocka_unit_test(each_step_and_noise_is_covered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
