/* SPDX-License-Identifier: MIT */
#include "profile/cgats.h"

#include <string.h>

cgats_text lcor_internal_cgats_open(const char *text, size_t size)
{
    cgats_text t = {.at = text, .end = text + size, .line = 1};
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0)
        t.at += 3;
    return t;
}

static int is_line_end(char c) { return c == '\n' || c == '\r'; }
static int is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == 0x1A; /* DOS's end of file */
}

cgats_next lcor_internal_cgats_next(cgats_text *t, cgats_word *word)
{
    while (t->at < t->end && is_blank(*t->at))
        t->at++;
    if (t->at < t->end && *t->at == '#')
        while (t->at < t->end && !is_line_end(*t->at))
            t->at++;
    if (t->at == t->end)
        return CGATS_END;
    if (is_line_end(*t->at)) {
        if (*t->at == '\r' && t->at + 1 < t->end && t->at[1] == '\n')
            t->at++;
        t->at++;
        t->line++;
        return CGATS_LINE_END;
    }
    word->quoted = *t->at == '"';
    if (word->quoted) {
        word->text = ++t->at;
        for (; t->at < t->end && !is_line_end(*t->at) && *t->at != '\0'; t->at++) {
            if (*t->at != '"')
                continue;
            if (t->at + 1 < t->end && t->at[1] == '"') { /* a quote inside is doubled */
                t->at++;
                continue;
            }
            word->n = (size_t)(t->at++ - word->text);
            return CGATS_WORD;
        }
        return CGATS_BAD;
    }
    word->text = t->at;
    while (t->at < t->end && !is_blank(*t->at) && !is_line_end(*t->at)) {
        if (*t->at == '\0')
            return CGATS_BAD;
        t->at++;
    }
    word->n = (size_t)(t->at - word->text);
    return CGATS_WORD;
}

cgats_word lcor_internal_cgats_rest(cgats_text *t)
{
    while (t->at < t->end && is_blank(*t->at))
        t->at++;
    cgats_word rest = {.text = t->at};
    while (t->at < t->end && !is_line_end(*t->at) && !(*t->at == '#' && is_blank(t->at[-1])))
        t->at++;
    rest.n = (size_t)(t->at - rest.text);
    while (rest.n > 0 && is_blank(rest.text[rest.n - 1]))
        rest.n--;
    return rest;
}

int lcor_internal_cgats_is(cgats_word word, const char *name)
{
    if (word.quoted || word.n != strlen(name))
        return 0;
    for (size_t i = 0; i < word.n; i++) {
        const char c = word.text[i];
        if ((c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c) != name[i])
            return 0;
    }
    return 1;
}
