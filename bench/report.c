/* SPDX-License-Identifier: MIT */
#include "report.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

static FILE *json;
static const char *program_name;
static int table_count, row_count;

static double clock_seconds(clockid_t id)
{
    struct timespec t;

    clock_gettime(id, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double bench_seconds(void) { return clock_seconds(CLOCK_PROCESS_CPUTIME_ID); }

double bench_wall_seconds(void) { return clock_seconds(CLOCK_MONOTONIC); }

int report_open(const char *program, const char *path)
{
    program_name = program;
    if (!path)
        return 1;
    json = fopen(path, "w");
    if (!json) {
        perror(path);
        return 0;
    }
    fprintf(json, "{\"tables\": [");
    return 1;
}

void report_table(const char *title, const char *note, const char *columns)
{
    printf("\n%s\n%s\n", title, columns);
    if (json)
        fprintf(json,
                "%s\n{\"title\": \"%s\", \"note\": \"%s\", \"command\": \"%s\", "
                "\"columns\": [%s], \"rows\": [",
                table_count++ ? "]}," : "", title, note, program_name, columns);
    row_count = 0;
}

void report_row(const double *values, int n)
{
    for (int i = 0; i < n; i++)
        printf("%12.4g", values[i]);
    printf("\n");
    fflush(stdout);
    if (json) {
        fprintf(json, "%s[", row_count++ ? ", " : "");
        for (int i = 0; i < n; i++)
            if (isfinite(values[i]))
                fprintf(json, "%s%.4g", i ? ", " : "", values[i]);
            else
                fprintf(json, "%snull", i ? ", " : "");
        fprintf(json, "]");
    }
}

int report_close(void)
{
    if (!json)
        return 1;
    fprintf(json, "]}\n]}\n");
    return fclose(json) == 0;
}
