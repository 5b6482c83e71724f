/* SPDX-License-Identifier: MIT */
#include "radiosity/sight.h"

#include "geometry/vec.h"

#include <string.h>

void sight_eye_of(const lcor_light *light, visible_eye *eye)
{
    eye->parallel = light->kind == LCOR_LIGHT_DIRECTIONAL;
    for (int k = 0; k < 3; k++)
        eye->at[k] = eye->parallel ? -light->direction[k] : light->position[k];
}

/* Whether the view's plane cuts nothing off the solid. */
static int in_front(const lcor_scene *scene, const scene_solid *solid, const face *f)
{
    const scene_edge *edges = (const scene_edge *)scene->edges.items + solid->first_edge;
    const double offset = vec_dot(f->origin, f->normal) - SCENE_TOUCH * scene->diameter;

    for (size_t i = 0; i < solid->edge_count; i++)
        if (vec_dot(edges[i].p, f->normal) < offset || vec_dot(edges[i].q, f->normal) < offset)
            return 0;
    return 1;
}

/* The cone over a surface, or over what the view's plane leaves of a solid. */
static int over_parts(const lcor_scene *scene, uint32_t blocker, const visible_view *view,
                      visible_cone *cone)
{
    double points[VISIBLE_POINTS][3];
    const scene_surface *part;
    int n = 0;

    for (size_t k = 0; n >= 0 && (part = scene_blocker_part(scene, blocker, k)); k++)
        n = visible_between(view, part->corner_count, scene_corners(scene, part), n, points);
    return n < 0 ? -1
                 : visible_cone_over(cone, view, n, points, scene_solid_of(scene, blocker) != NULL);
}

/* The cone over a solid that the view's plane leaves whole: its outline are the edges between a
 * side that faces the eye and one that does not. *on: the eye is on the solid, no side faces it. */
static int over_solid(const lcor_scene *scene, const scene_solid *solid, const visible_view *view,
                      visible_cone *cone, int *on)
{
    const scene_plane *planes = (const scene_plane *)scene->planes.items + solid->first_plane;
    const scene_edge *edges = (const scene_edge *)scene->edges.items + solid->first_edge;
    unsigned char faces[SCENE_SOLID_SIDES];

    for (size_t i = 0; i < solid->plane_count; i++) {
        double d[3];

        vec_copy(view->eye.at, d);
        if (!view->eye.parallel)
            vec_sub(view->eye.at, planes[i].point, d);
        faces[i] = vec_dot(d, planes[i].normal) > 0;
        *on &= !faces[i];
    }
    if (*on)
        return 0;
    cone->n = 0;
    for (size_t i = 0; i < solid->edge_count; i++) {
        int good = 1;

        if (faces[edges[i].side[0]] != faces[edges[i].side[1]])
            good = visible_cone_add(cone, view, edges[i].p, edges[i].q, solid->middle);
        if (good <= 0)
            return good;
    }
    return cone->n >= 3;
}

void sight_target(sight *s, const lcor_scene *scene, const face *f, const uint32_t *blockers,
                  size_t count)
{
    s->scene = scene;
    s->f = f;
    s->blockers = blockers;
    s->blocker_count = count;
    s->whole = 0;
    s->crowded = s->count = 0;
    for (size_t i = 0; i < count && i < 32; i++) {
        const scene_solid *solid = scene_solid_of(scene, blockers[i]);

        if (solid && in_front(scene, solid, f))
            s->whole |= UINT32_C(1) << i;
    }
}

void sight_aim(sight *s, const visible_eye *eye)
{
    const lcor_scene *scene = s->scene;
    visible_view view;

    s->eye = *eye;
    s->crowded = s->count = 0;
    if (s->blocker_count == 0)
        return;
    view.eye = *eye;
    view.touch = SCENE_TOUCH * scene->diameter;
    vec_copy(s->f->origin, view.target);
    vec_copy(s->f->normal, view.normal);
    for (size_t i = 0; i < s->blocker_count && !s->crowded; i++) {
        const uint32_t blocker = s->blockers[i];
        const scene_solid *solid = scene_solid_of(scene, blocker);
        int cone = -1, parts = i >= 32 || !(s->whole >> i & 1);

        if (s->count < SIGHT_CONES && !parts) {
            parts = 1;
            cone = over_solid(scene, solid, &view, &s->cones[s->count], &parts);
        }
        if (s->count < SIGHT_CONES && parts)
            cone = over_parts(scene, blocker, &view, &s->cones[s->count]);
        s->crowded = cone < 0;
        s->count += cone > 0;
    }
}

/* If one cone takes away no more than `most` of what is there, that is simpler than what is left
 * around it. */
static int hide_one(const visible_cone *cone, double most, visible_set *set)
{
    visible_piece *all = &set->pieces[0], *hidden = &set->pieces[1];
    const int inside = visible_inside(all, cone, hidden);

    if (inside < 0)
        return 0;
    if (inside > 0 && most < 1 && visible_area(hidden) > most * visible_area(all))
        return visible_subtract(set, cone);
    hidden->sign = -1;
    if (inside > 0)
        set->count = visible_is(hidden, all->n, all->p[0]) ? 0 : 2;
    return 1;
}

int sight_clear(const sight *s, double (*corners)[3])
{
    visible_piece all;

    all.n = 4;
    memcpy(all.p, corners, 4 * sizeof all.p[0]);
    for (int i = 0; i < s->count; i++)
        if (!visible_apart(&all, &s->cones[i]))
            return 0;
    return !s->crowded;
}

int sight_cell(const sight *s, double (*corners)[3], const double x[3], const double normal[3],
               double most, visible_set *set)
{
    const visible_cone *near[SIGHT_CONES];
    int count = 0;

    if (s->crowded)
        return 0;
    (void)visible_start(set, 4, corners[0]);
    if (normal)
        visible_clip(set, x, normal);
    for (int i = 0; i < s->count && set->count > 0; i++)
        if (!visible_apart(&set->pieces[0], &s->cones[i]))
            near[count++] = &s->cones[i];
    if (count == 1)
        return hide_one(near[0], most, set);
    for (int i = 0; i < count && set->count > 0; i++)
        if (!visible_subtract(set, near[i]))
            return 0;
    return 1;
}

int sight_centre_blocked(const sight *s, const cell *c)
{
    double x[3];

    face_point(s->f, c->s0 + 0.5 * c->hs, c->t0 + 0.5 * c->ht, x);
    return s->eye.parallel ? lcor_scene_blocked_towards(s->scene, x, s->eye.at, s->f->surface, NULL)
                           : lcor_scene_blocked(s->scene, x, s->eye.at, s->f->surface, NULL);
}
