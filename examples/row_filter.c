/* SPDX-License-Identifier: MIT */
/* The smallest filter: a picture (binary PPM, 8 bit, sRGB) row by row through a plan.
 *
 *     cc -std=c99 row_filter.c $(pkg-config --cflags --libs lcor) -o row_filter
 *     ./row_filter 23 < in.ppm > out.ppm       # 23:1 is what the paper's print could show
 *
 * The picture lies under a lamp on its left: five times as much light there as on the right. */
#include <lcor/lcor.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH_MAX = 65535 };

static unsigned char row[3 * WIDTH_MAX];
static float light[WIDTH_MAX];
static double r[WIDTH_MAX];

static int fail(const char *why)
{
    fprintf(stderr, "row_filter: %s\n", why);
    return 1;
}

int main(int argc, char *argv[])
{
    unsigned width, height;
    lcor_error error;
    lcor_colour srgb;
    lcor_plan *plan = NULL;
    lcor_mean mean;
    const int contrast = argc == 2 ? atoi(argv[1]) : 0;

    if (scanf("P6 %u %u 255", &width, &height) != 2 || getchar() == EOF || width > WIDTH_MAX)
        return fail("a binary PPM of 8 bits a colour is wanted");
    for (unsigned x = 0; x < width; x++)
        light[x] = 1.0f - 0.8f * (float)x / (float)width;

    /* What the plan needs to know: the device, the mean of r = light * rho, and how pixels lie. */
    lcor_plan_options options;
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.contrast = contrast;
    options.rho = 0.5;
    options.colour = &srgb;
    options.in_type = options.out_type = LCOR_U8;
    for (unsigned x = 0; x < width; x++)
        r[x] = (double)light[x] * options.rho;
    lcor_mean_init(&mean);
    lcor_mean_add(&mean, width, r, NULL); /* every row has the same light: one stands for all */
    if (lcor_colour_init(&srgb, LCOR_PRIMARIES_SRGB, NULL, LCOR_TRANSFER_SRGB, 1.0,
                         LCOR_LIGHTNESS_CIE, &error) != LCOR_OK ||
        lcor_mean_get(&mean, LCOR_MEAN_ADAPTIVE, &options.r_mean, &error) != LCOR_OK ||
        lcor_plan_new(&options, &plan, &error) != LCOR_OK)
        return fail(error.text);

    printf("P6\n%u %u\n255\n", width, height);
    for (unsigned y = 0; y < height; y++) {
        if (fread(row, 3, width, stdin) != width)
            return fail("the picture is cut short");
        lcor_correct_row(plan, y, width, row, light, NULL, row, NULL);
        fwrite(row, 3, width, stdout);
    }
    lcor_plan_free(plan);
    return fflush(stdout) == 0 ? 0 : fail("the picture cannot be written");
}
