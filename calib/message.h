/* SPDX-License-Identifier: MIT */
/* How the options reader tells the messages what the user asked for. */
#ifndef LCCAL_MESSAGE_H
#define LCCAL_MESSAGE_H

#include <stdbool.h>

void message_set_json(bool on);
void message_set_quiet(bool on);

#endif
