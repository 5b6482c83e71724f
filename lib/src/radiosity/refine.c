/* SPDX-License-Identifier: MIT */
/* Which elements are linked: a pair is split until the error of its link is below eps of what the
 * receiver gets. */
#include "geometry/vec.h"
#include "radiosity/links.h"
#include "radiosity/transfer.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Where a link's form factor is compared with its interpolation over the receiver: the ends of
 * either axis, which tell along which one the receiver is too long, and two corners. Where the
 * sender is close, also the place under its middle: it may light nothing else. */
enum { ENDS = 6, TESTS = ENDS + 1, POLL_EVERY = 64 };
static const double end_s[ENDS] = {0.02, 0.98, 0.5, 0.5, 0.02, 0.98};
static const double end_t[ENDS] = {0.5, 0.5, 0.02, 0.98, 0.02, 0.98};

/* Close: this part of the receiver's size. */
static const double close_by = 0.3;

/* Part of a defect seen in the worst corner that is left in the norm. */
static const double corner_share = 0.5;

/* Part of a sender's roughness that is left after integration; less where eps is less, since things
 * stand in the way. */
static const double rough_share = 0.3, rough_share_hidden = 0.2;

/* Moments keep what a rough sender sends to where all of it is seen. Past an occluder's edge the
 * errors of the part that is left do not cancel, however far away: so much of them is felt. */
static const double cut_share = 0.08;

/* In what is symmetric the first axis is taken, not what rounding says. */
static const float unequal = 1.001F;

/* In an rms the error of a small element counts little, but a patch should not be far off. */
static const double least_share = 0.2;

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

/* 1: light may pass, with the link's occluders narrowed down; 0: none can; -1: no memory. */
static int classify(links *l, links_link *p)
{
    region r, s;
    uint32_t *room;
    long kept;

    links_region(l, links_at(l, p->receiver), &r);
    links_region(l, links_at(l, p->sender), &s);
    if (!in_front(l, &r, &s) || !in_front(l, &s, &r))
        return 0;
    if (p->occluder_count == 0)
        return 1;
    room = lcor_array_reserve(&l->allocator, &l->occluders, p->occluder_count, sizeof *room);
    if (!room)
        return -1;
    kept = occluders_between(l->scene, &r, &s,
                             (const uint32_t *)l->occluders.items + p->first_occluder,
                             p->occluder_count, room, p->occluder_count);
    if (kept == OCCLUDERS_BLOCK)
        return 0;
    if ((uint32_t)kept < p->occluder_count) {
        p->first_occluder = (uint32_t)l->occluders.count;
        p->occluder_count = (uint32_t)kept;
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

/* Longer side of an element. */
static int long_axis(const links *l, const links_element *e)
{
    double corners[4][3], a[3], b[3];

    face_cell_corners(links_face_of(l, e), &e->c, corners);
    vec_sub(corners[2], corners[3], a);
    vec_sub(corners[2], corners[1], b);
    return vec_dot(b, b) > (double)unequal * vec_dot(a, a) ? 1 : 0;
}

/* Places of the tests on the receiver; returns how many. *axis: the one that the last place, under
 * the sender's middle, tells about. A smaller sender that stands on the receiver's border has it
 * moved onto the nearest line of nodes, where only what changes along that line is missed. */
static size_t place_tests(const links *l, const links_element *r, const links_element *s,
                          double at[TESTS][2], size_t *axis)
{
    static const double slack = 1e-6, smaller = 0.5;
    const face *f = links_face_of(l, r);
    double d[3], distance, foot[2];

    for (int i = 0; i < ENDS; i++) {
        at[i][0] = end_s[i];
        at[i][1] = end_t[i];
    }
    vec_sub(s->centre, f->origin, d);
    distance = vec_dot(d, f->normal);
    if (distance * distance > close_by * close_by * r->area)
        return ENDS;
    face_coordinates(f, s->centre, &foot[0], &foot[1]);
    foot[0] = (foot[0] - r->c.s0) / r->c.hs;
    foot[1] = (foot[1] - r->c.t0) / r->c.ht;
    *axis = (size_t)long_axis(l, r);
    for (size_t k = 0; k < 2; k++) {
        const int inside = foot[k] > 0 && foot[k] < 1;

        if (foot[k] < -slack || foot[k] > 1 + slack || (!inside && s->area > smaller * r->area))
            return ENDS;
        at[ENDS][k] = inside ? foot[k] : fmax(rule_x[0], fmin(rule_x[RULE_P - 1], foot[k]));
        if (!inside)
            *axis = 1 - k;
    }
    return TESTS;
}

/* The receiver oracle: the form factor interpolated from the receiver's nodes against itself. The
 * former are kept behind the last ones in use, in case the link is accepted. */
static void measure(links *l, links_link *p)
{
    const links_element *r = links_at(l, p->receiver), *s = links_at(l, p->sender);
    const face *fr = links_face_of(l, r), *fs = links_face_of(l, s);
    double x[RULE_Q + TESTS][3], value[RULE_Q + TESTS], at[TESTS][2], *kept;
    size_t middle_axis = 0;
    const size_t tests = place_tests(l, r, s, at, &middle_axis);
    transfer t;

    links_nodes(l, r, x);
    for (size_t i = 0; i < tests; i++)
        face_point(fr, r->c.s0 + at[i][0] * r->c.hs, r->c.t0 + at[i][1] * r->c.ht, x[RULE_Q + i]);
    transfer_target(&t, l->scene, fr->normal, fs,
                    (const uint32_t *)l->occluders.items + p->first_occluder, p->occluder_count,
                    l->accuracy);
    transfer_factors(&t, RULE_Q + tests, x, &s->c, value);
    kept = lcor_array_reserve(&l->allocator, &l->factors, 1, RULE_Q * sizeof *kept);
    if (kept) {
        memcpy(kept, value, RULE_Q * sizeof *kept);
        p->factors = (uint32_t)l->factors.count;
    }
    p->defect[0] = p->defect[1] = p->defect[2] = 0;
    for (size_t i = 0; i < tests; i++) {
        const size_t axis = i == ENDS ? middle_axis : i / 2;
        double at_s[RULE_P], at_t[RULE_P];
        float defect;

        rule_values(at[i][0], at_s);
        rule_values(at[i][1], at_t);
        defect = (float)fabs(value[RULE_Q + i] - rule_interpolate(value, at_s, at_t));
        if (axis < 2 && defect > p->defect[axis])
            p->defect[axis] = defect;
        if (defect > p->defect[2])
            p->defect[2] = defect;
    }
}

/* Defect of the receiver that splitting it along *axis would mend, times `scale`. */
static double receiver_defect(links *l, links_link *p, double scale, int *axis)
{
    const links_element *r = links_at(l, p->receiver);

    if (p->defect[2] < 0)
        measure(l, p);
    *axis = p->defect[1] > unequal * p->defect[0] ? 1 : 0;
    if (links_may_split(l, r, *axis))
        return (double)p->defect[2] * scale;
    *axis = 1 - *axis;
    return links_may_split(l, r, *axis) ? (double)p->defect[*axis] * scale : 0;
}

/* q^-p of the worse axis. */
static double polynomial_error(const double q[2])
{
    const double least = fmin(q[0], q[1]), squared = least * least;

    return 1 / (squared * squared);
}

typedef enum verdict { ACCEPT, SPLIT_RECEIVER, SPLIT_SENDER } verdict;

static verdict judge(links *l, links_link *p, int *axis)
{
    const links_element *r = links_at(l, p->receiver), *s = links_at(l, p->sender);
    const double least = fmax(r->e_min, l->floor);
    const double face_area = links_at(l, (size_t)links_face_of(l, r)->root)->area;
    double from[3], qs[2], qr[2], d[3], distance, factor, scale, felt, receiver, sender;
    int receiver_axis = 0, sender_axis;

    nearest(r, s, from);
    distance = sqrt(transfer_ellipse(from, links_face_of(l, s), &s->c, qs));
    nearest(s, r, from);
    (void)transfer_ellipse(from, links_face_of(l, r), &r->c, qr);
    vec_sub(r->centre, s->centre, d);
    distance = fmax(distance, 0.5 * (vec_length(d) - 0.5 * sqrt(r->area) - 0.5 * sqrt(s->area)));
    factor = s->area / (pi * distance * distance + s->area); /* at most, of a disc */
    scale = (l->share ? fmax(least_share, sqrt(r->area / face_area)) : 1) / least;
    /* Behind an occluder's edge nothing is smooth, however far away. */
    receiver = factor * s->b_max * scale * (p->occluder_count > 0 ? 1 : polynomial_error(qr));
    felt = p->occluder_count > 0 ? fmax(polynomial_error(qs), cut_share) : polynomial_error(qs);
    felt *= l->scene->convex ? rough_share : rough_share_hidden;
    sender = factor * s->rough * scale * felt;
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

/* Keeps the link, with its coefficients if they are accurate enough for what the receiver gets: a
 * bright sender needs better ones than a dark one. */
static int add_link(links *l, links_link *p)
{
    const links_element *r = links_at(l, p->receiver), *s = links_at(l, p->sender);
    links_link *link = lcor_array_reserve(&l->allocator, &l->list, 1, sizeof *link);
    const double wanted = l->accuracy * fmax(r->e_min, l->floor) / fmax(s->b_max, l->floor);

    if (!link)
        return 0;
    if (p->block == links_no_block || (double)p->accuracy > 2 * wanted) {
        p->block = links_no_block;
        p->accuracy = (float)wanted;
    }
    *link = *p;
    if (p->block == links_no_block && p->factors == l->factors.count)
        l->factors.count++;
    else
        link->factors = links_no_block;
    l->list.count++;
    return 1;
}

/* Links receiver and sender, or their parts. */
static int refine(links *l, links_link p)
{
    int axis;
    verdict v;

    if (l->polls++ % POLL_EVERY == 0)
        l->poll(l);
    if (l->cancelled)
        return 0;
    v = l->hurry ? ACCEPT : judge(l, &p, &axis);
    if (v == ACCEPT)
        return add_link(l, &p);
    p.block = p.factors = links_no_block;
    p.defect[2] = -1;
    for (int i = 0; i < 2; i++) {
        uint32_t *split = v == SPLIT_RECEIVER ? &p.receiver : &p.sender;
        links_link part = p;
        int passes;

        if (links_at(l, *split)->child < 0 && !links_split(l, *split, axis))
            return 0;
        *(v == SPLIT_RECEIVER ? &part.receiver : &part.sender) =
            (uint32_t)(links_at(l, *split)->child + i);
        passes = classify(l, &part);
        if (passes < 0 || (passes > 0 && !refine(l, part)))
            return 0;
    }
    return 1;
}

/* The list of all that may hide something, blockers or single shapes, as a pair starts with. */
static int list_all(links *l, int single, links_link *p)
{
    size_t count;
    const uint32_t *in = occluders_of(l->scene, single, &count);
    uint32_t *out = lcor_array_reserve(&l->allocator, &l->occluders, count, sizeof *out);

    if (!out)
        return 0;
    for (size_t i = 0; i < count; i++)
        out[i] = in[i];
    p->first_occluder = (uint32_t)l->occluders.count;
    p->occluder_count = (uint32_t)count;
    l->occluders.count += count;
    return 1;
}

static int refine_roots(links *l)
{
    const links_link none = {0, 0, 0, 0, links_no_block, links_no_block, 0, {0, 0, -1}};
    links_link start[2];

    l->pairs_apart = l->pairs_open = l->pairs_tested = 0;
    for (int single = 0; single < 2; single++) {
        start[single] = none;
        if (!l->scene->convex && !list_all(l, single, &start[single]))
            return 0;
    }
    for (size_t r = 0; r < l->faces.count; r++)
        for (size_t s = 0; s < l->faces.count; s++) {
            const face *to = (const face *)l->faces.items + r;
            const face *from = (const face *)l->faces.items + s;
            links_link p = start[to->back || from->back];
            int passes;

            p.receiver = (uint32_t)to->root;
            p.sender = (uint32_t)from->root;
            if (r == s)
                continue;
            passes = classify(l, &p);
            *(passes == 0             ? &l->pairs_apart
              : p.occluder_count == 0 ? &l->pairs_open
                                      : &l->pairs_tested) += 1;
            if (passes < 0 || (passes > 0 && !refine(l, p)))
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
    for (size_t i = 0; good && i < old.count; i++)
        good = refine(l, ((const links_link *)old.items)[i]);
    lcor_array_clear(&l->allocator, &old);
    return good;
}
