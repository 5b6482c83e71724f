/* SPDX-License-Identifier: MIT */
#include "memo.h"

/* A row where more than a third of the pixels are new is slower for the looking. The enlarged
 * pixels of a photograph give one such row and then its repeats; after two in succession the next
 * ones are corrected plainly. */
#define NEW_WORTH  3
#define PLAIN_ROWS 30

static uint32_t load(const unsigned char *rgb)
{
    return (uint32_t)rgb[0] | (uint32_t)rgb[1] << 8 | (uint32_t)rgb[2] << 16;
}

static void store(unsigned char *rgb, uint32_t colour)
{
    rgb[0] = (unsigned char)colour;
    rgb[1] = (unsigned char)(colour >> 8);
    rgb[2] = (unsigned char)(colour >> 16);
}

/* The one entry that may hold this colour; multiplicative hashing parts neighbouring colours. */
static uint64_t *entry_of(memo *m, uint32_t colour)
{
    return &m->entries[(colour * 2654435761u) >> (32 - MEMO_BITS)];
}

static void settle(memo *m, const lcor_plan *plan, size_t count, unsigned char *row,
                   const float *light)
{
    unsigned char corrected[sizeof m->pending];
    lcor_correct_row(plan, 0, count, m->pending, light, NULL, corrected, NULL);
    for (size_t i = 0; i < count; i++) {
        const uint32_t colour = load(m->pending + 3 * i), after = load(corrected + 3 * i);
        *entry_of(m, colour) = (uint64_t)(colour + 1) << 32 | after;
        store(row + 3 * m->at[i], after);
    }
}

void memo_correct_row(memo *m, const lcor_plan *plan, size_t width, unsigned char *row,
                      const float *light)
{
    size_t count = 0, missed = 0;
    if (m->plain_rows > 0) {
        m->plain_rows--;
        lcor_correct_row(plan, 0, width, row, light, NULL, row, NULL);
        return;
    }
    for (size_t x = 0; x < width; x++) {
        const uint32_t colour = load(row + 3 * x);
        const uint64_t entry = *entry_of(m, colour);
        if (entry >> 32 == colour + 1) {
            store(row + 3 * x, (uint32_t)entry);
            continue;
        }
        store(m->pending + 3 * count, colour);
        m->at[count++] = x;
        missed++;
        if (count == MEMO_PENDING) {
            settle(m, plan, count, row, light);
            count = 0;
        }
    }
    if (count > 0)
        settle(m, plan, count, row, light);
    m->poor_rows = missed > width / NEW_WORTH ? m->poor_rows + 1 : 0;
    if (m->poor_rows == 2) {
        m->poor_rows = 0;
        m->plain_rows = PLAIN_ROWS;
    }
}
