/* SPDX-License-Identifier: MIT */
/* What core.c needs of the machine it runs on. */
#ifndef LCOR_PORT_H
#define LCOR_PORT_H

#include <stddef.h>

void port_write(const char *text);
/* Fill the stack below the caller with a pattern; how much of it was overwritten since. 0 where the
 * machine's stack cannot be seen. */
void port_stack_paint(void);
size_t port_stack_used(void);

#endif
