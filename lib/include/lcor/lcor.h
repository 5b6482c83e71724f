/* SPDX-License-Identifier: MIT */
/** @file
 *  liblcor: lightness correction for photorealistic rendering on devices of limited contrast.
 *
 *  Includes every public header. Print drivers need correct.h and adapt.h only. */
#ifndef LCOR_LCOR_H
#define LCOR_LCOR_H

#include <lcor/adapt.h>
#include <lcor/alloc.h>
#include <lcor/colour.h>
#include <lcor/correct.h>
#include <lcor/export.h>
#include <lcor/parallel.h>
#include <lcor/profile.h>
#include <lcor/radiosity.h>
#include <lcor/scene.h>
#include <lcor/status.h>
#include <lcor/version.h>
#include <lcor/view.h>

#endif
