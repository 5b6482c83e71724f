/* SPDX-License-Identifier: MIT */
/** @file
 *  Irradiance by radiosity (section 3.1, [Nishimura 1988]) to a requested accuracy.
 *
 *  | call                              | may run at the same time as                   |
 *  |-----------------------------------|-----------------------------------------------|
 *  | lcor_radiosity_solve              | const calls on the scene                      |
 *  | calls on a const lcor_solution    | any const calls on it and on its scene        |
 *  | lcor_solution_update, _free       | nothing on that solution                      |
 *
 *  A solution refers to its scene: keep the scene alive until lcor_solution_free. */
#ifndef LCOR_RADIOSITY_H
#define LCOR_RADIOSITY_H

#include <lcor/alloc.h>
#include <lcor/parallel.h>
#include <lcor/scene.h>
#include <lcor/status.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lcor_solution lcor_solution;

/** Error norms over patches of (E - E_true) / max(E_true, 2 % of the scene's area mean). */
typedef enum lcor_norm {
    LCOR_NORM_RMS = 0, /**< area-weighted root mean square */
    LCOR_NORM_MAX = 1  /**< the largest */
} lcor_norm;

/** How indirect light is found. All give the same answers within the tolerance. */
typedef enum lcor_engine {
    LCOR_ENGINE_AUTO = 0,   /**< the one that is estimated to be done sooner, by the scene's pairs
                                 of surfaces, what may hide them, reflectances, the tolerance, and
                                 `points`; paths only if `points` is set */
    LCOR_ENGINE_LINKS = 1,  /**< exact factors and visibility, no noise; at most 2000 faces */
    LCOR_ENGINE_GATHER = 2, /**< rays, for any number of surfaces; meant for 0.2 % and more */
    LCOR_ENGINE_PATHS = 3   /**< rays too, but nothing is made ahead: an answer takes several times
                                 as long, the first one is there at once. For few places; patches
                                 and pictures work and are slow */
} lcor_engine;

/** Zero it, set struct_size and what differs. */
typedef struct lcor_radiosity_options {
    size_t struct_size;
    double tolerance; /**< requested error in `norm`, 1e-5..1; 0 = 0.01 */
    lcor_norm norm;
    lcor_engine engine;
    int channels;        /**< 0: 1 if lights and emission are all grey, else 3 */
    double luminance[3]; /**< weights of the channels where they are solved as one; zeros:
                              those of BT.709, 0.2126, 0.7152, 0.0722 */
    double max_seconds;  /**< of processor time; 0 = no limit. On reaching one the best solution is
                            returned */
    uint64_t max_bytes; /**< 0 = no limit; as above, with report.converged = 0, which is no error */
    lcor_parallel parallel;
    lcor_progress progress;
    lcor_allocator allocator;
    uint64_t points; /**< so many places will be asked for, points and patches; 0 = many, or not
                          known. A hint: for few, LCOR_ENGINE_AUTO may trace paths and prepare
                          nothing, and the error is estimated from fewer places. More may be asked
                          for all the same */
} lcor_radiosity_options;

/** Why the solver chose as it did; lcor_reason_text says it in words. */
typedef enum lcor_reason {
    LCOR_REASON_ASKED = 0, /**< an option says so */
    LCOR_REASON_COST,      /**< engine: the one estimated to be done sooner */
    LCOR_REASON_CONVEX,    /**< no visibility tests: no surface has another one on either side */
    LCOR_REASON_CLUTTER,   /**< visibility tests: surfaces stand before others */
    LCOR_REASON_GREY,      /**< one channel: all lights and emission are grey */
    LCOR_REASON_COLOURED   /**< three channels: a light or emission has a colour */
} lcor_reason;

/** What was done and how close it came. */
typedef struct lcor_radiosity_report {
    double error_rms, error_max; /**< estimated; max as sampled */
    double energy_defect;        /**< |power in - absorbed - escaped| / power in; 0 with gather
                                    and paths, whose rays carry irradiance and keep no balance of power */
    int converged;               /**< the requested norm's estimate is within tolerance */
    int iterations;              /**< of the linear solve, last round */
    int channels;
    lcor_engine engine;
    uint64_t links, elements, rays, bytes; /**< bytes: the largest held at once */
    double seconds;
    /** Processor seconds estimated for each engine when LCOR_ENGINE_AUTO chose between them, the
     *  answers at options.points included; infinite where one cannot do it; 0 when the caller
     *  chose. */
    double links_seconds, gather_seconds;
    char models[256]; /**< what the scene required and what was switched off, and why */
    lcor_reason engine_reason, visibility_reason, channels_reason;
    /** Of engine links, pairs of faces, each as receiver of the other: those that cannot see each
     *  other, see each other fully, and are tested. Zeros of other engines. */
    uint64_t pairs_apart, pairs_open, pairs_tested;
    /** Of engine links: so many surfaces, coplanar neighbours that look alike and make up
     *  parallelograms, are solved as so many larger ones. Results stay per surface. */
    uint64_t surfaces_merged, merged_into;
    double paths_seconds; /**< like links_seconds; infinite if options.points is 0 */
} lcor_radiosity_report;

/** The reason in English, a few words without a full stop; never NULL. */
LCOR_API const char *lcor_reason_text(lcor_reason reason);

/** Solve a committed scene.
 *
 *  Errors: LCOR_ERR_ARG scene not committed or options wrong; LCOR_ERR_DOMAIN tolerance;
 *  LCOR_ERR_NOMEM; LCOR_ERR_CANCELLED. A dark scene is no error: all irradiance is 0. */
LCOR_API lcor_status lcor_radiosity_solve(const lcor_scene *scene,
                                          const lcor_radiosity_options *options,
                                          lcor_solution **out, lcor_error *err);
/** Solve again after lcor_scene_set_light or lcor_scene_set_surface, keeping what still holds. */
LCOR_API lcor_status lcor_solution_update(lcor_solution *solution, lcor_error *err);
LCOR_API void lcor_solution_free(lcor_solution *solution);
LCOR_API const lcor_radiosity_report *lcor_solution_report(const lcor_solution *solution);

typedef enum lcor_value { LCOR_VALUE_AVERAGE = 0, LCOR_VALUE_CENTRE = 1 } lcor_value;

/** Irradiance of every patch of a surface (facing side). `direct` is what comes from the lights
 *  without area on a straight way; light of emitting surfaces is in `total` only.
 *
 *  @param total, direct  patch count * report.channels values each, channel fastest, patch [i, j]
 *                        of a quad at i * nv + j; either may be NULL. Unit: the lights' (lux for
 *                        candela and scene units of metres). */
LCOR_API lcor_status lcor_solution_patches(const lcor_solution *solution, size_t surface,
                                           lcor_value value, double *total, double *direct,
                                           lcor_error *err);

/** Irradiance at n points with normals of any length (3 numbers each): direct is exact with its
 *  shadows. Points on a surface belong to the side their normal is on. n * report.channels values.
 *
 *  Errors: LCOR_ERR_DOMAIN names the first point that is not finite or normal without direction. */
LCOR_API lcor_status lcor_solution_at(const lcor_solution *solution, size_t n, const double *points,
                                      const double *normals, double *total, double *direct,
                                      lcor_error *err);

#ifdef __cplusplus
}
#endif

#endif
