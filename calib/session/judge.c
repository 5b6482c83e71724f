/* SPDX-License-Identifier: MIT */
#include "session/judge.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define D_LOWEST    (-0.10) /* a reference white may be a little darker than the paper */
#define D_HIGHEST   6.0
#define D_MIXED     0.15 /* more than any one patch varies, less than any two patches differ */
#define D_DRIFT     0.05
#define D_APART     0.10
#define D_TOLERATED 0.03 /* never reject what a good instrument may scatter */
#define MAD_TO_SD   1.4826
enum { DRIFT_MIN = 4 };

bool judge_plausible(double density) { return density >= D_LOWEST && density <= D_HIGHEST; }

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double judge_median(const double *values, size_t n)
{
    double sorted[JUDGE_MAX];
    if (n == 0 || n > JUDGE_MAX)
        return (double)NAN;
    memcpy(sorted, values, n * sizeof *values);
    qsort(sorted, n, sizeof *sorted, by_value);
    return 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
}

/* A lamp that warms up or a wet print: every reading moves on from the one before. */
static bool drifts(const double *values, size_t n)
{
    if (n < DRIFT_MIN || fabs(values[n - 1] - values[0]) < D_DRIFT)
        return false;
    const bool up = values[n - 1] > values[0];
    for (size_t i = 1; i < n; i++)
        if (up ? values[i] <= values[i - 1] : values[i] >= values[i - 1])
            return false;
    return true;
}

/* How far from the median a reading may be: what the farthest of n good ones stays within in 99 of
 * 100 patches (normal noise, simulated), in standard deviations judged from the median absolute
 * deviation. The spread of few readings is hardly known, so three convict none. */
static double outlier_limit(const double *away, size_t n)
{
    static const double limits[] = {16.0, 18.3, 10.0, 10.6, 7.9, 8.2, 6.9};
    if (n < 4)
        return D_MIXED;
    return fmax(limits[n < 10 ? n - 4 : 6] * MAD_TO_SD * judge_median(away, n), D_TOLERATED);
}

verdict judge_patch(const double *values, size_t n, bool *accepted)
{
    double away[JUDGE_MAX];
    const double median = judge_median(values, n);
    if (n == 0 || n > JUDGE_MAX)
        return VERDICT_TOO_FEW;
    for (size_t i = 0; i < n; i++)
        away[i] = fabs(values[i] - median);
    const double limit = outlier_limit(away, n);
    bool mixed = false;
    size_t good = 0;
    for (size_t i = 0; i < n; i++) {
        mixed = mixed || away[i] > D_MIXED;
        accepted[i] = away[i] <= fmin(limit, D_MIXED);
        good += accepted[i];
    }
    if (mixed)
        return VERDICT_MIXED;
    if (drifts(values, n))
        return VERDICT_DRIFTING;
    return 2 * good >= n ? VERDICT_GOOD : VERDICT_TOO_FEW;
}

verdict judge_pair(double first, double second)
{
    return fabs(first - second) > D_APART ? VERDICT_GOOD : VERDICT_EQUAL;
}
