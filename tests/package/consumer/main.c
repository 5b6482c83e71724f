/* SPDX-License-Identifier: MIT */
/* A client that is both C99 and C++11: mid-grey under mean illuminance stays what eq 12 says. */
#include <lcor/lcor.h>

#include <stdio.h>
#include <string.h>

int main(void)
{
    lcor_plan_options options;
    lcor_plan *plan = NULL;
    lcor_error error;
    float pixel[3] = {0.5f, 0.5f, 0.5f}, illuminance = 1.0f;

    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.contrast = 23.4;
    options.r_mean = 0.5;
    options.rho = 0.5;
    if (lcor_plan_new(&options, &plan, &error) != LCOR_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    lcor_correct_row(plan, 0, 1, pixel, &illuminance, NULL, pixel, NULL);
    lcor_plan_free(plan);
    printf("lcor %s: %.4f\n", lcor_version(), (double)pixel[0]);
    return pixel[0] > 0.499f && pixel[0] < 0.501f ? 0 : 1;
}
