/* SPDX-License-Identifier: MIT */
/* Preloaded into a tool: sends it the signal KILL_SIGNAL just before or after its KILL_AT-th step
 * of saving a file. SIGKILL is what a power cut would be. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/types.h>
#include <unistd.h>

static int steps;

static void step(void)
{
    const char *at = getenv("KILL_AT");
    const char *number = getenv("KILL_SIGNAL");
    if (at && number && ++steps == atoi(at))
        raise(atoi(number));
}

#define WRAP(type, name, declared, passed)                                                         \
    type name declared                                                                             \
    {                                                                                              \
        type(*next) declared = (type(*) declared)dlsym(RTLD_NEXT, #name);                          \
        step();                                                                                    \
        const type result = next passed;                                                           \
        step();                                                                                    \
        return result;                                                                             \
    }

WRAP(int, mkstemp, (char *name), (name))
WRAP(int, fchmod, (int fd, mode_t mode), (fd, mode))
WRAP(int, fsync, (int fd), (fd))
WRAP(int, link, (const char *from, const char *to), (from, to))
WRAP(int, rename, (const char *from, const char *to), (from, to))
WRAP(int, unlink, (const char *name), (name))
