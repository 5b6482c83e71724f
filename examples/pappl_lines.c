/* SPDX-License-Identifier: MIT */
/* A printer application on PAPPL whose driver corrects each line before it goes to the device.
 *
 *     cc -std=c99 pappl_lines.c $(pkg-config --cflags --libs lcor pappl) -o pappl_lines
 *     ./pappl_lines add -d paper -m lcor-rgb -v socket://printer && ./pappl_lines submit -d paper
 * a.jpg
 *
 * PAPPL hands a page over line by line and only once, so r_mean must be known when a page starts:
 * with even light and patch reading it is rho. A driver with a light map takes the mean of the map.
 */
#include <lcor/lcor.h>
#include <pappl/pappl.h>

#include <stdlib.h>
#include <string.h>

/* One page: made by start_page, used by every line, freed by end_page. */
typedef struct page {
    lcor_plan *plan;
    lcor_row_stats stats;
    size_t width, bytes;
    float *light;
    unsigned char *line;
} page;

static void free_page(page *p)
{
    if (p) {
        lcor_plan_free(p->plan);
        free(p->light);
        free(p->line);
        free(p);
    }
}

static bool start_page(pappl_job_t *job, pappl_pr_options_t *options, pappl_device_t *device,
                       unsigned number)
{
    const char *contrast = cupsGetOption("contrast", options->num_vendor, options->vendor);
    lcor_plan_options o;
    lcor_colour srgb;
    lcor_error error = {LCOR_OK, -1, "no memory, or a page that is not sRGB of 8 bits"};
    page *p = calloc(1, sizeof *p);
    (void)device, (void)number;

    memset(&o, 0, sizeof o);
    o.struct_size = sizeof o;
    o.contrast = contrast ? atoi(contrast) : 23;
    o.rho = o.r_mean = 0.5;
    o.colour = &srgb;
    o.in_type = o.out_type = LCOR_U8;
    if (p) {
        p->width = options->header.cupsWidth;
        p->bytes = options->header.cupsBytesPerLine;
        p->light = malloc(p->width * sizeof *p->light);
        p->line = malloc(p->bytes);
    }
    if (!p || !p->light || !p->line || p->bytes != 3 * p->width ||
        lcor_colour_init(&srgb, LCOR_PRIMARIES_SRGB, NULL, LCOR_TRANSFER_SRGB, 1.0,
                         LCOR_LIGHTNESS_CIE, &error) != LCOR_OK ||
        lcor_plan_new(&o, &p->plan, &error) != LCOR_OK) {
        papplLogJob(job, PAPPL_LOGLEVEL_ERROR, "lcor: %s", error.text);
        free_page(p);
        return false;
    }
    for (size_t x = 0; x < p->width; x++) /* a lamp on the left, whose mean is 1 */
        p->light[x] = 1.5f - (float)x / (float)p->width;
    papplJobSetData(job, p);
    return true;
}

static bool write_line(pappl_job_t *job, pappl_pr_options_t *options, pappl_device_t *device,
                       unsigned y, const unsigned char *line)
{
    page *p = papplJobGetData(job);
    (void)options;
    lcor_correct_row(p->plan, y, p->width, line, p->light, NULL, p->line, &p->stats);
    return papplDeviceWrite(device, p->line, p->bytes) == (ssize_t)p->bytes;
}

static bool end_page(pappl_job_t *job, pappl_pr_options_t *options, pappl_device_t *device,
                     unsigned number)
{
    page *p = papplJobGetData(job);
    (void)options, (void)device;
    papplLogJob(job, PAPPL_LOGLEVEL_DEBUG, "page %u: %llu of %llu pixels lie outside the device",
                number, (unsigned long long)(p->stats.clipped_low + p->stats.clipped_high),
                (unsigned long long)p->stats.pixels);
    free_page(p);
    papplJobSetData(job, NULL);
    return true;
}

static bool job_without_pages(pappl_job_t *job, pappl_pr_options_t *options, pappl_device_t *device)
{
    (void)job, (void)options, (void)device;
    return true;
}

static bool status(pappl_printer_t *printer)
{
    (void)printer;
    return true;
}

static bool driver(pappl_system_t *system, const char *name, const char *uri, const char *id,
                   pappl_pr_driver_data_t *data, ipp_t **attributes, void *context)
{
    (void)system, (void)name, (void)uri, (void)id, (void)attributes, (void)context;
    data->rstartjob_cb = data->rendjob_cb = job_without_pages;
    data->rstartpage_cb = start_page;
    data->rwriteline_cb = write_line;
    data->rendpage_cb = end_page;
    data->status_cb = status;
    strcpy(data->make_and_model, "Lines corrected by lcor");
    data->format = "application/octet-stream";
    data->raster_types = PAPPL_PWG_RASTER_TYPE_SRGB_8;
    data->color_supported = data->color_default = PAPPL_COLOR_MODE_COLOR;
    data->num_resolution = 1;
    data->x_resolution[0] = data->y_resolution[0] = 300;
    data->x_default = data->y_default = 300;
    data->num_media = 1;
    data->media[0] = "iso_a4_210x297mm";
    strcpy(data->media_default.size_name, data->media[0]);
    data->media_default.size_width = 21000;
    data->media_default.size_length = 29700;
    data->media_ready[0] = data->media_default;
    data->num_vendor = 1;
    data->vendor[0] = "contrast";
    return true;
}

int main(int argc, char *argv[])
{
    static pappl_pr_driver_t drivers[] = {{"lcor-rgb", "Lines corrected by lcor", NULL, NULL}};
    return papplMainloop(argc, argv, lcor_version(), NULL, 1, drivers, NULL, driver, NULL, NULL,
                         NULL, NULL, NULL);
}
