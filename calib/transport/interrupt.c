/* SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include "transport/interrupt.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

/* A signal handler has nothing but globals to speak through. */
static volatile sig_atomic_t pending;
static int pipe_ends[2] = {-1, -1};

static void on_signal(int number)
{
    (void)number;
    const int error = errno;
    const char byte = 0;
    const ssize_t n = write(pipe_ends[1], &byte, 1);
    (void)n; /* a full pipe is readable already */
    pending = 1;
    errno = error;
}

void interrupt_install(void)
{
    if (pipe_ends[0] >= 0 || pipe(pipe_ends) != 0)
        return;
    for (int i = 0; i < 2; i++) {
        (void)fcntl(pipe_ends[i], F_SETFD, FD_CLOEXEC);
        (void)fcntl(pipe_ends[i], F_SETFL, O_NONBLOCK);
    }
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
    /* A file grown past the user's limit is an error like a full disk, not an end by signal. */
    action.sa_handler = SIG_IGN;
    sigaction(SIGXFSZ, &action, NULL);
}

bool interrupt_pending(void) { return pending != 0; }
int interrupt_fd(void) { return pipe_ends[0]; }
