/* SPDX-License-Identifier: MIT */
#include "instrument/instrument.h"

#define USE_ARGYLL "measure with ArgyllCMS and take its file: lccal enter --import"

const usb_model usb_models[] = {
    {0x16D0, 0x10EB, "Printalyzer Densitometer", "printalyzer", NULL},
    {0x16D0, 0x13E7, "Printalyzer UV/VIS Densitometer", "printalyzer", NULL},
    {0x16D0, 0x1198, "Printalyzer Densitometer in its boot loader", NULL,
     "unplug it and plug it in again without holding a button"},
    {0x16D0, 0x1382, "DensiStick", "densistick", NULL},
    {0x273F, 0x1004, "ColorHug2", "colorhug2", NULL},
    {0x273F, 0x1005, "ColorHug2 in its boot loader", NULL,
     "wait a few seconds, or plug it in again"},
    {0x273F, 0x1001, "ColorHug, first model", NULL, USE_ARGYLL},
    {0x04D8, 0xF8DA, "ColorHug, first model", NULL, USE_ARGYLL},
    {0x0765, 0xD020, "X-Rite DTP20", NULL, USE_ARGYLL},
    {0x0765, 0xD092, "X-Rite DTP92Q", NULL, USE_ARGYLL},
    {0x0765, 0xD094, "X-Rite DTP94", NULL, USE_ARGYLL},
    {0x0765, 0x5020, "i1Display Pro or ColorMunki Display", NULL, USE_ARGYLL},
    {0x0971, 0x2000, "i1Pro", NULL, USE_ARGYLL},
    {0x0971, 0x2005, "Huey", NULL, USE_ARGYLL},
    {0x0765, 0x5001, "Huey", NULL, USE_ARGYLL},
    {0x0765, 0x5010, "Huey", NULL, USE_ARGYLL},
};

const size_t usb_model_count = sizeof usb_models / sizeof usb_models[0];

const usb_model *usb_model_find(unsigned vendor, unsigned product)
{
    for (size_t i = 0; i < usb_model_count; i++)
        if (usb_models[i].vendor == vendor && usb_models[i].product == product)
            return &usb_models[i];
    return NULL;
}
