/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "session/prompt.h"
#include "lccal.h"
#include "transport/interrupt.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <unistd.h>

/* One byte of stdin, or -1 for its end and -2 for a signal. Unbuffered: what comes after the line
 * belongs to the next prompt. */
static int next_byte(void)
{
    struct pollfd fds[2] = {{.fd = STDIN_FILENO, .events = POLLIN},
                            {.fd = interrupt_fd(), .events = POLLIN}};
    for (;;) {
        if (interrupt_pending())
            return -2;
        if (poll(fds, 2, -1) < 0 && errno != EINTR)
            return -1;
        if (!fds[0].revents || interrupt_pending())
            continue;
        unsigned char byte;
        const ssize_t n = read(STDIN_FILENO, &byte, 1);
        if (n < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        return n == 1 ? byte : -1;
    }
}

answer prompt_line(const char *patch, const char *question, char *line, size_t capacity)
{
    fprintf(stderr, "%s ", question);
    fflush(stderr);
    json event = lccal_event("prompt");
    json_text(&event, "patch", patch);
    json_text(&event, "text", question);
    lccal_event_end(&event);
    size_t n = 0;
    for (int byte = next_byte(); byte != '\n'; byte = next_byte()) {
        if (byte < 0) {
            fputc('\n', stderr); /* what is said next starts its own line */
            return byte == -1 ? ANSWER_CLOSED : ANSWER_QUIT;
        }
        if (n + 1 < capacity)
            line[n++] = (char)byte;
    }
    line[n] = '\0';
    return ANSWER_GO;
}

answer prompt_wait(const char *patch, const char *question)
{
    char line[8];
    const answer heard = prompt_line(patch, question, line, sizeof line);
    if (heard != ANSWER_GO)
        return heard;
    if (line[0] == 'q' || line[0] == 'Q')
        return ANSWER_QUIT;
    return line[0] == 'r' || line[0] == 'R' ? ANSWER_REDO : ANSWER_GO;
}
