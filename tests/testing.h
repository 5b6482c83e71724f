/* SPDX-License-Identifier: MIT */
/* What the C tests share: cmocka with what it needs first, random numbers, and CSV files of
 * tests/data. */
#ifndef LCOR_TESTING_H
#define LCOR_TESTING_H

/* cmocka.h needs the others first */
/* clang-format off */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
/* clang-format on */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* xorshift64*: the same numbers on every machine */
static inline uint64_t random_bits(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * UINT64_C(2685821657736338717);
}

/* 0 <= x < 1 */
static inline double random_unit(uint64_t *state)
{
    return (double)(random_bits(state) >> 11) * (1.0 / 9007199254740992.0);
}

/* Fails the test with both numbers unless |a - b| <= tolerance; equal infinities are near. */
static inline void check_near(double a, double b, double tolerance, const char *what)
{
    if (!(a == b || fabs(a - b) <= tolerance))
        fail_msg("%s: %.17g, expected %.17g within %g", what, a, b, tolerance);
}

/* A CSV file without quotes: a line of names, then rows. */
typedef struct csv {
    size_t rows, columns;
    char **cells; /* names first */
    char *text;
} csv;

static inline csv csv_read(const char *path)
{
    csv t = {0, 0, NULL, NULL};
    FILE *f = fopen(path, "rb");
    long size;
    size_t count = 0, n = 0;

    if (f == NULL)
        fail_msg("cannot open %s", path);
    assert_int_equal(fseek(f, 0, SEEK_END), 0);
    size = ftell(f);
    rewind(f);
    t.text = calloc((size_t)size + 1, 1);
    assert_non_null(t.text);
    assert_int_equal(fread(t.text, 1, (size_t)size, f), (size_t)size);
    fclose(f);
    for (char *p = t.text; *p != '\0'; p++)
        count += *p == ',' || *p == '\n';
    t.cells = calloc(count + 1, sizeof *t.cells);
    assert_non_null(t.cells);
    for (char *p = t.text; *p != '\0';) {
        const size_t length = strcspn(p, ",\n");
        const char end = p[length];

        t.cells[n++] = p;
        p[length] = '\0';
        if (t.columns == 0 && end == '\n')
            t.columns = n;
        p += length + (end != '\0');
    }
    t.rows = n / t.columns - 1;
    assert_int_equal((t.rows + 1) * t.columns, n);
    return t;
}

static inline void csv_free(csv *t)
{
    free(t->cells);
    free(t->text);
}

static inline const char *csv_text(const csv *t, size_t row, const char *column)
{
    for (size_t i = 0; i < t->columns; i++)
        if (strcmp(t->cells[i], column) == 0)
            return t->cells[(row + 1) * t->columns + i];
    fail_msg("no column %s", column);
    return "";
}

static inline double csv_number(const csv *t, size_t row, const char *column)
{
    return strtod(csv_text(t, row, column), NULL);
}

#endif
