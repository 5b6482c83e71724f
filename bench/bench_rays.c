/* SPDX-License-Identifier: MIT */
/* How fast rays are answered: the library's hierarchy beside Embree, ray by ray on one thread, the
 * same rays in the furnished room.
 *
 *   bench_rays [FILE.json]
 *
 * Embree decides in float, the library in double. The two take turns of a millisecond. A round
 * takes each turn several times and adds up the shortest times of each, so that what else the
 * machine does touches both alike; the ratio is the median of the rounds, beside the least and
 * the greatest. Without Embree its columns are zero. */
#include "report.h"
#include "scenes.h"

#include "base/internal.h"
#include "geometry/bvh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef LCOR_EMBREE
#include <embree3/rtcore.h>
#endif

enum { RAYS = 100000, TURN = 4000, TURNS = RAYS / TURN, REPEAT = 7, ROUNDS = 7 };

typedef struct engines {
    lcor_bvh *own;
#ifdef LCOR_EMBREE
    RTCDevice device;
    RTCScene embree;
#endif
} engines;

static lcor_ray rays[RAYS];
static uint32_t own_hit[RAYS], peer_hit[RAYS]; /* triangle, or LCOR_BVH_NONE */

static void build(engines *e, const bench_scene *scene)
{
    lcor_bvh_prim *prims = calloc(scene->count, sizeof *prims);
    lcor_allocator allocator;
    double n[3];

    if (!prims || lcor_internal_allocator(NULL, &allocator, NULL) != LCOR_OK)
        exit(1);
    for (size_t i = 0; i < scene->count; i++) {
        memcpy(prims[i].origin, scene->corners[i], sizeof prims[i].origin);
        (void)bench_triangle(scene->corners[i], prims[i].edge_u, prims[i].edge_v, n);
        prims[i].owner = (uint32_t)i;
    }
    if (lcor_bvh_new(scene->count, prims, &allocator, NULL, &e->own, NULL) != LCOR_OK)
        exit(1);
    free(prims);
#ifdef LCOR_EMBREE
    {
        RTCGeometry geometry;
        float *vertices;
        unsigned *indices;

        e->device = rtcNewDevice("threads=1");
        e->embree = rtcNewScene(e->device);
        geometry = rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           12, 3 * scene->count);
        indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                          scene->count);
        for (size_t i = 0; i < 9 * scene->count; i++)
            vertices[i] = (float)scene->corners[i / 9][i % 9];
        for (size_t i = 0; i < 3 * scene->count; i++)
            indices[i] = (unsigned)i;
        rtcCommitGeometry(geometry);
        (void)rtcAttachGeometry(e->embree, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(e->embree);
    }
#endif
}

static void own_rays(const engines *e, int occlusion, int first)
{
    for (int i = first; i < first + TURN; i++) {
        lcor_bvh_hit hit;

        if (occlusion)
            own_hit[i] = lcor_bvh_occluded(e->own, &rays[i], NULL) ? 0 : LCOR_BVH_NONE;
        else
            own_hit[i] = lcor_bvh_closest(e->own, &rays[i], &hit) ? hit.owner : LCOR_BVH_NONE;
    }
}

#ifdef LCOR_EMBREE
static void peer_rays(const engines *e, int occlusion, int first)
{
    for (int i = first; i < first + TURN; i++) {
        const lcor_ray *r = &rays[i];
        struct RTCIntersectContext context;
        struct RTCRayHit q;

        rtcInitIntersectContext(&context);
        q.ray.org_x = (float)r->origin[0];
        q.ray.org_y = (float)r->origin[1];
        q.ray.org_z = (float)r->origin[2];
        q.ray.dir_x = (float)r->direction[0];
        q.ray.dir_y = (float)r->direction[1];
        q.ray.dir_z = (float)r->direction[2];
        q.ray.tnear = (float)r->t_min;
        q.ray.tfar = isfinite(r->t_max) ? (float)r->t_max : (float)HUGE_VAL;
        q.ray.mask = UINT32_MAX;
        q.ray.time = 0;
        q.ray.flags = 0;
        q.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        if (occlusion) {
            rtcOccluded1(e->embree, &context, &q.ray);
            peer_hit[i] = q.ray.tfar < 0 ? 0 : LCOR_BVH_NONE;
        } else {
            rtcIntersect1(e->embree, &context, &q);
            peer_hit[i] = q.hit.geomID == RTC_INVALID_GEOMETRY_ID ? LCOR_BVH_NONE : q.hit.primID;
        }
    }
}
#endif

/* A direction about n, density proportional to the cosine. */
static void cosine(const double n[3], uint64_t *state, double d[3])
{
    const double phi = 6.283185307179586 * bench_random(state), r2 = bench_random(state);
    const int k = fabs(n[0]) > 0.6 ? 0 : fabs(n[1]) > 0.6 ? 1 : 2;
    const double s = copysign(1, n[k]);
    double a[3] = {0, 0, 0}, b[3], length;

    a[(k + 1) % 3] = n[k];
    a[k] = -n[(k + 1) % 3];
    length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) * s;
    for (int j = 0; j < 3; j++)
        a[j] /= length;
    for (int j = 0; j < 3; j++)
        b[j] = n[(j + 1) % 3] * a[(j + 2) % 3] - n[(j + 2) % 3] * a[(j + 1) % 3];
    for (int j = 0; j < 3; j++)
        d[j] = sqrt(r2) * (cos(phi) * a[j] + sin(phi) * b[j]) + sqrt(1 - r2) * n[j];
}

enum { COHERENT, COSINE, SHADOW };

/* COHERENT: a picture from beside the door. COSINE: from points all over the surfaces. SHADOW: from
 * such points to a lamp. Both leave their own triangle out, as the library's rays do; for Embree
 * they start a hair above it. */
static void make_rays(const bench_scene *scene, int kind)
{
    uint64_t state = 1234567;
    const int side = 316;

    for (int i = 0; i < RAYS; i++) {
        lcor_ray *r = &rays[i];
        double n[3];

        r->t_min = 1e-4;
        r->t_max = HUGE_VAL;
        r->skip = LCOR_BVH_NONE;
        if (kind == COHERENT) {
            r->origin[0] = 0.3;
            r->origin[1] = 0.3;
            r->origin[2] = 1.7;
            r->direction[0] = 1 - 0.5 * (double)(i % side) / side;
            r->direction[1] = 0.3 + 0.8 * (double)(i % side) / side;
            r->direction[2] = 0.3 - 0.9 * (double)(i / side) / side;
            continue;
        }
        r->skip = (uint32_t)bench_random_point(scene, &state, r->origin, n);
        if (kind == COSINE) {
            cosine(n, &state, r->direction);
        } else {
            const double *to = scene->lights[i % 2].position;

            for (int k = 0; k < 3; k++)
                r->direction[k] = to[k] - r->origin[k];
            r->t_max = 1 - 1e-6;
        }
    }
}

/* Seconds that all rays take, by the shortest time of each turn. */
static void measure(const engines *e, int occlusion, double *own, double *peer)
{
    double best[2][TURNS];

    for (int k = 0; k < REPEAT; k++)
        for (int turn = 0; turn < TURNS; turn++) {
            double lap[3];

            lap[0] = bench_seconds();
            own_rays(e, occlusion, turn * TURN);
            lap[1] = bench_seconds();
#ifdef LCOR_EMBREE
            peer_rays(e, occlusion, turn * TURN);
#endif
            lap[2] = bench_seconds();
            for (int who = 0; who < 2; who++) {
                const double seconds = lap[who + 1] - lap[who];

                best[who][turn] = k > 0 ? fmin(best[who][turn], seconds) : seconds;
            }
        }
    *own = *peer = 0;
    for (int turn = 0; turn < TURNS; turn++) {
        *own += best[0][turn];
        *peer += best[1][turn];
    }
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static void compare(const engines *e, const bench_scene *scene, int kind, int occlusion)
{
    double own = HUGE_VAL, peer = HUGE_VAL, differ = 0, ratio[ROUNDS];

    make_rays(scene, kind);
    for (int round = 0; round < ROUNDS; round++) {
        double seconds[2];

        measure(e, occlusion, &seconds[0], &seconds[1]);
        ratio[round] = seconds[1] / seconds[0];
        own = fmin(own, seconds[0]);
        peer = fmin(peer, seconds[1]);
    }
    qsort(ratio, ROUNDS, sizeof ratio[0], compare_doubles);
    for (int i = 0; i < RAYS; i++)
        differ += own_hit[i] != peer_hit[i];
    report_row((const double[8]){kind, occlusion, 1e-6 * RAYS / own, 1e-6 * RAYS / peer,
                                 ratio[ROUNDS / 2], ratio[0], ratio[ROUNDS - 1], differ / RAYS},
               8);
}

int main(int argc, char **argv)
{
    bench_scene scene;
    engines e;

    if (!report_open("bench_rays", argc > 1 ? argv[1] : NULL))
        return 1;
    bench_furnished_room(&scene, 6000);
    build(&e, &scene);
    report_table(
        "Rays in the furnished room beside Embree",
        "One thread, one ray at a time, million rays a second. Rays 0: a picture, 1: cosine "
        "rays from all surfaces, 2: to the lamps. The last column is the share of rays "
        "whose answers differ: Embree's are float.",
        "\"rays\", \"any hit\", \"lcor\", \"Embree\", \"lcor over Embree\", \"least\", "
        "\"greatest\", "
        "\"differ\"");
    compare(&e, &scene, COHERENT, 0);
    compare(&e, &scene, COSINE, 0);
    compare(&e, &scene, COHERENT, 1);
    compare(&e, &scene, COSINE, 1);
    compare(&e, &scene, SHADOW, 1);
    lcor_bvh_free(e.own);
#ifdef LCOR_EMBREE
    rtcReleaseScene(e.embree);
    rtcReleaseDevice(e.device);
#endif
    bench_scene_free(&scene);
    return report_close() ? 0 : 1;
}
