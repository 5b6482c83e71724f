/* SPDX-License-Identifier: MIT */
/* Replays a recorded dialogue, in umockdev's script format:
 *
 *     d 0 /dev/ttyACM0      the device (ignored)
 *     w 3 GS V^M^J          the program writes this
 *     r 12 GS V,"..."^M^J   12 ms later the device answers this
 *     h 500                 500 ms later it hangs up (not in umockdev)
 *     # a comment
 *
 * ^@ to ^_ are the bytes 0 to 31 and ^` is the character ^; all other bytes stand for themselves.
 * Time is the script's own, so a replay of minutes takes no time. */
#include "number.h"
#include "transport/transport.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum step_kind { STEP_WRITE, STEP_READ, STEP_HANG_UP } step_kind;

typedef struct step {
    step_kind kind;
    int delay_ms;
    size_t size;
    unsigned char *bytes; /* inside script.bytes */
} step;

typedef struct script {
    transport base;
    step *steps;
    size_t count, next;
    size_t done; /* bytes of the next step already said or heard */
    int64_t now;
    int64_t ready; /* when the next answer starts its delay */
    unsigned char *bytes;
} script;

static int64_t script_now(transport *t) { return ((script *)t)->now; }

static void finish_step(script *s)
{
    s->next++;
    s->done = 0;
    s->ready = s->now;
}

static cal_status script_read(transport *t, void *bytes, size_t capacity, size_t *got,
                              int timeout_ms)
{
    script *s = (script *)t;
    const int64_t deadline = s->now + timeout_ms;
    *got = 0;
    const step *now = s->next < s->count ? &s->steps[s->next] : NULL;
    if (!now || now->kind == STEP_WRITE) {
        s->now = deadline; /* the device waits for the program, or has nothing more to say */
        return CAL_TIMEOUT;
    }
    const int64_t due = s->ready + now->delay_ms;
    if (due > deadline) {
        s->now = deadline;
        return CAL_TIMEOUT;
    }
    if (due > s->now)
        s->now = due;
    if (now->kind == STEP_HANG_UP)
        return CAL_GONE;
    const size_t left = now->size - s->done;
    const size_t n = left < capacity ? left : capacity;
    memcpy(bytes, now->bytes + s->done, n);
    s->done += n;
    *got = n;
    if (s->done == now->size)
        finish_step(s);
    return CAL_OK;
}

/* Answers that were not read yet do not keep the program from writing: the device said them, they
 * are lost. What is written must be what was recorded, in as many pieces as the program likes. */
static cal_status script_write(transport *t, const void *bytes, size_t n, int timeout_ms)
{
    script *s = (script *)t;
    const char *from = bytes;
    (void)timeout_ms;
    while (s->next < s->count && s->steps[s->next].kind == STEP_READ)
        finish_step(s);
    while (n > 0) {
        if (s->next >= s->count)
            return CAL_OK; /* nobody listens any more */
        const step *now = &s->steps[s->next];
        if (now->kind == STEP_HANG_UP)
            return CAL_GONE;
        const size_t left = now->size - s->done;
        const size_t part = n < left ? n : left;
        if (now->kind != STEP_WRITE || memcmp(now->bytes + s->done, from, part) != 0)
            return CAL_PROTOCOL;
        s->done += part;
        from += part;
        n -= part;
        if (s->done == now->size)
            finish_step(s);
    }
    return CAL_OK;
}

static cal_status script_configure(transport *t, const line_settings *line)
{
    (void)t;
    (void)line;
    return CAL_OK;
}

static void script_close(transport *t)
{
    script *s = (script *)t;
    free(s->steps);
    free(s->bytes);
    free(s);
}

static const transport_ops script_ops = {
    .scheme = "script",
    .configure = script_configure,
    .write = script_write,
    .read = script_read,
    .now_ms = script_now,
    .close = script_close,
};

/* Undo the ^ notation in place; returns the new size, or SIZE_MAX for a wrong escape. */
static size_t decode(unsigned char *text, size_t n)
{
    size_t out = 0;
    for (size_t i = 0; i < n; i++) {
        if (text[i] != '^') {
            text[out++] = text[i];
            continue;
        }
        if (++i >= n || text[i] < '@' || text[i] > '`')
            return SIZE_MAX;
        text[out++] = text[i] == '`' ? (unsigned char)'^' : (unsigned char)(text[i] - '@');
    }
    return out;
}

/* One line of n bytes into *out. False: it is no step. */
static bool parse_step(unsigned char *line, size_t n, step *out)
{
    static const char letters[] = "wrh";
    const char *letter = n >= 2 && line[1] == ' ' ? strchr(letters, line[0]) : NULL;
    if (!letter || line[0] == '\0')
        return false;
    size_t end = 2;
    while (end < n && line[end] != ' ')
        end++;
    double delay;
    if (!lccal_parse_number((const char *)line + 2, end - 2, &delay) || delay < 0.0 || delay > 1e8)
        return false;
    out->kind = (step_kind)(letter - letters);
    out->delay_ms = (int)delay;
    out->bytes = line + (end < n ? end + 1 : n);
    out->size = decode(out->bytes, (size_t)(line + n - out->bytes));
    return out->size != SIZE_MAX && (out->size > 0 || out->kind == STEP_HANG_UP);
}

cal_status script_open_text(const char *text, size_t size, transport **out, cal_error *err)
{
    cal_status status = CAL_NO_MEMORY;
    size_t lines = 1, number = 0;
    for (size_t i = 0; i < size; i++)
        lines += text[i] == '\n';
    script *s = calloc(1, sizeof *s);
    if (!s)
        return cal_fail(err, status, "out of memory");
    s->base.ops = &script_ops;
    s->steps = calloc(lines, sizeof *s->steps);
    s->bytes = malloc(size + 1);
    if (!s->steps || !s->bytes) {
        cal_fail(err, status, "out of memory");
        goto failed;
    }
    memcpy(s->bytes, text, size);
    for (size_t start = 0; start < size;) {
        size_t end = start;
        while (end < size && s->bytes[end] != '\n')
            end++;
        unsigned char *line = s->bytes + start;
        const size_t n = end - start;
        start = end + 1;
        number++;
        if (n == 0 || line[0] == '#' || (line[0] == 'd' && n > 1 && line[1] == ' '))
            continue;
        if (!parse_step(line, n, &s->steps[s->count])) {
            status = cal_fail(err, CAL_NO_DEVICE,
                              "line %zu of the script is not 'w', 'r' or 'h', a delay and bytes",
                              number);
            goto failed;
        }
        s->count++;
    }
    *out = &s->base;
    return CAL_OK;
failed:
    script_close(&s->base);
    return status;
}

cal_status script_open(const char *path, transport **out, cal_error *err)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return cal_fail(err, CAL_NO_DEVICE, "cannot read the script '%s'", path);
    enum { LIMIT = 4 << 20 };
    char *text = malloc(LIMIT);
    const size_t size = text ? fread(text, 1, LIMIT, file) : 0;
    fclose(file);
    const cal_status status =
        text && size < LIMIT ? script_open_text(text, size, out, err)
                             : cal_fail(err, CAL_NO_DEVICE, "the script '%s' is too large", path);
    free(text);
    if (status == CAL_OK)
        snprintf((*out)->name, sizeof(*out)->name, "script:%s", path);
    return status;
}
