/* SPDX-License-Identifier: MIT */
/* A device profile without a file: firmware keeps the text in its code memory.
 *
 *     cc -std=c99 profile_in_memory.c $(pkg-config --cflags --libs lcor) -o profile_in_memory */
#include <lcor/lcor.h>

#include <stdio.h>
#include <string.h>

/* What lccal wrote for a printer; xxd -i makes such an array from the file. */
static const char text[] = "CGATS.17\n"
                           "NUMBER_OF_FIELDS 5\n"
                           "BEGIN_DATA_FORMAT\n"
                           "SAMPLE_ID RGB_R RGB_G RGB_B D_VIS\n"
                           "END_DATA_FORMAT\n"
                           "NUMBER_OF_SETS 5\n"
                           "BEGIN_DATA\n"
                           "1 255 255 255 0.06\n"
                           "2 255 255 255 0.06\n"
                           "3 128 128 128 0.62\n"
                           "4 0 0 0 1.42\n"
                           "5 0 0 0 1.43\n"
                           "END_DATA\n";

int main(void)
{
    lcor_error error;
    lcor_profile *profile = NULL;
    lcor_plan *plan = NULL;
    lcor_plan_options options;
    static float tone[256];

    if (lcor_profile_parse(text, sizeof text - 1, NULL, &profile, &error) != LCOR_OK) {
        fprintf(stderr, "line %ld: %s\n", error.where, error.text);
        return 1;
    }
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.contrast = lcor_profile_contrast(profile);
    options.r_mean = 0.5;
    if (lcor_profile_grey_levels(profile) > 0 &&
        lcor_profile_tone_curve(profile, 256, tone, &error) == LCOR_OK) {
        options.tone_curve = tone; /* the device's own curve; the plan copies it */
        options.tone_size = 256;
    }
    printf("contrast %.1f +- %.1f\n", options.contrast, lcor_profile_contrast_u95(profile));
    lcor_profile_free(profile);
    if (lcor_plan_new(&options, &plan, &error) != LCOR_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }

    const float grey[3] = {0.18f, 0.18f, 0.18f};
    for (int percent = 25; percent <= 200; percent *= 2) {
        const float light = (float)percent / 100.0f; /* of the mean */
        float sent[3];
        lcor_correct_row(plan, 0, 1, grey, &light, NULL, sent, NULL);
        printf("grey 18 %% in %3d %% of the mean light: send %.3f\n", percent, (double)sent[0]);
    }
    lcor_plan_free(plan);
    return 0;
}
