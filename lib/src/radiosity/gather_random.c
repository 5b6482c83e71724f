/* SPDX-License-Identifier: MIT */
#include "radiosity/gather_random.h"

#include <math.h>
#include <string.h>

/* Degree, inner coefficients and first direction numbers of the primitive polynomials. */
static const struct {
    int degree;
    unsigned inner, first[4];
} polynomials[SOBOL_AXES] = {{0, 0, {0}},       {1, 0, {1}},       {2, 1, {1, 3}},
                             {3, 1, {1, 3, 1}}, {3, 2, {1, 1, 1}}, {4, 1, {1, 1, 3, 3}}};

static uint32_t reverse_bits(uint32_t x)
{
    x = x >> 16 | x << 16;
    x = (x & 0xff00ff00u) >> 8 | (x & 0x00ff00ffu) << 8;
    x = (x & 0xf0f0f0f0u) >> 4 | (x & 0x0f0f0f0fu) << 4;
    x = (x & 0xccccccccu) >> 2 | (x & 0x33333333u) << 2;
    return (x & 0xaaaaaaaau) >> 1 | (x & 0x55555555u) << 1;
}

/* Direction numbers of an axis. */
static void set_directions(int axis, uint32_t v[SOBOL_BITS])
{
    const int degree = polynomials[axis].degree;

    for (int i = 0; i < SOBOL_BITS; i++) {
        if (axis == 0 || i < degree) {
            v[i] = (axis == 0 ? 1u : polynomials[axis].first[i]) << (31 - i);
            continue;
        }
        v[i] = v[i - degree] ^ v[i - degree] >> degree;
        for (int k = 1; k < degree; k++)
            if (polynomials[axis].inner >> (degree - 1 - k) & 1)
                v[i] ^= v[i - k];
    }
}

void sobol_init(sobol *s)
{
    for (int axis = 0; axis < SOBOL_AXES; axis++) {
        uint32_t v[SOBOL_BITS];

        set_directions(axis, v);
        for (int d = 0; d < SOBOL_DIGITS; d++) {
            uint32_t *out = s->reversed[axis][d];

            out[0] = 0;
            for (int i = 1; i < SOBOL_BASE; i++) { /* without its highest bit, and that */
                const int bit = i < 2 ? 0 : i < 4 ? 1 : i < 8 ? 2 : 3;

                out[i] = out[i - (1 << bit)] ^ reverse_bits(v[4 * d + bit]);
            }
        }
    }
}

/* Each bit is flipped by a hash of the seed and of all higher bits, which `x` has below. */
static uint32_t scramble(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return reverse_bits(x);
}

void sobol_point(const sobol *s, uint32_t index, uint32_t seed, int first, int count, double *out)
{
    for (int i = 0; i < count; i++) {
        uint32_t x = 0, digit = 0;

        for (uint32_t rest = index; rest; rest /= SOBOL_BASE)
            x ^= s->reversed[first + i][digit++][rest % SOBOL_BASE];
        x = scramble(x, random_hash(seed * SOBOL_AXES + (uint32_t)(first + i)));
        out[i] = (x + 0.5) / 4294967296.0;
    }
}

uint32_t random_seed_at(const double x[3])
{
    uint32_t seed = 1;

    for (int k = 0; k < 3; k++) {
        const float rounded = (float)x[k] + 0.0F; /* no negative zero */
        uint32_t bits;

        memcpy(&bits, &rounded, sizeof bits);
        seed = random_hash(seed + bits);
    }
    return seed;
}

/* Sine and cosine of -pi/4..pi/4 to 3e-9 by Taylor: the same bits whatever the mathematical
 * library. */
static void sine_cosine(double x, double *sine, double *cosine)
{
    static const double s3 = -1.0 / 6, s5 = 1.0 / 120, s7 = -1.0 / 5040, s9 = 1.0 / 362880;
    static const double c4 = 1.0 / 24, c6 = -1.0 / 720, c8 = 1.0 / 40320, c10 = -1.0 / 3628800;
    const double q = x * x;

    *sine = x * (1 + q * (s3 + q * (s5 + q * (s7 + q * s9))));
    *cosine = 1 + q * (-0.5 + q * (c4 + q * (c6 + q * (c8 + q * c10))));
}

void random_cosine(double a, double b, double direction[3])
{
    static const double quarter_pi = 0.78539816339744830962;
    const double x = 2 * a - 1, y = 2 * b - 1;
    double sine, cosine;

    if (x * x > y * y) {
        sine_cosine(quarter_pi * y / x, &sine, &cosine);
        direction[0] = x * cosine;
        direction[1] = x * sine;
    } else if (y * y > 0) {
        sine_cosine(quarter_pi * x / y, &sine, &cosine);
        direction[0] = y * sine;
        direction[1] = y * cosine;
    } else {
        direction[0] = direction[1] = 0;
    }
    /* Never quite within the plane, where a ray would run along its own surface. */
    direction[2] = sqrt(fmax(1e-8, 1 - direction[0] * direction[0] - direction[1] * direction[1]));
}
