/* SPDX-License-Identifier: MIT */
/* One sample of any type, as 0..1. */
#ifndef LCOR_CORRECT_SAMPLE_H
#define LCOR_CORRECT_SAMPLE_H

#include <lcor/correct.h>

double lcor_internal_load_sample(const void *base, lcor_sample type, size_t i);
void lcor_internal_store_sample(void *base, lcor_sample type, size_t i, double v); /* v in 0..1 */
size_t lcor_internal_sample_size(lcor_sample type);

#endif
