/* SPDX-License-Identifier: MIT */
#include "lccal.h"
#include "message.h"

#include <lcor/version.h>

#include <stdio.h>
#include <string.h>

static const lccal_option *find(const lccal_option *options, size_t count, const char *name,
                                size_t length)
{
    for (size_t i = 0; i < count; i++) {
        if (strlen(options[i].name) == length && memcmp(options[i].name, name, length) == 0)
            return &options[i];
        if (options[i].alias && strlen(options[i].alias) == length &&
            memcmp(options[i].alias, name, length) == 0)
            return &options[i];
    }
    return NULL;
}

static int store(const lccal_option *option, const char *value)
{
    double number = 0.0;
    switch (option->kind) {
    case LCCAL_FLAG: *(bool *)option->out = true; return LCCAL_OK;
    case LCCAL_TEXT: *(const char **)option->out = value; return LCCAL_OK;
    case LCCAL_NUMBER:
        if (!lccal_parse_number(value, strlen(value), &number))
            return lccal_fail(LCCAL_USAGE, "%s wants a number such as 1.5, not '%s'", option->name,
                              value);
        *(double *)option->out = number;
        return LCCAL_OK;
    case LCCAL_COUNT:
        if (!lccal_parse_number(value, strlen(value), &number) || number < 1.0 || number > 1e6 ||
            strchr(value, '.'))
            return lccal_fail(LCCAL_USAGE, "%s wants a whole number from 1 on, not '%s'",
                              option->name, value);
        *(int *)option->out = (int)number;
        return LCCAL_OK;
    }
    return LCCAL_USAGE;
}

/* Answer --help and --version; -1 when there was nothing left to do. */
static int common_option(const char *arg, const char *help, bool *known)
{
    *known = true;
    if (strcmp(arg, "--json") == 0) {
        return LCCAL_OK; /* known already */
    } else if (strcmp(arg, "--quiet") == 0) {
        message_set_quiet(true);
    } else if (strcmp(arg, "--help") == 0) {
        fputs(help, stdout);
        return -1;
    } else if (strcmp(arg, "--version") == 0) {
        printf("lccal %s\n", lcor_version());
        return -1;
    } else {
        *known = false;
    }
    return LCCAL_OK;
}

/* Errors are events wherever --json stands, also behind them. */
static bool asks_for_json(int argc, char **argv, const lccal_option *options, size_t count)
{
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--json") == 0)
            return true;
        const lccal_option *option = find(options, count, argv[i], strlen(argv[i]));
        i += option && option->kind != LCCAL_FLAG; /* its value */
    }
    return false;
}

int lccal_parse_options(int *argc, char **argv, const lccal_option *options, size_t count,
                        const char *help)
{
    int operands = 1;
    bool only_operands = false;
    message_set_json(asks_for_json(*argc, argv, options, count));
    for (int i = 1; i < *argc; i++) {
        char *arg = argv[i];
        if (only_operands || arg[0] != '-' || arg[1] == '\0') {
            argv[operands++] = arg;
            continue;
        }
        if (strcmp(arg, "--") == 0) {
            only_operands = true;
            continue;
        }
        bool known;
        const int common = common_option(arg, help, &known);
        if (common != LCCAL_OK)
            return common;
        if (known)
            continue;
        const char *equals = strchr(arg, '=');
        const size_t length = equals ? (size_t)(equals - arg) : strlen(arg);
        const lccal_option *option = find(options, count, arg, length);
        if (!option)
            return lccal_fail(LCCAL_USAGE, "unknown option '%.*s'; --help lists them", (int)length,
                              arg);
        if (option->kind == LCCAL_FLAG && equals)
            return lccal_fail(LCCAL_USAGE, "%s takes no value", option->name);
        const char *value = equals ? equals + 1 : NULL;
        if (option->kind != LCCAL_FLAG && !value) {
            if (i + 1 >= *argc)
                return lccal_fail(LCCAL_USAGE, "%s wants a value", option->name);
            value = argv[++i];
        }
        const int status = store(option, value);
        if (status != LCCAL_OK)
            return status;
    }
    argv[operands < *argc ? operands : *argc] = NULL;
    *argc = operands;
    return LCCAL_OK;
}
