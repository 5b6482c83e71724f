/* SPDX-License-Identifier: MIT */
#include "base/internal.h"

#include <stdarg.h>
#include <stdio.h>

const char *lcor_status_name(lcor_status status)
{
    switch (status) {
    case LCOR_OK: return "LCOR_OK";
    case LCOR_ERR_ARG: return "LCOR_ERR_ARG";
    case LCOR_ERR_DOMAIN: return "LCOR_ERR_DOMAIN";
    case LCOR_ERR_NOMEM: return "LCOR_ERR_NOMEM";
    case LCOR_ERR_CANCELLED: return "LCOR_ERR_CANCELLED";
    case LCOR_ERR_FORMAT: return "LCOR_ERR_FORMAT";
    }
    return "LCOR_ERR_UNKNOWN";
}

lcor_status lcor_internal_fail(lcor_error *err, lcor_status status, long where, const char *format,
                               ...)
{
    if (err != NULL) {
        va_list args;

        err->status = status;
        err->where = where;
        va_start(args, format);
        if (vsnprintf(err->text, sizeof err->text, format, args) < 0)
            err->text[0] = '\0';
        va_end(args);
    }
    return status;
}
