/* SPDX-License-Identifier: MIT */
/* The C row loop that bench_python.py compares with: one plan, one call a row, nothing else. */
#include <lcor/lcor.h>

#include <string.h>

/* A plan for packed pixels of one sample type and float maps; NULL without memory. */
LCOR_API lcor_plan *row_loop_plan(lcor_sample sample);
LCOR_API void row_loop_run(const lcor_plan *plan, size_t rows, size_t n, const char *texels,
                           const float *light, char *out, size_t row_bytes);

lcor_plan *row_loop_plan(lcor_sample sample)
{
    lcor_plan_options options;
    lcor_plan *plan = NULL;

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.contrast = 23.4;
    options.r_mean = 0.5;
    options.in_type = options.out_type = sample;
    return lcor_plan_new(&options, &plan, NULL) == LCOR_OK ? plan : NULL;
}

void row_loop_run(const lcor_plan *plan, size_t rows, size_t n, const char *texels,
                  const float *light, char *out, size_t row_bytes)
{
    for (size_t y = 0; y < rows; y++)
        lcor_correct_row(plan, y, n, texels + y * row_bytes, light + y * n, NULL,
                         out + y * row_bytes, NULL);
}
