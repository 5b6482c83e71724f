/* SPDX-License-Identifier: MIT */
#include "command/import_table.h"

#include <stdio.h>
#include <string.h>

enum { COLUMNS_MAX = 512, NAME_MAX = 63 };

typedef struct table {
    const char *at, *end;
    long line;
    char separator;
    size_t columns;
    size_t name_column; /* 1 + place of SAMPLE_NAME; 0: none */
    bool from_names;    /* R G B are told by the names white and black */
    char *problem;
    size_t capacity;
} table;

static bool fail(table *t, const char *what)
{
    snprintf(t->problem, t->capacity, "line %ld: %s", t->line, what);
    return false;
}

bool import_is_cgats(const char *text, size_t size)
{
    static const char mark[] = "BEGIN_DATA";
    for (const char *at = text; (at = memchr(at, 'B', size - (size_t)(at - text)));) {
        const size_t left = size - (size_t)(at - text);
        if (left >= sizeof mark - 1 && memcmp(at, mark, sizeof mark - 1) == 0)
            return true;
        at++;
    }
    return false;
}

static bool at_line_end(const table *t)
{
    return t->at == t->end || *t->at == '\n' || *t->at == '\r';
}

static void next_line(table *t, buffer *out)
{
    if (t->end - t->at >= 2 && t->at[0] == '\r' && t->at[1] == '\n')
        t->at++;
    t->at++;
    t->line++;
    buffer_text(out, "\n");
}

/* Step over empty and comment lines, each an empty line of the result. False at the end. */
static bool find_row(table *t, buffer *out)
{
    while (t->at < t->end) {
        const char *p = t->at;
        while (p < t->end && (*p == ' ' || *p == '\t' || *p == ',' || *p == ';'))
            p++;
        const bool empty = p == t->end || *p == '\n' || *p == '\r' || *p == '#';
        if (!empty)
            return true;
        t->at = p;
        while (!at_line_end(t))
            t->at++;
        if (t->at < t->end)
            next_line(t, out);
    }
    return false;
}

/* The next cell of the row, without blanks and quotes around; false for a quote without its end. */
static bool next_cell(table *t, char *cell, size_t capacity)
{
    size_t n = 0;
    while (!at_line_end(t) && *t->at != t->separator && (*t->at == ' ' || *t->at == '\t'))
        t->at++;
    const bool quoted = !at_line_end(t) && *t->at == '"';
    t->at += quoted;
    for (; !at_line_end(t); t->at++) {
        if (quoted ? *t->at == '"' : *t->at == t->separator) {
            if (!quoted || t->end - t->at < 2 || t->at[1] != '"')
                break;
            t->at++; /* a doubled quote */
        }
        if (n + 1 < capacity) {
            cell[n] = *t->at;
            if (cell[n] == '"' || cell[n] == '\0') /* what CGATS words cannot hold */
                cell[n] = '\'';
            n++;
        }
    }
    if (quoted) {
        if (at_line_end(t))
            return fail(t, "a quote without its end");
        t->at++;
        while (!at_line_end(t) && *t->at != t->separator)
            t->at++;
    }
    while (!quoted && n > 0 && (cell[n - 1] == ' ' || cell[n - 1] == '\t'))
        n--;
    cell[n] = '\0';
    return true;
}

static bool same_word(const char *a, const char *b)
{
    for (; *a && *b; a++, b++)
        if ((*a >= 'a' && *a <= 'z' ? *a - 'a' + 'A' : *a) != *b)
            return false;
    return *a == *b;
}

static bool has_name(char names[][NAME_MAX + 1], size_t count, const char *name)
{
    for (size_t i = 0; i < count; i++)
        if (same_word(names[i], name))
            return true;
    return false;
}

/* What CGATS calls a column; NULL: it has no meaning here. */
static const char *column_name(const char *name, bool cmyk, bool xyz)
{
    static const struct {
        const char *written, *cgats;
    } known[] = {{"ID", "SAMPLE_ID"},      {"SAMPLE", "SAMPLE_ID"}, {"NAME", "SAMPLE_NAME"},
                 {"PATCH", "SAMPLE_NAME"}, {"R", "RGB_R"},          {"G", "RGB_G"},
                 {"B", "RGB_B"},           {"D", "D_VIS"},          {"DENSITY", "D_VIS"},
                 {"VISUAL", "D_VIS"},      {"DV", "D_VIS"},         {"V", "D_VIS"},
                 {"L*", "LAB_L"},          {"A*", "LAB_A"},         {"B*", "LAB_B"}};
    static const char *const cgats[] = {
        "SAMPLE_ID", "SAMPLE_NAME", "RGB_R", "RGB_G", "RGB_B", "CMYK_C",       "CMYK_M",
        "CMYK_Y",    "CMYK_K",      "XYZ_X", "XYZ_Y", "XYZ_Z", "D_RED",        "D_GREEN",
        "D_BLUE",    "D_VIS",       "LAB_L", "LAB_A", "LAB_B", "LCOR_REJECTED"};
    static const char *const cmyk_names[] = {"C", "M", "Y", "K"};
    static const char *const xyz_names[] = {"X", "Y", "Z"};
    for (size_t i = 0; i < sizeof cgats / sizeof cgats[0]; i++)
        if (same_word(name, cgats[i]))
            return cgats[i];
    for (size_t i = 0; cmyk && i < 4; i++)
        if (same_word(name, cmyk_names[i]))
            return cgats[5 + i];
    for (size_t i = 0; xyz && i < 3; i++)
        if (same_word(name, xyz_names[i]))
            return cgats[9 + i];
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (same_word(name, known[i].written))
            return known[i].cgats;
    return NULL;
}

static void write_format(table *t, char names[][NAME_MAX + 1], buffer *out)
{
    const bool cmyk = has_name(names, t->columns, "C") && has_name(names, t->columns, "M") &&
                      has_name(names, t->columns, "Y") && has_name(names, t->columns, "K");
    const bool xyz = !cmyk && has_name(names, t->columns, "X") &&
                     has_name(names, t->columns, "Y") && has_name(names, t->columns, "Z");
    bool device = false;
    buffer_text(out, "BEGIN_DATA_FORMAT");
    for (size_t i = 0; i < t->columns; i++) {
        const char *name = column_name(names[i], cmyk, xyz);
        buffer_text(out, " ");
        if (name && strcmp(name, "SAMPLE_NAME") == 0)
            t->name_column = i + 1;
        device =
            device || (name && (strncmp(name, "RGB_", 4) == 0 || strncmp(name, "CMYK", 4) == 0));
        buffer_text(out, name ? name : "OTHER");
    }
    t->from_names = !device && t->name_column;
    buffer_text(out, t->from_names ? " RGB_R RGB_G RGB_B END_DATA_FORMAT BEGIN_DATA"
                                   : " END_DATA_FORMAT BEGIN_DATA");
}

/* Spreadsheets may name the separator in a line of its own before the table: sep=; */
static void take_separator(table *t, buffer *out)
{
    if (t->end - t->at < 6 || memcmp(t->at, "sep=", 4) != 0 ||
        (t->at[5] != '\n' && t->at[5] != '\r'))
        return;
    t->at += 5;
    next_line(t, out);
}

static bool read_names(table *t, buffer *out)
{
    char names[COLUMNS_MAX][NAME_MAX + 1];
    const char *p = t->at;
    size_t tabs = 0, semicolons = 0, commas = 0;
    for (; p < t->end && *p != '\n' && *p != '\r'; p++) {
        tabs += *p == '\t';
        semicolons += *p == ';';
        commas += *p == ',';
    }
    t->separator = ',';
    if (semicolons > 0)
        t->separator = ';';
    if (tabs > 0)
        t->separator = '\t';
    if (tabs + semicolons + commas == 0)
        return fail(t, "neither CGATS text nor a table: names separated by commas were expected");
    while (t->columns < COLUMNS_MAX) {
        if (!next_cell(t, names[t->columns++], NAME_MAX + 1))
            return false;
        if (at_line_end(t)) {
            write_format(t, names, out);
            return true;
        }
        t->at++; /* the separator */
    }
    return fail(t, "more than 512 columns");
}

/* R G B of a row that is told by its name. */
static bool write_level(table *t, const char *name, buffer *out)
{
    if (same_word(name, "WHITE") || same_word(name, "PAPER"))
        buffer_text(out, " 255 255 255");
    else if (same_word(name, "BLACK"))
        buffer_text(out, " 0 0 0");
    else
        return fail(t, "a patch that is neither white nor black by name: give columns R, G and B");
    return true;
}

static bool read_row(table *t, buffer *out)
{
    char cell[256], name[256] = "";
    size_t count = 0;
    for (bool more = true; more; t->at += more) {
        if (!next_cell(t, cell, sizeof cell))
            return false;
        more = !at_line_end(t);
        if (++count > t->columns)
            return fail(t,
                        "more cells than the first line has names (numbers need a decimal point, "
                        "not a comma)");
        if (count == t->name_column)
            memcpy(name, cell, sizeof name);
        buffer_text(out, " \"");
        buffer_text(out, cell);
        buffer_text(out, "\"");
    }
    if (count < t->columns)
        return fail(t, "fewer cells than the first line has names");
    return !t->from_names || write_level(t, name, out);
}

bool import_table(const char *text, size_t size, buffer *cgats, char *problem, size_t capacity)
{
    table t = {.at = text, .end = text + size, .line = 1, .problem = problem, .capacity = capacity};
    problem[0] = '\0';
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0)
        t.at += 3;
    if (size >= 2 && (memcmp(text, "\xFF\xFE", 2) == 0 || memcmp(text, "\xFE\xFF", 2) == 0))
        return fail(&t, "the text is UTF-16; save it as UTF-8 or ASCII");
    take_separator(&t, cgats);
    if (!find_row(&t, cgats))
        return fail(&t, "the file is empty");
    if (!read_names(&t, cgats))
        return false;
    while (find_row(&t, cgats))
        if (!at_line_end(&t) && !read_row(&t, cgats))
            return false;
    buffer_text(cgats, "\nEND_DATA\n");
    return !cgats->failed || fail(&t, "out of memory");
}
