/* SPDX-License-Identifier: MIT */
/* Prints a hash of the output of every kind of row; run.sh compares it between builds. */
#include "correct/internal.h"

#include <lcor/adapt.h>

#include <pthread.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 1001, HEIGHT = 8 };

static float rgb[HEIGHT][3 * WIDTH], light[HEIGHT][WIDTH], rho[HEIGHT][WIDTH];
static uint64_t in[HEIGHT][3 * WIDTH], out[HEIGHT][3 * WIDTH];
static lcor_plan *plan;
static int rows_have_rho;

static void *half(void *which)
{
    for (size_t y = *(const size_t *)which; y < HEIGHT; y += 2)
        lcor_correct_row(plan, y, WIDTH, in[y], light[y], rows_have_rho ? rho[y] : NULL, out[y],
                         NULL);
    return NULL;
}

static void run(int threads)
{
    static const size_t first = 0, second = 1;
    pthread_t other;

    if (threads == 2 && pthread_create(&other, NULL, half, (void *)(size_t)&second) == 0) {
        half((void *)(size_t)&first);
        pthread_join(other, NULL);
    } else {
        half((void *)(size_t)&first);
        half((void *)(size_t)&second);
    }
}

static void fill(void)
{
    uint64_t s = UINT64_C(88172645463325252);

    for (size_t i = 0; i < 5 * HEIGHT * WIDTH; i++) {
        float v;

        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        v = (float)(s >> 40) / 16777216.0f;
        if (i < 3 * HEIGHT * WIDTH)
            rgb[0][i] = i % 5 == 0 ? (float)(s >> 63) : v;
        else if (i < 4 * HEIGHT * WIDTH)
            light[0][i - 3 * HEIGHT * WIDTH] = 2.2f * v;
        else
            rho[0][i - 4 * HEIGHT * WIDTH] = v;
    }
}

static void convert(lcor_sample type)
{
    for (size_t y = 0; y < HEIGHT; y++)
        for (size_t i = 0; i < 3 * WIDTH; i++)
            switch (type) {
            case LCOR_F32: ((float *)in[y])[i] = rgb[y][i]; break;
            case LCOR_F64: ((double *)in[y])[i] = (double)rgb[y][i]; break;
            case LCOR_U8: ((uint8_t *)in[y])[i] = (uint8_t)(rgb[y][i] * 255.0f); break;
            case LCOR_U16: ((uint16_t *)in[y])[i] = (uint16_t)(rgb[y][i] * 65535.0f); break;
            }
}

static uint64_t hash(const void *data, size_t size)
{
    const unsigned char *p = data;
    uint64_t h = UINT64_C(14695981039346656037); /* FNV-1a */

    for (size_t i = 0; i < size; i++)
        h = (h ^ p[i]) * UINT64_C(1099511628211);
    return h;
}

int main(void)
{
    fill();
    for (int kind = 0; kind < 96; kind++) {
        lcor_plan_options o;
        lcor_colour colour;
        lcor_error e;

        memset(&o, 0, sizeof o);
        o.struct_size = sizeof o;
        o.contrast = 23.4;
        o.r_mean = 0.3;
        o.in_type = o.out_type = (lcor_sample)(kind % 4);
        o.map_type = LCOR_F32;
        o.gamut = kind / 4 % 2 ? LCOR_GAMUT_CLIP : LCOR_GAMUT_KEEP_HUE;
        o.reading = kind / 8 % 2 ? LCOR_READING_TEXEL : LCOR_READING_PATCH;
        o.exponent = kind / 16 % 2 ? 0.8 : 1.0;
        o.colour = &colour;
        rows_have_rho = kind % 3 == 0;
        if (lcor_colour_init(&colour, LCOR_PRIMARIES_SRGB, NULL, (lcor_transfer)(kind / 32), 2.2,
                             LCOR_LIGHTNESS_CIE, &e) != LCOR_OK ||
            lcor_plan_new(&o, &plan, &e) != LCOR_OK) {
            fprintf(stderr, "%s\n", e.text);
            return 1;
        }
        convert(o.in_type);
        memset(out, 0, sizeof out);
        run(1);
        printf("%d %016llx\n", kind, (unsigned long long)hash(out, sizeof out));
        {
            const uint64_t one_thread = hash(out, sizeof out);
            lcor_kernel kernel;

            memset(out, 0, sizeof out);
            run(2);
            if (hash(out, sizeof out) != one_thread)
                printf("%d differs with two threads\n", kind);
            for (size_t v = 0; lcor_internal_kernel(v, &kernel); v++) {
                plan->kernel = kernel;
                memset(out, 0, sizeof out);
                run(1);
                if (hash(out, sizeof out) != one_thread)
                    printf("%d differs with %s\n", kind, kernel.name);
            }
        }
        lcor_plan_free(plan);
    }
    return 0;
}
