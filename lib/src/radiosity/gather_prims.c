/* SPDX-License-Identifier: MIT */
#include "radiosity/gather.h"

#include "geometry/vec.h"

static gather_prim *prim_at(const gather *g, size_t i) { return (gather_prim *)g->prims.items + i; }

int gather_list_prims(gather *g)
{
    double area = 0;

    for (size_t i = 0; i < g->scene->surfaces.count; i++) {
        const scene_surface *f = scene_surface_at(g->scene, i);
        const size_t fan = f->shape == SCENE_QUAD ? 1 : f->corner_count - 2;
        gather_prim *p = lcor_array_reserve(g->allocator, &g->prims, fan + 1, sizeof *p);

        if (!p)
            return 0;
        for (size_t j = 0; j < fan; j++) {
            double origin[3], u[3], v[3], cross[3];
            int triangle;

            p[j] = (gather_prim){(uint32_t)i, (uint32_t)(j + 1), area};
            triangle = gather_prim_frame(g, g->prims.count++, origin, u, v);
            vec_cross(u, v, cross);
            area += (triangle ? 0.5 : 1) * vec_length(cross);
        }
        p[fan] = (gather_prim){0, 0, area};
    }
    return 1;
}

int gather_prim_frame(const gather *g, size_t prim, double origin[3], double u[3], double v[3])
{
    const gather_prim *p = prim_at(g, prim);
    const scene_surface *f = scene_surface_at(g->scene, p->surface);
    const double *corner = scene_corners(g->scene, f);

    vec_copy(corner, origin);
    if (f->shape == SCENE_QUAD) {
        vec_copy(f->edge_u, u);
        vec_copy(f->edge_v, v);
        return 0;
    }
    vec_sub(corner + 3 * (size_t)p->corner, corner, u);
    vec_sub(corner + 3 * (size_t)(p->corner + 1), corner, v);
    return 1;
}

void gather_square_to_edges(int triangle, const double q[2], double st[2])
{
    if (triangle) {
        const double s = sqrt(q[0]);

        st[0] = s * (1 - q[1]);
        st[1] = s * q[1];
    } else {
        st[0] = q[0];
        st[1] = q[1];
    }
}

size_t gather_place(const gather *g, double a, double b, gather_stand *stand)
{
    const double wanted = a * prim_at(g, g->prims.count)->area_before;
    size_t low = 0, high = g->prims.count - 1;
    double origin[3], u[3], v[3], q[2], st[2], area;

    while (low < high) { /* the last that begins at or before the wanted area */
        const size_t middle = (low + high + 1) / 2;

        if (prim_at(g, middle)->area_before <= wanted)
            low = middle;
        else
            high = middle - 1;
    }
    area = prim_at(g, low + 1)->area_before - prim_at(g, low)->area_before;
    q[0] = area > 0 ? fmin(fmax((wanted - prim_at(g, low)->area_before) / area, 0), 1) : 0.5;
    q[1] = b;
    gather_square_to_edges(gather_prim_frame(g, low, origin, u, v), q, st);
    gather_stand_on(g, prim_at(g, low)->surface, 0, stand);
    vec_plane_point(origin, u, v, st[0], st[1], stand->x);
    return low;
}
