/* SPDX-License-Identifier: MIT */
/* Which elements are linked: a pair is split until the error of its link is below eps of what the
 * receiver gets. */
#include "geometry/vec.h"
#include "radiosity/links.h"
#include "radiosity/transfer.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

/* Where a link's form factor is compared with its interpolation over the receiver: the ends of
 * either axis, which tell along which one the receiver is too long, and two corners. */
enum { TESTS = 6, POLL_EVERY = 64 };
static const double test_s[TESTS] = {0.02, 0.98, 0.5, 0.5, 0.02, 0.98};
static const double test_t[TESTS] = {0.5, 0.5, 0.02, 0.98, 0.02, 0.98};

/* Part of a defect seen in the worst corner that is left in the norm, and the part of a sender's
 * roughness that is left after integration. */
static const double corner_share = 0.5, rough_share = 0.3;

typedef struct pair {
    uint32_t receiver, sender;
    uint32_t first, count; /* what may stand between */
} pair;

/* Whether some of b lies in front of a. */
static int in_front(const links *l, const region *a, const region *b)
{
    const double touch = SCENE_TOUCH * l->scene->diameter;

    for (int i = 0; i < 4; i++) {
        double d[3];

        vec_sub(b->corners[i], a->corners[0], d);
        if (vec_dot(d, a->normal) > touch)
            return 1;
    }
    return 0;
}

/* 1: light may pass, with the pair's occluders narrowed down; 0: none can; -1: no memory. */
static int classify(links *l, pair *p)
{
    region r, s;
    uint32_t *room;
    long kept;

    links_region(l, links_at(l, p->receiver), &r);
    links_region(l, links_at(l, p->sender), &s);
    if (!in_front(l, &r, &s) || !in_front(l, &s, &r))
        return 0;
    if (p->count == 0)
        return 1;
    room = lcor_array_reserve(&l->allocator, &l->occluders, p->count, sizeof *room);
    if (!room)
        return -1;
    kept = occluders_between(l->scene, &r, &s, (const uint32_t *)l->occluders.items + p->first,
                             p->count, room, p->count);
    if (kept == OCCLUDERS_BLOCK)
        return 0;
    if ((uint32_t)kept < p->count) {
        p->first = (uint32_t)l->occluders.count;
        p->count = (uint32_t)kept;
        l->occluders.count += (size_t)kept;
    }
    return 1;
}

/* Point of a's box nearest to b's centre. */
static void nearest(const links_element *a, const links_element *b, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = fmax(a->low[k], fmin(a->high[k], b->centre[k]));
}

/* The receiver oracle: the form factor interpolated from the receiver's nodes against itself.
 * Returns the worst defect and, in axis[], that at the ends of each axis. */
static double measure(const links *l, const pair *p, double axis[2])
{
    const links_element *r = links_at(l, p->receiver), *s = links_at(l, p->sender);
    const face *fr = links_face_of(l, r), *fs = links_face_of(l, s);
    const transfer t = {
        l->scene, NULL,        NULL, NULL, (const uint32_t *)l->occluders.items + p->first,
        p->count, l->accuracy, -1};
    double x[RULE_Q + TESTS][3], value[RULE_Q + TESTS], worst = 0;

    for (int k = 0; k < RULE_Q; k++)
        face_point(fr, r->c.s0 + rule_x[k / RULE_P] * r->c.hs,
                   r->c.t0 + rule_x[k % RULE_P] * r->c.ht, x[k]);
    for (int i = 0; i < TESTS; i++)
        face_point(fr, r->c.s0 + test_s[i] * r->c.hs, r->c.t0 + test_t[i] * r->c.ht, x[RULE_Q + i]);
    (void)transfer_factors(&t, fr, RULE_Q + TESTS, x, fs, &s->c, value);
    axis[0] = axis[1] = 0;
    for (int i = 0; i < TESTS; i++) {
        double at_s[RULE_P], at_t[RULE_P], defect;

        rule_values(test_s[i], at_s);
        rule_values(test_t[i], at_t);
        defect = fabs(value[RULE_Q + i] - rule_interpolate(value, at_s, at_t));
        worst = fmax(worst, defect);
        if (i < 4)
            axis[i / 2] = fmax(axis[i / 2], defect);
    }
    return worst;
}

/* Longer side of an element. */
static int long_axis(const links *l, const links_element *e)
{
    double corners[4][3], a[3], b[3];

    face_cell_corners(links_face_of(l, e), &e->c, corners);
    vec_sub(corners[2], corners[3], a);
    vec_sub(corners[2], corners[1], b);
    return vec_dot(a, a) >= vec_dot(b, b) ? 0 : 1;
}

/* Defect of the receiver that splitting it along *axis would mend, times `scale`. */
static double receiver_defect(const links *l, const pair *p, double scale, int *axis)
{
    const links_element *r = links_at(l, p->receiver);
    double along[2];
    const double worst = measure(l, p, along);

    *axis = along[0] >= along[1] ? 0 : 1;
    if (links_may_split(l, r, *axis))
        return worst * scale;
    *axis = 1 - *axis;
    return links_may_split(l, r, *axis) ? along[*axis] * scale : 0;
}

typedef enum verdict { ACCEPT, SPLIT_RECEIVER, SPLIT_SENDER } verdict;

static verdict judge(const links *l, const pair *p, int *axis)
{
    const links_element *r = links_at(l, p->receiver), *s = links_at(l, p->sender);
    double from[3], qs[2], qr[2], d[3], distance, factor, scale, receiver, sender;
    int receiver_axis = 0, sender_axis;

    nearest(r, s, from);
    distance = sqrt(transfer_ellipse(from, links_face_of(l, s), &s->c, qs));
    nearest(s, r, from);
    (void)transfer_ellipse(from, links_face_of(l, r), &r->c, qr);
    vec_sub(r->centre, s->centre, d);
    distance = fmax(distance, 0.5 * (vec_length(d) - 0.5 * sqrt(r->area) - 0.5 * sqrt(s->area)));
    factor = s->area / (pi * distance * distance + s->area); /* at most, of a disc */
    scale = pow(r->area / links_at(l, (size_t)links_face_of(l, r)->root)->area, l->share_power) /
            fmax(r->e_min, l->floor);
    /* Behind an occluder's edge nothing is smooth, however far away. */
    receiver = factor * s->b_max * scale * (p->count > 0 ? 1 : pow(fmin(qr[0], qr[1]), -RULE_P));
    sender = factor * s->rough * scale * rough_share * pow(fmin(qs[0], qs[1]), -RULE_P);
    sender_axis = long_axis(l, s);
    if (!links_may_split(l, s, sender_axis))
        sender = 0;
    if (receiver > l->eps && (links_may_split(l, r, 0) || links_may_split(l, r, 1)))
        receiver = receiver_defect(l, p, s->b_max * scale * corner_share, &receiver_axis);
    else
        receiver = 0;
    if (receiver > l->eps && receiver >= sender) {
        *axis = receiver_axis;
        return SPLIT_RECEIVER;
    }
    *axis = sender_axis;
    return sender > l->eps ? SPLIT_SENDER : ACCEPT;
}

static int add_link(links *l, const pair *p, uint32_t block)
{
    links_link *link = lcor_array_reserve(&l->allocator, &l->list, 1, sizeof *link);

    if (!link)
        return 0;
    *link = (links_link){p->receiver, p->sender, p->first, p->count, block};
    l->list.count++;
    return 1;
}

/* Links receiver and sender, or their parts. `block` is what the pair has if it stays whole. */
static int refine(links *l, pair p, uint32_t block)
{
    const int passes = classify(l, &p);
    int axis;
    verdict v;

    if (passes <= 0)
        return passes == 0;
    if (l->polls++ % POLL_EVERY == 0)
        l->poll(l);
    if (l->cancelled)
        return 0;
    v = l->hurry ? ACCEPT : judge(l, &p, &axis);
    if (v == ACCEPT)
        return add_link(l, &p, block);
    for (int i = 0; i < 2; i++) {
        uint32_t *split = v == SPLIT_RECEIVER ? &p.receiver : &p.sender;
        pair part = p;

        if (links_at(l, *split)->child < 0 && !links_split(l, *split, axis))
            return 0;
        *(v == SPLIT_RECEIVER ? &part.receiver : &part.sender) =
            (uint32_t)(links_at(l, *split)->child + i);
        if (!refine(l, part, links_no_block))
            return 0;
    }
    return 1;
}

static int refine_roots(links *l)
{
    const size_t surfaces = l->scene->convex ? 0 : l->scene->surfaces.count;
    uint32_t *all;
    pair p;

    all = lcor_array_reserve(&l->allocator, &l->occluders, surfaces, sizeof *all);
    if (!all)
        return 0;
    for (size_t i = 0; i < surfaces; i++)
        all[i] = (uint32_t)i;
    p.first = (uint32_t)l->occluders.count;
    l->occluders.count += surfaces;
    for (size_t r = 0; r < l->faces.count; r++)
        for (size_t s = 0; s < l->faces.count; s++) {
            p.receiver = (uint32_t)((face *)l->faces.items)[r].root;
            p.sender = (uint32_t)((face *)l->faces.items)[s].root;
            p.count = (uint32_t)surfaces;
            if (r != s && !refine(l, p, links_no_block))
                return 0;
        }
    return 1;
}

int links_refine(links *l)
{
    lcor_array old = l->list;
    int good = 1;

    if (old.count == 0)
        return refine_roots(l);
    l->list = (lcor_array){0};
    for (size_t i = 0; good && i < old.count; i++) {
        const links_link *link = (const links_link *)old.items + i;
        const pair p = {link->receiver, link->sender, link->first_occluder, link->occluder_count};

        good = refine(l, p, link->block);
    }
    lcor_array_clear(&l->allocator, &old);
    return good;
}
