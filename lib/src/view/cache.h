/* SPDX-License-Identifier: MIT */
/* Indirect irradiance where the solution's answers have noise: quick estimates at places of the
 * picture, and regression on those around a place. */
#ifndef LCOR_VIEW_CACHE_H
#define LCOR_VIEW_CACHE_H

#include "base/array.h"

#include <lcor/view.h>

#include <stdint.h>

enum { CACHE_CHANNELS = 3 };

/* An estimate, valid on its plane and side within an ellipse, less and less towards its rim. */
typedef struct cache_record {
    double x[3], normal[3], radius;         /* across, */
    double along[3], stretch;               /* and `stretch` times that along a direction */
    double value[CACHE_CHANNELS], variance; /* of the mean over the channels */
    uint32_t samples;                       /* the value is the mean of */
    double exact; /* what no value holds, since it needs no estimate; mean over the channels */
    double least; /* radius, about what the picture can show */
    uint32_t surface;
    int fenced; /* something stands between it and a record within its radius */
    int shrink; /* it does not fit with those around it */
} cache_record;

/* Of a tree of halves over the records. */
typedef struct cache_node {
    double low[3], high[3]; /* around the places where a record is valid */
    double normal_low[3], normal_high[3];
    size_t first, count; /* in order */
    size_t child;        /* first of two; 0: none */
} cache_node;

typedef struct light_cache {
    const lcor_allocator *allocator;
    const lcor_scene *scene;
    size_t channels;
    double tolerance; /* relative; what the model itself may err */
    double floor;     /* irradiance below which errors are not relative any more */
    lcor_array records, nodes, order;
} light_cache;

/* Regression at a place. */
typedef struct cache_fit {
    size_t count; /* records it rests on; 0: it says nothing */
    double value[CACHE_CHANNELS];
    double deviation; /* standard deviation of the value by the records' noise, mean of channels */
    double unrest;    /* and by what they differ from the polynomial beyond their noise */
    double radius, stretch; /* means of the records' */
    double variance;        /* of one sample */
} cache_fit;

static inline cache_record *cache_record_at(const light_cache *cache, size_t i)
{
    return (cache_record *)cache->records.items + i;
}

void cache_clear(light_cache *cache);
/* To be called after records or radii have changed; 0 without memory. */
int cache_index(light_cache *cache);
/* Sets `fenced` of one record by those around it. */
void cache_fence(const light_cache *cache, size_t record);
/* By records within `part` of their radii. */
void cache_fit_at(const light_cache *cache, const double x[3], const double normal[3], double part,
                  cache_fit *out);

#endif
