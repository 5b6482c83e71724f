/* SPDX-License-Identifier: MIT */
#include "filter.h"
#include "pipeline.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_SIZE    1024
#define TEXT_MAX     ((size_t)4 << 20) /* of a profile or an adaptation */
#define TONE_SIZE    1024
#define FOLDER       "lcor" /* in CUPS_SERVERROOT: files that jobs may name */
#define DEFAULT_ROOT "/etc/cups"

/* Every setting: as a job option, and as an option or keyword of the PPD. */
static const struct setting {
    const char *option, *keyword;
} settings[] = {{"lcor-correction", "LcorCorrection"},
                {"lcor-profile", "LcorProfile"},
                {"lcor-contrast", "LcorContrast"},
                {"lcor-illuminance", "LcorIlluminance"},
                {"lcor-adaptation", "LcorAdaptation"},
                {"lcor-mean", "LcorMean"},
                {"lcor-passes", "LcorPasses"},
                {"lcor-reading", "LcorReading"},
                {"lcor-rho", "LcorRho"},
                {"lcor-exponent", "LcorExponent"},
                {"lcor-gamut", "LcorGamut"},
                {"lcor-lightness", "LcorLightness"},
                {"lcor-threads", "LcorThreads"}};

typedef struct source {
    int option_count;
    cups_option_t *options;
    ppd_file_t *ppd;
} source;

/* The job's word before the PPD's; NULL for neither. *by_job says whose it is. */
static const char *find(const source *from, const char *option, bool *by_job)
{
    const char *value = cupsGetOption(option, from->option_count, from->options);
    *by_job = value != NULL;
    if (value || !from->ppd)
        return value;
    const char *keyword = NULL;
    for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++)
        if (strcmp(settings[i].option, option) == 0)
            keyword = settings[i].keyword;
    const ppd_choice_t *choice = ppdFindMarkedChoice(from->ppd, keyword);
    if (choice)
        return choice->choice;
    const ppd_attr_t *attribute = ppdFindAttr(from->ppd, keyword, NULL);
    return attribute ? attribute->value : NULL;
}

/* A word of `words` (NULL at the end) becomes its index. */
static bool choose(const source *from, const char *option, const char *const *words, int *index)
{
    bool by_job;
    char all[128] = "";
    const char *value = find(from, option, &by_job);
    if (!value)
        return true;
    for (int i = 0; words[i]; i++) {
        if (strcasecmp(value, words[i]) == 0) {
            *index = i;
            return true;
        }
        const size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", i > 0 ? ", " : "", words[i]);
    }
    filter_say("ERROR", "%s=%s: choose one of %s", option, value, all);
    return false;
}

static bool number(const source *from, const char *option, double *out)
{
    bool by_job;
    const char *value = find(from, option, &by_job);
    if (value && !filter_number(value, out)) {
        filter_say("ERROR", "%s=%s: a number is wanted, such as 0.5", option, value);
        return false;
    }
    return true;
}

static bool threads(const source *from, size_t *out)
{
    double n = 0.0;
    if (!number(from, "lcor-threads", &n))
        return false;
    if (n >= 0.0 && n <= PIPELINE_WORKERS_MAX && n == (double)(size_t)n) {
        *out = (size_t)n;
        return true;
    }
    filter_say("ERROR", "lcor-threads: choose 1 to %d", PIPELINE_WORKERS_MAX);
    return false;
}

/* The file a setting names, in `path`; empty for none. What the scheduler runs opens for a job only
 * files of one folder: a job may come from anywhere. */
static bool find_file(const source *from, const char *option, char path[PATH_SIZE])
{
    bool by_job;
    const char *root = getenv("CUPS_SERVERROOT");
    const char *value = find(from, option, &by_job);
    int length = 0;
    path[0] = '\0';
    if (!value || *value == '\0')
        return true;
    if (by_job && root && (strchr(value, '/') || strcmp(value, "..") == 0)) {
        filter_say("ERROR", "%s=%s: a job names a file of %s/%s without a folder", option, value,
                   root, FOLDER);
        return false;
    }
    if (*value == '/' || (by_job && !root))
        length = snprintf(path, PATH_SIZE, "%s", value);
    else
        length = snprintf(path, PATH_SIZE, "%s/%s/%s", root ? root : DEFAULT_ROOT, FOLDER, value);
    if (length < 0 || length >= PATH_SIZE) {
        filter_say("ERROR", "%s: the name is longer than %d bytes", option, PATH_SIZE);
        return false;
    }
    return true;
}

/* A whole file as text; NULL with an ERROR line. The caller frees it. */
static char *read_text(const char *option, const char *path, size_t *size)
{
    struct stat info;
    char *text = NULL;
    const char *why = NULL;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 || fstat(fd, &info) != 0)
        why = strerror(errno);
    else if (!S_ISREG(info.st_mode) || info.st_size > (off_t)TEXT_MAX)
        why = "not a regular file of at most 4 MiB";
    else if (!(text = malloc((size_t)info.st_size + 1)))
        why = "no memory";
    *size = 0;
    while (!why && *size < (size_t)info.st_size) {
        const ssize_t got = read(fd, text + *size, (size_t)info.st_size - *size);
        if (got <= 0)
            why = got < 0 ? strerror(errno) : "it became shorter while it was read";
        else
            *size += (size_t)got;
    }
    if (fd >= 0)
        close(fd);
    if (why) {
        filter_say("ERROR", "%s: %s: %s", option, path, why);
        free(text);
        return NULL;
    }
    text[*size] = '\0';
    return text;
}

static bool load_profile(filter_job *job, const char *path)
{
    size_t size;
    lcor_error error;
    lcor_profile *profile = NULL;
    char *text = read_text("lcor-profile", path, &size);
    if (!text)
        return false;
    const lcor_status status = lcor_profile_parse(text, size, NULL, &profile, &error);
    free(text);
    if (status != LCOR_OK) {
        filter_say("ERROR", "lcor-profile: %s: %s", path, error.text);
        return false;
    }
    job->contrast = lcor_profile_contrast(profile);
    bool good = true;
    if (lcor_profile_grey_levels(profile) > 0) {
        job->tone_size = TONE_SIZE;
        job->tone_curve = malloc(TONE_SIZE * sizeof *job->tone_curve);
        good = job->tone_curve &&
               lcor_profile_tone_curve(profile, TONE_SIZE, job->tone_curve, &error) == LCOR_OK;
        if (!good)
            filter_say("ERROR", "lcor-profile: %s: %s", path,
                       job->tone_curve ? error.text : "no memory");
    }
    lcor_profile_free(profile);
    return good;
}

/* `r_mean NUMBER` on a line of its own, as `lcor render --adaptation` writes it. */
static bool load_adaptation(filter_job *job, const char *path)
{
    size_t size;
    char *text = read_text("lcor-adaptation", path, &size), *rest = NULL;
    if (!text)
        return false;
    for (char *line = strtok_r(text, "\r\n", &rest); line && !job->r_mean_given;
         line = strtok_r(NULL, "\r\n", &rest)) {
        char *words = NULL;
        const char *key = strtok_r(line, " \t", &words), *value = strtok_r(NULL, " \t", &words);
        if (key && value && strcmp(key, "r_mean") == 0 && filter_number(value, &job->r_mean))
            job->r_mean_given = true;
    }
    free(text);
    if (!job->r_mean_given)
        filter_say("ERROR", "lcor-adaptation: %s: no line \"r_mean NUMBER\"", path);
    return job->r_mean_given;
}

static bool load_device(filter_job *job, const source *from)
{
    char path[PATH_SIZE];
    if (!find_file(from, "lcor-profile", path) || !number(from, "lcor-contrast", &job->contrast))
        return false;
    if (path[0] && job->contrast == 0.0)
        return load_profile(job, path);
    if (job->contrast != 0.0)
        return true;
    filter_say("ERROR", "no device profile: measure the printer with lccal and set lcor-profile, "
                        "or set lcor-contrast");
    return false;
}

/* lcor-adaptation, or lcor-mean: a method, or the mean itself. */
static bool load_mean(filter_job *job, const source *from)
{
    char path[PATH_SIZE];
    bool by_job;
    const char *mean = find(from, "lcor-mean", &by_job);
    if (!find_file(from, "lcor-adaptation", path) || (path[0] && !load_adaptation(job, path)))
        return false;
    if (!mean || strcasecmp(mean, "adaptive") == 0)
        return true;
    if (strcasecmp(mean, "literal") == 0) {
        job->mean_method = LCOR_MEAN_LITERAL;
        return true;
    }
    job->r_mean_given = filter_number(mean, &job->r_mean);
    if (!job->r_mean_given)
        filter_say("ERROR", "lcor-mean=%s: choose adaptive, literal or a number", mean);
    return job->r_mean_given;
}

/* The library judges the numbers, before the first page is touched. */
static bool judge(const filter_job *job)
{
    lcor_plan_options options = {.struct_size = sizeof options};
    lcor_plan *plan = NULL;
    lcor_error error;
    options.contrast = job->contrast;
    options.r_mean = job->r_mean;
    options.rho = job->rho;
    options.exponent = job->exponent;
    if (lcor_plan_new(&options, &plan, &error) != LCOR_OK) {
        filter_say("ERROR", "the job's settings: %s", error.text);
        return false;
    }
    lcor_plan_free(plan);
    return true;
}

static bool known(int option_count, const cups_option_t *options)
{
    for (int i = 0; i < option_count; i++) {
        bool found = strncasecmp(options[i].name, "lcor-", 5) != 0;
        for (size_t k = 0; k < sizeof settings / sizeof settings[0]; k++)
            found = found || strcasecmp(options[i].name, settings[k].option) == 0;
        if (!found) {
            filter_say("ERROR", "unknown option %s: see rastertolcor(8)", options[i].name);
            return false;
        }
    }
    return true;
}

bool job_open(filter_job *job, int option_count, cups_option_t *options, ppd_file_t *ppd)
{
    static const char *const on_off[] = {"off", "on", NULL};
    static const char *const passes[] = {"1", "2", NULL};
    static const char *const reading[] = {"patch", "texel", NULL};
    static const char *const gamut[] = {"keep-hue", "clip", NULL};
    static const char *const lightness[] = {"cie", "paper", NULL};
    const source from = {option_count, options, ppd};
    int correct = 1, second = 1, read = 0, fit = 0, light = 0;
    char path[PATH_SIZE];

    memset(job, 0, sizeof *job);
    job->map.fd = -1;
    job->rho = 0.5;
    job->exponent = 1.0;
    job->r_mean = 1.0;
    if (!known(option_count, options) || !choose(&from, "lcor-correction", on_off, &correct))
        return false;
    job->correct = correct;
    if (!correct)
        return true;
    if (!threads(&from, &job->threads) || !choose(&from, "lcor-passes", passes, &second) ||
        !choose(&from, "lcor-reading", reading, &read) ||
        !choose(&from, "lcor-gamut", gamut, &fit) ||
        !choose(&from, "lcor-lightness", lightness, &light) ||
        !number(&from, "lcor-rho", &job->rho) || !number(&from, "lcor-exponent", &job->exponent) ||
        !load_device(job, &from) || !load_mean(job, &from) || !judge(job) ||
        !find_file(&from, "lcor-illuminance", path) ||
        (path[0] && !illuminance_open(&job->map, path))) {
        job_close(job);
        return false;
    }
    job->two_passes = second;
    job->reading = read ? LCOR_READING_TEXEL : LCOR_READING_PATCH;
    job->gamut = fit ? LCOR_GAMUT_CLIP : LCOR_GAMUT_KEEP_HUE;
    job->lightness = light ? LCOR_LIGHTNESS_PAPER : LCOR_LIGHTNESS_CIE;
    return true;
}

void job_close(filter_job *job)
{
    illuminance_close(&job->map);
    free(job->tone_curve);
    job->tone_curve = NULL;
}
