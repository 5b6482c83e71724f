/* SPDX-License-Identifier: MIT */
/* What a bench program says: tables on the terminal and in the JSON file that docs/accuracy.py
 * reads. */
#ifndef LCOR_BENCH_REPORT_H
#define LCOR_BENCH_REPORT_H

/* `path` may be NULL: no file. Returns 0 if the file cannot be made. */
int report_open(const char *program, const char *path);
/* `columns` as JSON strings with commas between. */
void report_table(const char *title, const char *note, const char *columns);
void report_row(const double *values, int n);
int report_close(void);

/* Processor time of the process. */
double bench_seconds(void);
/* Time of the day, where threads count. */
double bench_wall_seconds(void);

#endif
