/* SPDX-License-Identifier: MIT */
/* The profile reader on any bytes: a profile that tells its contrast, survives writing and reading
 * again and gives the same, or an error with a text. */
#include <lcor/profile.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int condition)
{
    if (!condition)
        abort();
}

static char *format(const lcor_profile *profile, size_t *size)
{
    lcor_error err;
    require(lcor_profile_format(profile, NULL, 0, size, &err) == LCOR_OK);
    char *text = malloc(*size + 1);
    require(text != NULL);
    require(lcor_profile_format(profile, text, *size + 1, size, &err) == LCOR_OK);
    require(strlen(text) == *size);
    return text;
}

static void check_profile(const lcor_profile *profile)
{
    float curve[17];
    lcor_error err;
    lcor_profile *again = NULL;
    size_t size, size_again;
    const double contrast = lcor_profile_contrast(profile);
    require(contrast > 1.0 && isfinite(contrast) && lcor_profile_contrast_u95(profile) >= 0.0);
    char *text = format(profile, &size);
    require(lcor_profile_parse(text, size, NULL, &again, &err) == LCOR_OK);
    require(lcor_profile_contrast(again) == contrast);
    char *text_again = format(again, &size_again);
    require(size == size_again && memcmp(text, text_again, size) == 0);
    if (lcor_profile_tone_curve(profile, 17, curve, &err) == LCOR_OK)
        for (int i = 0; i < 16; i++)
            require(curve[i] >= 0.0f && curve[i] <= curve[i + 1] && curve[i + 1] <= 1.0f);
    free(text_again);
    free(text);
    lcor_profile_free(again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lcor_error err;
    lcor_profile *profile = NULL;
    err.text[0] = '\0';
    /* The first byte chooses black; the rest is copied so that reading past its end is seen. */
    const size_t n = size > 0 ? size - 1 : 0;
    char *text = malloc(n > 0 ? n : 1);
    require(text != NULL);
    if (n > 0)
        memcpy(text, data + 1, n);
    const lcor_profile_black black =
        size > 0 && data[0] == 'd' ? LCOR_BLACK_DARKEST : LCOR_BLACK_FULL;
    if (lcor_profile_import(text, n, black, NULL, &profile, &err) == LCOR_OK)
        check_profile(profile);
    else
        require(err.text[0] != '\0');
    free(text);
    lcor_profile_free(profile);
    return 0;
}
