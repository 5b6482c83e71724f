/* SPDX-License-Identifier: MIT */
#include "command/target.h"

#include <string.h>

#define POINTS_PER_MM (72.0 / 25.4)

enum { OBJECTS = 5 };

typedef struct pdf {
    buffer *out;
    size_t offsets[OBJECTS + 1];
    int count;
} pdf;

static void number(buffer *out, double value)
{
    buffer_number(out, value, 5);
    buffer_text(out, " ");
}

static void begin_object(pdf *p)
{
    p->offsets[++p->count] = p->out->size;
    number(p->out, p->count);
    buffer_text(p->out, "0 obj\n");
}

static void object(pdf *p, const char *text)
{
    begin_object(p);
    buffer_text(p->out, text);
    buffer_text(p->out, "\nendobj\n");
}

static void put_rectangle(buffer *out, const target *t, const rectangle *r)
{
    for (int channel = 0; channel < 3; channel++)
        number(out, r->level / 255.0);
    buffer_text(out, "rg ");
    number(out, r->x * POINTS_PER_MM);
    number(out, (t->height - r->y - r->height) * POINTS_PER_MM);
    number(out, r->width * POINTS_PER_MM);
    number(out, r->height * POINTS_PER_MM);
    buffer_text(out, "re f\n");
}

static void put_text(buffer *out)
{
    buffer_text(out, "0 0 0 rg BT /F1 9 Tf 11 TL 42.5 62 Td\n");
    for (size_t i = 0; target_instructions[i]; i++) {
        buffer_text(out, "(");
        buffer_text(out, target_instructions[i]);
        buffer_text(out, ") Tj T*\n");
    }
    buffer_text(out, "ET\n");
}

static void put_page(pdf *p, const target *t)
{
    begin_object(p);
    buffer_text(p->out, "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 ");
    number(p->out, t->width * POINTS_PER_MM);
    number(p->out, t->height * POINTS_PER_MM);
    buffer_text(p->out, "] /Contents 5 0 R /Resources << /Font << /F1 4 0 R >> >> >>\nendobj\n");
}

static void put_contents(pdf *p, const target *t)
{
    buffer content = {0};
    for (size_t i = 0; i < t->count; i++)
        put_rectangle(&content, t, &t->rectangles[i]);
    put_text(&content);
    begin_object(p);
    buffer_text(p->out, "<< /Length ");
    number(p->out, (double)content.size);
    buffer_text(p->out, ">>\nstream\n");
    buffer_bytes(p->out, content.bytes, content.size);
    buffer_text(p->out, "endstream\nendobj\n");
    p->out->failed = p->out->failed || content.failed;
    buffer_free(&content);
}

/* The table of objects, entries of exactly 20 bytes. */
static void put_table(pdf *p)
{
    const size_t at = p->out->size;
    buffer_text(p->out, "xref\n0 6\n0000000000 65535 f \n");
    for (int i = 1; i <= OBJECTS; i++) {
        char entry[] = "0000000000 00000 n \n";
        size_t left = p->offsets[i];
        for (int place = 9; place >= 0; place--, left /= 10)
            entry[place] = (char)('0' + left % 10);
        buffer_text(p->out, entry);
    }
    buffer_text(p->out, "trailer\n<< /Size 6 /Root 1 0 R >>\nstartxref\n");
    number(p->out, (double)at);
    buffer_text(p->out, "\n%%EOF\n");
}

void target_pdf(const target *t, buffer *out)
{
    pdf p = {.out = out};
    buffer_text(out, "%PDF-1.4\n");
    object(&p, "<< /Type /Catalog /Pages 2 0 R >>");
    object(&p, "<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
    put_page(&p, t);
    object(&p, "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
    put_contents(&p, t);
    put_table(&p);
}
