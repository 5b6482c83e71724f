/* SPDX-License-Identifier: MIT */
/* What options tell messages. */
#ifndef LCOR_CLI_MESSAGE_H
#define LCOR_CLI_MESSAGE_H

#include "cli.h"

namespace cli
{

void set_json(bool wanted);
void set_quiet(bool wanted);
void set_silent(bool wanted); /* no warnings at all: for fuzzing */

} // namespace cli

#endif
