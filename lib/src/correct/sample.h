/* SPDX-License-Identifier: MIT */
/* One sample of any type, as 0..1. */
#ifndef LCOR_CORRECT_SAMPLE_H
#define LCOR_CORRECT_SAMPLE_H

#include <lcor/correct.h>

static inline double lcor_internal_load_sample(const void *base, lcor_sample type, size_t i)
{
    switch (type) {
    case LCOR_F32: return (double)((const float *)base)[i];
    case LCOR_F64: return ((const double *)base)[i];
    case LCOR_U8: return ((const uint8_t *)base)[i] / 255.0;
    case LCOR_U16: return ((const uint16_t *)base)[i] / 65535.0;
    }
    return 0.0;
}

/* What stands for 1. */
static inline double lcor_internal_unit(lcor_sample type)
{
    return type == LCOR_U8 ? 255.0 : type == LCOR_U16 ? 65535.0 : 1.0;
}

/* v in 0..1 */
static inline void lcor_internal_store_sample(void *base, lcor_sample type, size_t i, double v)
{
    switch (type) {
    case LCOR_F32: ((float *)base)[i] = (float)v; break;
    case LCOR_F64: ((double *)base)[i] = v; break;
    case LCOR_U8: ((uint8_t *)base)[i] = (uint8_t)(v * 255.0 + 0.5); break;
    case LCOR_U16: ((uint16_t *)base)[i] = (uint16_t)(v * 65535.0 + 0.5); break;
    }
}

static inline size_t lcor_internal_sample_size(lcor_sample type)
{
    switch (type) {
    case LCOR_F32: return 4;
    case LCOR_F64: return 8;
    case LCOR_U8: return 1;
    case LCOR_U16: return 2;
    }
    return 0;
}

#endif
