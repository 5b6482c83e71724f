/* SPDX-License-Identifier: MIT */
/* What an eye, a point or a light, sees of the cells of a face past the blockers between. */
#ifndef LCOR_RADIOSITY_SIGHT_H
#define LCOR_RADIOSITY_SIGHT_H

#include "geometry/visible.h"
#include "radiosity/face.h"

enum { SIGHT_CONES = 32 };

/* What sight_cell takes away at most for integrals by a rule: its error should be that of what is
 * left. */
#define SIGHT_SMALLER 0.5

typedef struct sight {
    const lcor_scene *scene;
    const face *f;
    const uint32_t *blockers;
    size_t blocker_count;
    uint32_t whole; /* bit i: blocker i is a solid that the face's plane cuts nothing off */
    visible_eye eye;
    int crowded; /* too much in the way to clip against: rays decide */
    int count;
    visible_cone cones[SIGHT_CONES];
} sight;

/* What is looked at, past which blockers; then from where, any number of times. */
void sight_target(sight *s, const lcor_scene *scene, const face *f, const uint32_t *blockers,
                  size_t count);
void sight_aim(sight *s, const visible_eye *eye);

/* The eye of a light. */
void sight_eye_of(const lcor_light *light, visible_eye *eye);

/* Whether nothing can hide any of a cell with these corners. */
int sight_clear(const sight *s, double (*corners)[3]);

/* What is seen of a cell with these corners, of what lies on the upper side of the plane through x,
 * if normal is not NULL. 1: *set holds it, pieces of sign -1 to be taken away from the others, no
 * more than a part `most` of them; 0: there are too many pieces. */
int sight_cell(const sight *s, double (*corners)[3], const double x[3], const double normal[3],
               double most, visible_set *set);

/* Whether a ray from the cell's centre to the eye is blocked. */
int sight_centre_blocked(const sight *s, const cell *c);

#endif
