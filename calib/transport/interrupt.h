/* SPDX-License-Identifier: MIT */
/* SIGINT, SIGTERM and SIGHUP as a file descriptor that poll can wait on beside a port. */
#ifndef LCCAL_INTERRUPT_H
#define LCCAL_INTERRUPT_H

#include <stdbool.h>

void interrupt_install(void);
bool interrupt_pending(void);
/* Readable once a signal came; -1 before interrupt_install. */
int interrupt_fd(void);

#endif
