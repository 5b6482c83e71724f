/* SPDX-License-Identifier: MIT */
/* Every row of the view factor reference: from a point by the closed form, between areas by the
 * solver's quadrature of it. */
#include "geometry/factor.h"
#include "radiosity/rule.h"
#include "testing.h"

/* value of name in "a=1;b=2" */
static double parameter(const char *text, const char *name)
{
    const size_t length = strlen(name);

    for (const char *p = text; p; p = strchr(p, ';') ? strchr(p, ';') + 1 : NULL)
        if (strncmp(p, name, length) == 0 && p[length] == '=')
            return strtod(p + length + 1, NULL);
    fail_msg("no %s in %s", name, text);
    return 0;
}

typedef struct rectangle { /* origin + s u + t v */
    double origin[3], u[3], v[3], normal[3];
} rectangle;

static void corners_of(const rectangle *r, double corners[12])
{
    for (int k = 0; k < 3; k++) {
        corners[k] = r->origin[k];
        corners[3 + k] = r->origin[k] + r->u[k];
        corners[6 + k] = r->origin[k] + r->u[k] + r->v[k];
        corners[9 + k] = r->origin[k] + r->v[k];
    }
}

/* Nodes crowd at the edges, where two areas that nearly touch see less of each other. */
static double graded(double z) { return z * z * (3 - 2 * z); }
static double slope(double z) { return 6 * z * (1 - z); }

/* Mean over s0..s0+hs, t0..t0+ht of the factor from points of `from`, by one cell of the rule. */
static double cell_mean(const rectangle *from, const double to[12], double s0, double t0, double hs,
                        double ht)
{
    double sum = 0;

    for (int i = 0; i < RULE_Q; i++) {
        const double s = s0 + hs * rule_x[i / RULE_P], t = t0 + ht * rule_x[i % RULE_P];
        double x[3];

        for (int k = 0; k < 3; k++)
            x[k] = from->origin[k] + graded(s) * from->u[k] + graded(t) * from->v[k];
        sum += rule_w[i / RULE_P] * rule_w[i % RULE_P] * slope(s) * slope(t) *
               lcor_factor_point(x, from->normal, 4, to);
    }
    return sum;
}

enum { DEPTH = 40 };

/* Halves the cell along the axis that changes the mean more until that is below `accuracy`. */
static double adaptive(const rectangle *from, const double to[12], double s0, double t0, double hs,
                       double ht, double whole, double accuracy, int depth)
{
    double half[2][2], change[2];
    int axis;

    for (int a = 0; a < 2; a++) {
        const double h = a == 0 ? hs / 2 : hs, w = a == 1 ? ht / 2 : ht;

        half[a][0] = cell_mean(from, to, s0, t0, h, w);
        half[a][1] = cell_mean(from, to, s0 + (a == 0 ? h : 0), t0 + (a == 1 ? w : 0), h, w);
        change[a] = fabs(0.5 * (half[a][0] + half[a][1]) - whole) * hs * ht;
    }
    axis = change[0] >= change[1] ? 0 : 1;
    if (depth == 0 || (depth <= DEPTH - 8 && change[axis] <= accuracy))
        return 0.5 * (half[axis][0] + half[axis][1]) * hs * ht;
    hs /= axis == 0 ? 2 : 1;
    ht /= axis == 1 ? 2 : 1;
    return adaptive(from, to, s0, t0, hs, ht, half[axis][0], accuracy, depth - 1) +
           adaptive(from, to, s0 + (axis == 0 ? hs : 0), t0 + (axis == 1 ? ht : 0), hs, ht,
                    half[axis][1], accuracy, depth - 1);
}

static double area_factor(const rectangle *from, const rectangle *to, double expected)
{
    double corners[12];

    corners_of(to, corners);
    return adaptive(from, corners, 0, 0, 1, 1, cell_mean(from, corners, 0, 0, 1, 1),
                    1e-8 * expected, DEPTH);
}

static double area(const rectangle *r)
{
    double uu = 0, vv = 0;

    for (int k = 0; k < 3; k++) {
        uu += r->u[k] * r->u[k];
        vv += r->v[k] * r->v[k];
    }
    return sqrt(uu * vv);
}

static rectangle make(double ox, double oy, double oz, int u_axis, double u, int v_axis, double v,
                      int normal_axis, double sign)
{
    rectangle r = {{ox, oy, oz}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};

    r.u[u_axis] = u;
    r.v[v_axis] = v;
    r.normal[normal_axis] = sign;
    return r;
}

/* Rectangles of the row; 0 if the row is of another kind. */
static int rectangles(const char *kind, const char *p, rectangle *a, rectangle *b)
{
    if (strcmp(kind, "parallel_aligned") == 0) {
        *a = make(0, 0, 0, 0, parameter(p, "a"), 1, parameter(p, "b"), 2, 1);
        *b = *a;
        b->origin[2] = parameter(p, "c");
    } else if (strcmp(kind, "parallel_offset") == 0) {
        *a = make(parameter(p, "x1"), parameter(p, "y1"), 0, 0,
                  parameter(p, "x2") - parameter(p, "x1"), 1,
                  parameter(p, "y2") - parameter(p, "y1"), 2, 1);
        *b = make(parameter(p, "xi1"), parameter(p, "eta1"), parameter(p, "z"), 0,
                  parameter(p, "xi2") - parameter(p, "xi1"), 1,
                  parameter(p, "eta2") - parameter(p, "eta1"), 2, -1);
    } else if (strcmp(kind, "perpendicular_shared_edge") == 0) {
        *a = make(0, 0, 0, 0, parameter(p, "l"), 1, parameter(p, "w"), 2, 1);
        *b = make(0, 0, 0, 0, parameter(p, "l"), 2, parameter(p, "h"), 1, 1);
    } else if (strcmp(kind, "perpendicular_general") == 0) {
        /* A1 in z = 0 over x, y; A2 in x = 0 over y = eta and z. */
        *a = make(parameter(p, "x1"), parameter(p, "y1"), 0, 0,
                  parameter(p, "x2") - parameter(p, "x1"), 1,
                  parameter(p, "y2") - parameter(p, "y1"), 2, 1);
        *b = make(0, parameter(p, "eta1"), parameter(p, "z1"), 1,
                  parameter(p, "eta2") - parameter(p, "eta1"), 2,
                  parameter(p, "z2") - parameter(p, "z1"), 0, 1);
    } else {
        return 0;
    }
    return 1;
}

/* A strip without end, cut at 1e7: from the middle line the ends do not matter. */
static double strip_factor(const char *kind, const char *p)
{
    const double far = 1e7, degree = 3.14159265358979323846 / 180;
    double sum = 0, width = 1, corners[12] = {0};
    int cells = 400;

    for (int i = 0; i < cells; i++)
        for (int g = 0; g < RULE_P; g++) {
            /* graded towards both edges */
            const double z0 = (double)i / cells, z = z0 + rule_x[g] / cells;
            const double at = graded(z), w = slope(z) * rule_w[g] / cells;
            const double x[3] = {at * width, 0, 0}, normal[3] = {0, 0, 1};
            double q[2][2];

            if (strcmp(kind, "infinite_parallel_strips") == 0) {
                const double h = parameter(p, "h");

                q[0][0] = 0, q[0][1] = h, q[1][0] = parameter(p, "w"), q[1][1] = h;
            } else if (strcmp(kind, "infinite_perpendicular_strips") == 0) {
                q[0][0] = 0, q[0][1] = 0, q[1][0] = 0, q[1][1] = parameter(p, "h_over_w");
            } else {
                const double angle = parameter(p, "angle_deg") * degree;

                q[0][0] = 0, q[0][1] = 0, q[1][0] = cos(angle), q[1][1] = sin(angle);
            }
            for (int c = 0; c < 4; c++) {
                const int end = c == 1 || c == 2;

                corners[3 * c] = q[end][0];
                corners[3 * c + 1] = c < 2 ? -far : far;
                corners[3 * c + 2] = q[end][1];
            }
            sum += w * lcor_factor_point(x, normal, 4, corners);
        }
    return sum;
}

/* Disc 1 in z = 0 sees disc 2 in z = h, cut into thin triangles of the same area together. */
static double disc_factor(const char *p)
{
    enum { SECTORS = 1500, CELLS = 40 };
    const double r1 = parameter(p, "r1"), r2 = parameter(p, "r2"), h = parameter(p, "h");
    const double step = 2 * 3.14159265358979323846 / SECTORS;
    const double grown = r2 * sqrt(step / sin(step)), normal[3] = {0, 0, 1};
    double sum = 0;

    for (int i = 0; i < CELLS; i++)
        for (int g = 0; g < RULE_P; g++) {
            const double z = (i + rule_x[g]) / CELLS, rho = r1 * (1 - z * z * z); /* to the rim */
            const double w = 2 * rho / r1 * 3 * z * z * rule_w[g] / CELLS;
            const double x[3] = {rho, 0, 0};
            double seen = 0;

            for (int k = 0; k < SECTORS / 2; k++) { /* the other half is its mirror image */
                const double a = k * step, b = (k + 1) * step;
                const double triangle[9] = {
                    0, 0, h, grown * cos(a), grown * sin(a), h, grown * cos(b), grown * sin(b), h};

                seen += 2 * lcor_factor_point(x, normal, 3, triangle);
            }
            sum += w * seen;
        }
    return sum;
}

/* Point rows: an element at a corner of the foot of the rectangle. */
static int point_factor(const char *kind, const char *p, double *factor)
{
    const double x[3] = {0, 0, 0}, up[3] = {0, 0, 1}, along[3] = {0, 1, 0};
    rectangle r;
    double corners[12];

    if (strcmp(kind, "dA_to_parallel_rect_corner") == 0) {
        r = make(0, 0, parameter(p, "c"), 0, parameter(p, "a"), 1, parameter(p, "b"), 2, -1);
        corners_of(&r, corners);
        *factor = lcor_factor_point(x, up, 4, corners);
    } else if (strcmp(kind, "dA_to_perpendicular_rect_corner") == 0) {
        /* The element looks along y in the plane z = 0's edge: the rectangle stands on it. */
        r = make(0, 0, parameter(p, "c_dist"), 1, parameter(p, "a_height"), 0,
                 parameter(p, "b_width"), 2, -1);
        corners_of(&r, corners);
        *factor = lcor_factor_point(x, along, 4, corners);
    } else {
        return 0;
    }
    return 1;
}

static void every_row_of_the_reference_is_met(void **state)
{
    csv t = csv_read(LCOR_TEST_DATA "/reference/view_factors.csv");

    (void)state;
    assert_int_equal(t.rows, 42);
    for (size_t row = 0; row < t.rows; row++) {
        const char *kind = csv_text(&t, row, "kind"), *p = csv_text(&t, row, "params");
        const double known = csv_number(&t, row, "F12_double");
        double found, tolerance = 1e-6;
        rectangle a, b;

        if (point_factor(kind, p, &found))
            tolerance = 1e-12;
        else if (rectangles(kind, p, &a, &b)) /* from the smaller one, where it varies less */
            found = area(&b) < area(&a)
                        ? area_factor(&b, &a, known * area(&a) / area(&b)) * area(&b) / area(&a)
                        : area_factor(&a, &b, known);
        else if (strcmp(kind, "coaxial_disks") == 0)
            found = disc_factor(p);
        else
            found = strip_factor(kind, p);
        if (!(fabs(found - known) <= tolerance * known))
            fail_msg("%s %s: %.15g, expected %.15g (%.1e)", kind, p, found, known,
                     fabs(found / known - 1));
        assert_true(found >= 0 && found <= 1);
    }
    csv_free(&t);
}

/* Random points on the floor of a box: what its other faces cover sums to the whole hemisphere. */
static void hemispheres_of_a_closed_room_are_full(void **state)
{
    uint64_t seed = 7;

    (void)state;
    for (int i = 0; i < 200; i++) {
        const double size[3] = {0.1 + random_unit(&seed), 0.1 + random_unit(&seed),
                                0.01 + random_unit(&seed)};
        const double x[3] = {size[0] * random_unit(&seed), size[1] * random_unit(&seed), 0};
        const double up[3] = {0, 0, 1};
        const rectangle faces[5] = {make(0, 0, size[2], 0, size[0], 1, size[1], 2, -1),
                                    make(0, 0, 0, 1, size[1], 2, size[2], 0, 1),
                                    make(size[0], 0, 0, 1, size[1], 2, size[2], 0, -1),
                                    make(0, 0, 0, 0, size[0], 2, size[2], 1, 1),
                                    make(0, size[1], 0, 0, size[0], 2, size[2], 1, -1)};
        double sum = 0;

        for (int f = 0; f < 5; f++) {
            double corners[12];

            corners_of(&faces[f], corners);
            sum += lcor_factor_point(x, up, 4, corners);
        }
        check_near(sum, 1, 1e-9, "row sum");
    }
}

/* A1 F12 = A2 F21 for rectangles of different size. */
static void factors_are_reciprocal(void **state)
{
    uint64_t seed = 11;

    (void)state;
    for (int i = 0; i < 6; i++) {
        const double w = 0.2 + random_unit(&seed), h = 0.2 + random_unit(&seed);
        const rectangle a = make(0, 0, 0, 0, w, 1, h, 2, 1);
        const rectangle b = make(0.1, -0.3, 0.4 + random_unit(&seed), 0, 0.5, 1, 1.5, 2, -1);
        const double ab = area_factor(&a, &b, 0.001), ba = area_factor(&b, &a, 0.001);

        check_near(w * h * ab, 0.75 * ba, 1e-9, "reciprocity");
    }
}

/* Where a polygon dips below the horizon only what is above counts: the same as cut by hand. */
static void what_lies_below_the_horizon_is_cut_off(void **state)
{
    const double x[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    const double dips[12] = {-1, 1, -2, 1, 1, -2, 1, 1, 3, -1, 1, 3};
    const double above[12] = {-1, 1, 0, 1, 1, 0, 1, 1, 3, -1, 1, 3};
    const double below[12] = {-1, 1, -2, 1, 1, -2, 1, 1, -1, -1, 1, -1};

    (void)state;
    check_near(lcor_factor_point(x, up, 4, dips), lcor_factor_point(x, up, 4, above), 1e-15, "cut");
    check_near(lcor_factor_point(x, up, 4, below), 0, 0, "all below");
}

static void many_points_at_once_agree_with_one(void **state)
{
    const double corners[4][3] = {{0, 0, 1}, {1, 0, 1}, {1.2, 1, 1.4}, {0.2, 1, 1.4}};
    const double up[3] = {0, 0, 1};
    double x[11], y[11], z[11], factors[11], others[11];
    uint64_t seed = 3;
    size_t sets = 1;

    (void)state;
    for (int i = 0; i < 11; i++) {
        x[i] = 4 * random_unit(&seed) - 2;
        y[i] = 4 * random_unit(&seed) - 2;
        z[i] = 0;
    }
    lcor_factor_points_at(0)(11, x, y, z, up, corners, factors);
    for (; lcor_factor_points_at(sets); sets++) { /* every instruction set, bit by bit */
        lcor_factor_points_at(sets)(11, x, y, z, up, corners, others);
        assert_memory_equal(others, factors, sizeof factors);
    }
    print_message("%lu instruction sets\n", (unsigned long)sets);
    for (int i = 0; i < 11; i++) {
        const double p[3] = {x[i], y[i], z[i]};

        check_near(factors[i], lcor_factor_point(p, up, 4, corners[0]), 1e-15, "factor");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_row_of_the_reference_is_met),
        cmocka_unit_test(hemispheres_of_a_closed_room_are_full),
        cmocka_unit_test(factors_are_reciprocal),
        cmocka_unit_test(what_lies_below_the_horizon_is_cut_off),
        cmocka_unit_test(many_points_at_once_agree_with_one),
    };

    return cmocka_run_group_tests_name("view factors", tests, NULL, NULL);
}
