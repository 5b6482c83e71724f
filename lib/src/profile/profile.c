/* SPDX-License-Identifier: MIT */
#include "profile/internal.h"

#include "base/internal.h"
#include "profile/number.h"

#include <math.h>
#include <string.h>

/* Names and values are only ever added: blocks of bytes, freed together. */
typedef struct profile_block {
    struct profile_block *next;
    size_t used, size;
    char bytes[];
} profile_block;

#define BLOCK_SIZE 4000

static char *text_room(lcor_profile *profile, size_t n)
{
    profile_block *block = profile->text;
    if (!block || block->size - block->used < n) {
        const size_t size = n > BLOCK_SIZE ? n : BLOCK_SIZE;
        size_t bytes;
        if (!lcor_internal_size_add(sizeof *block, size, &bytes))
            return NULL;
        block = lcor_internal_alloc(&profile->allocator, bytes);
        if (!block)
            return NULL;
        *block = (profile_block){.next = profile->text, .size = size};
        profile->text = block;
    }
    char *room = block->bytes + block->used;
    block->used += n;
    return room;
}

/* Length of the UTF-8 sequence at text (2..4), or 0 if it is none. */
static size_t utf8_length(const unsigned char *text, size_t n)
{
    const unsigned char c = text[0];
    const size_t length = c >= 0xC2 && c <= 0xDF   ? 2
                          : (c & 0xF0) == 0xE0     ? 3
                          : c >= 0xF0 && c <= 0xF4 ? 4
                                                   : 0;
    if (length == 0 || length > n)
        return 0;
    for (size_t i = 1; i < length; i++)
        if ((text[i] & 0xC0) != 0x80)
            return 0;
    /* Overlong forms, surrogates and what lies beyond U+10FFFF show in the second byte. */
    if ((c == 0xE0 && text[1] < 0xA0) || (c == 0xED && text[1] > 0x9F) ||
        (c == 0xF0 && text[1] < 0x90) || (c == 0xF4 && text[1] > 0x8F))
        return 0;
    return length;
}

const char *lcor_internal_profile_text(lcor_profile *profile, const char *text, size_t n)
{
    const unsigned char *in = (const unsigned char *)text;
    size_t room = 1;
    for (size_t i = 0; i < n; i++)
        room += in[i] < 0x80 ? 1 : 2; /* a Latin-1 byte becomes two */
    char *const copy = text_room(profile, room);
    if (!copy)
        return NULL;
    char *out = copy;
    for (size_t i = 0; i < n;) {
        const size_t sequence = in[i] < 0x80 ? 1 : utf8_length(in + i, n - i);
        if (in[i] == '"') {
            *out++ = '\'';
            i += i + 1 < n && in[i + 1] == '"' ? 2 : 1;
        } else if (in[i] < 0x20 || in[i] == 0x7F) {
            *out++ = ' ';
            i++;
        } else if (sequence > 0) {
            memcpy(out, in + i, sequence);
            out += sequence;
            i += sequence;
        } else {
            *out++ = (char)(0xC0 | (in[i] >> 6));
            *out++ = (char)(0x80 | (in[i] & 0x3F));
            i++;
        }
    }
    *out = '\0';
    return copy;
}

lcor_status lcor_profile_new(const lcor_allocator *allocator, lcor_profile **out, lcor_error *err)
{
    if (!out)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "no place for the profile (out is NULL)");
    lcor_allocator chosen;
    const lcor_status status = lcor_internal_allocator(allocator, &chosen, err);
    if (status != LCOR_OK)
        return status;
    lcor_profile *profile = lcor_internal_alloc(&chosen, sizeof *profile);
    if (!profile)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for a profile");
    *profile = (lcor_profile){.allocator = chosen};
    *out = profile;
    return LCOR_OK;
}

void lcor_profile_free(lcor_profile *profile)
{
    if (!profile)
        return;
    const lcor_allocator allocator = profile->allocator;
    for (profile_block *block = profile->text, *next; block; block = next) {
        next = block->next;
        lcor_internal_free(&allocator, block);
    }
    lcor_internal_free(&allocator, profile->readings);
    lcor_internal_free(&allocator, profile->keywords);
    lcor_internal_free(&allocator, profile);
}

/* Room for one more of `count` items of `size` bytes; 0 when memory is short. */
static int grow(const lcor_allocator *allocator, void **items, size_t count, size_t *capacity,
                size_t size)
{
    if (count < *capacity)
        return 1;
    size_t wanted, bytes;
    if (!lcor_internal_size_mul(count ? count : 8, 2, &wanted) ||
        !lcor_internal_size_mul(wanted, size, &bytes))
        return 0;
    void *larger = lcor_internal_alloc(allocator, bytes);
    if (!larger)
        return 0;
    if (count > 0)
        memcpy(larger, *items, count * size);
    lcor_internal_free(allocator, *items);
    *items = larger;
    *capacity = wanted;
    return 1;
}

/* ---- readings ---- */

static int inside(const double *values, int n, double low, double high)
{
    for (int i = 0; i < n; i++)
        if (!(values[i] >= low && values[i] <= high))
            return 0;
    return 1;
}

static lcor_status check_reading(const lcor_profile *profile, const lcor_profile_reading *r,
                                 lcor_error *err)
{
    const unsigned all =
        LCOR_HAS_RGB | LCOR_HAS_CMYK | LCOR_HAS_VISUAL | LCOR_HAS_COLOUR_DENSITY | LCOR_HAS_XYZ;
    const long where = (long)profile->count;
    if ((r->has & ~all) || !(r->has & (LCOR_HAS_VISUAL | LCOR_HAS_XYZ)))
        return lcor_internal_fail(err, LCOR_ERR_ARG, where,
                                  "a reading needs a visual density or XYZ");
    if (profile->count > 0 && profile->readings[0].has != r->has)
        return lcor_internal_fail(err, LCOR_ERR_ARG, where,
                                  "all readings of one profile must hold the same fields");
    if ((r->has & LCOR_HAS_RGB) && !inside(r->rgb, 3, 0.0, 255.0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where, "RGB must be 0 to 255");
    if ((r->has & LCOR_HAS_CMYK) && !inside(r->cmyk, 4, 0.0, 100.0))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where, "CMYK must be 0 to 100 percent");
    if (((r->has & LCOR_HAS_VISUAL) && !inside(r->density + 3, 1, -1.0, 8.0)) ||
        ((r->has & LCOR_HAS_COLOUR_DENSITY) && !inside(r->density, 3, -1.0, 8.0)))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where, "a density must be -1 to 8");
    if ((r->has & LCOR_HAS_XYZ) &&
        (!inside(r->xyz, 3, -1e9, 1e9) || !inside(r->xyz + 1, 1, 1e-9, 1e9)))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, where, "Y must be greater than 0");
    return LCOR_OK;
}

static int printable(const char *text)
{
    for (const unsigned char *p = (const unsigned char *)text; *p; p++)
        if (*p < 0x20 || *p == 0x7F || *p == '"')
            return 0;
    return 1;
}

/* A profile in memory holds what its text will hold, so that both give the same results. */
static void round_all(double *values, int n)
{
    for (int i = 0; i < n; i++)
        values[i] = lcor_internal_number_round(values[i]);
}

lcor_status lcor_internal_profile_add(lcor_profile *profile, const lcor_profile_reading *reading,
                                      const char *id, size_t id_n, const char *name, size_t name_n,
                                      lcor_error *err)
{
    const lcor_status status = check_reading(profile, reading, err);
    if (status != LCOR_OK)
        return status;
    char number[LCOR_NUMBER_SIZE];
    if (id_n == 0) {
        id_n =
            lcor_internal_number_format((double)(profile->count + 1), LCOR_NUMBER_DIGITS, number);
        id = number;
    }
    void *items = profile->readings;
    const int grown = grow(&profile->allocator, &items, profile->count, &profile->capacity,
                           sizeof *profile->readings);
    profile->readings = items;
    lcor_profile_reading copy = *reading;
    copy.rejected = reading->rejected != 0;
    round_all(copy.rgb, 3);
    round_all(copy.cmyk, 4);
    round_all(copy.density, 4);
    round_all(copy.xyz, 3);
    copy.id = grown ? lcor_internal_profile_text(profile, id, id_n) : NULL;
    copy.name = copy.id ? lcor_internal_profile_text(profile, name, name_n) : NULL;
    if (!copy.name)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for readings");
    profile->readings[profile->count++] = copy;
    return LCOR_OK;
}

lcor_status lcor_profile_reading_add(lcor_profile *profile, const lcor_profile_reading *reading,
                                     lcor_error *err)
{
    if (!profile || !reading)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "profile or reading is NULL");
    const char *id = reading->id ? reading->id : "";
    const char *name = reading->name ? reading->name : "";
    if (!printable(id) || !printable(name))
        return lcor_internal_fail(
            err, LCOR_ERR_ARG, (long)profile->count,
            "the id or name of a reading holds a quote or a control character");
    return lcor_internal_profile_add(profile, reading, id, strlen(id), name, strlen(name), err);
}

size_t lcor_profile_count(const lcor_profile *profile) { return profile ? profile->count : 0; }

lcor_status lcor_profile_reading_get(const lcor_profile *profile, size_t index,
                                     lcor_profile_reading *out, lcor_error *err)
{
    if (!profile || !out || index >= profile->count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "no such reading");
    *out = profile->readings[index];
    return LCOR_OK;
}

lcor_status lcor_profile_reading_reject(lcor_profile *profile, size_t index, int rejected,
                                        lcor_error *err)
{
    if (!profile || index >= profile->count)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "no such reading");
    profile->readings[index].rejected = rejected != 0;
    return LCOR_OK;
}

/* ---- keywords ---- */

static profile_keyword *find_keyword(const lcor_profile *profile, const char *name, size_t n)
{
    for (size_t i = 0; i < profile->keyword_count; i++)
        if (strncmp(profile->keywords[i].name, name, n) == 0 && !profile->keywords[i].name[n])
            return &profile->keywords[i];
    return NULL;
}

int lcor_internal_keyword_name_ok(const char *name, size_t n)
{
    static const char *const structure[] = {"KEYWORD",        "NUMBER_OF_FIELDS",  "NUMBER_OF_SETS",
                                            "BEGIN_DATA",     "BEGIN_DATA_FORMAT", "END_DATA",
                                            "END_DATA_FORMAT"};
    for (size_t i = 0; i < n; i++)
        if (!((name[i] >= 'A' && name[i] <= 'Z') || (name[i] >= '0' && name[i] <= '9' && i > 0) ||
              (name[i] == '_' && i > 0)))
            return 0;
    for (size_t i = 0; i < sizeof structure / sizeof structure[0]; i++)
        if (n == strlen(structure[i]) && memcmp(name, structure[i], n) == 0)
            return 0;
    return n > 0 && n < 64 && !(n >= 5 && memcmp(name, "LCOR_", 5) == 0);
}

lcor_status lcor_internal_profile_keep(lcor_profile *profile, const char *name, size_t name_n,
                                       const char *value, size_t value_n, lcor_error *err)
{
    profile_keyword *found = find_keyword(profile, name, name_n);
    const char *copy = lcor_internal_profile_text(profile, value, value_n);
    if (copy && found) {
        found->value = copy;
        return LCOR_OK;
    }
    const char *key = lcor_internal_profile_text(profile, name, name_n);
    void *items = profile->keywords;
    const int grown = grow(&profile->allocator, &items, profile->keyword_count,
                           &profile->keyword_capacity, sizeof *profile->keywords);
    profile->keywords = items;
    if (!copy || !key || !grown)
        return lcor_internal_fail(err, LCOR_ERR_NOMEM, -1, "no memory for keywords");
    profile->keywords[profile->keyword_count++] = (profile_keyword){.name = key, .value = copy};
    return LCOR_OK;
}

lcor_status lcor_profile_keyword_set(lcor_profile *profile, const char *name, const char *value,
                                     lcor_error *err)
{
    if (!profile || !name || !lcor_internal_keyword_name_ok(name, strlen(name)) ||
        (value && !printable(value)))
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1,
                                  "a keyword is capitals, digits and _, not LCOR_...; its value "
                                  "one line without quotes");
    profile_keyword *found = find_keyword(profile, name, strlen(name));
    if (!value) {
        if (found) {
            const profile_keyword *const end = profile->keywords + profile->keyword_count--;
            memmove(found, found + 1, (size_t)(end - found - 1) * sizeof *found);
        }
        return LCOR_OK;
    }
    if (!found && profile->keyword_count == LCOR_PROFILE_MAX_KEYWORDS)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "more than %d keywords",
                                  LCOR_PROFILE_MAX_KEYWORDS);
    return lcor_internal_profile_keep(profile, name, strlen(name), value, strlen(value), err);
}

const char *lcor_profile_keyword(const lcor_profile *profile, const char *name)
{
    const profile_keyword *found =
        profile && name ? find_keyword(profile, name, strlen(name)) : NULL;
    return found ? found->value : NULL;
}

size_t lcor_profile_keyword_count(const lcor_profile *profile)
{
    return profile ? profile->keyword_count : 0;
}

const char *lcor_profile_keyword_name(const lcor_profile *profile, size_t index)
{
    return profile && index < profile->keyword_count ? profile->keywords[index].name : NULL;
}

/* ---- what derived values depend on ---- */

lcor_status lcor_profile_resolution_set(lcor_profile *profile, double step, lcor_error *err)
{
    if (!profile)
        return lcor_internal_fail(err, LCOR_ERR_ARG, -1, "profile is NULL");
    if (!(step >= 0.0 && step <= 1e6))
        return lcor_internal_fail(err, LCOR_ERR_DOMAIN, -1, "a resolution must be 0 or more");
    profile->resolution = lcor_internal_number_round(step);
    return LCOR_OK;
}

double lcor_profile_resolution(const lcor_profile *profile)
{
    return profile ? profile->resolution : 0.0;
}

lcor_profile_black lcor_profile_black_get(const lcor_profile *profile)
{
    return profile ? profile->black : LCOR_BLACK_FULL;
}
