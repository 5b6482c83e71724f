/* SPDX-License-Identifier: MIT */
/* Instruments that are plugged in, and what keeps them from being used. */
#ifndef LCCAL_FIND_H
#define LCCAL_FIND_H

#include "instrument/instrument.h"
#include "transport/ports.h"

enum { PORTS_MAX = 256 };

/* Why the device cannot be used and what to do; NULL: it can. model may be NULL. */
const char *find_obstacle(const port_info *port, const usb_model *model);

#endif
