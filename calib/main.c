/* SPDX-License-Identifier: MIT */
#include "lccal.h"

#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
} subcommands[] = {
    {"measure", cmd_measure}, {"list", cmd_list},       {"doctor", cmd_doctor},
    {"device", cmd_device},   {"enter", cmd_enter},     {"show", cmd_show},
    {"verify", cmd_verify},   {"history", cmd_history}, {"export", cmd_export},
    {"target", cmd_target},
};

static int run(int argc, char **argv)
{
    for (size_t i = 0; argc > 1 && i < sizeof subcommands / sizeof subcommands[0]; i++)
        if (strcmp(argv[1], subcommands[i].name) == 0)
            return subcommands[i].run(argc - 1, argv + 1);
    return cmd_measure(argc, argv);
}

int main(int argc, char **argv)
{
    const int result = run(argc, argv);
    if ((fflush(stdout) != 0 || ferror(stdout)) && result == LCCAL_OK)
        return lccal_fail(LCCAL_FAILED, "cannot write to standard output");
    return result;
}
