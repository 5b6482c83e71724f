/* SPDX-License-Identifier: MIT */
/* What every subcommand of lcor shares: exit codes, errors, options, messages, progress, threads
 * and files that appear whole or not at all. */
#ifndef LCOR_CLI_H
#define LCOR_CLI_H

#include <lcor/lcor.h>

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cli
{

using Json = nlohmann::ordered_json;
using Arguments = std::vector<std::string>;

constexpr double pi = 3.14159265358979323846;

struct PlanDeleter {
    void operator()(lcor_plan *plan) const { lcor_plan_free(plan); }
};
using PlanPointer = std::unique_ptr<lcor_plan, PlanDeleter>;

struct ProfileDeleter {
    void operator()(lcor_profile *profile) const { lcor_profile_free(profile); }
};

/* The program's exit codes; lcor(1) lists them. */
enum class Exit {
    ok = 0,
    failed = 1,      /* the system refused: disk full, no memory */
    usage = 2,       /* command line */
    input = 3,       /* a scene, picture or table is missing or not what it should be */
    permission = 4,  /* a file may not be read or written */
    bad_profile = 7, /* the device profile is missing or broken */
    interrupted = 130
};

/* ---- subcommands: one file each ---- */

struct Command {
    const char *name;
    const char *summary; /* one line for `lcor --help` */
    Exit (*run)(const Arguments &arguments);
};

Exit run_bench(const Arguments &arguments);
Exit run_correct(const Arguments &arguments);
Exit run_info(const Arguments &arguments);
Exit run_irradiance(const Arguments &arguments);
Exit run_paper(const Arguments &arguments);
Exit run_render(const Arguments &arguments);
Exit run_room(const Arguments &arguments);

/* ---- errors: one line that says what, where and what to do next ---- */

#if defined(__GNUC__)
#define CLI_PRINTF(a, b) __attribute__((format(printf, a, b)))
#else
#define CLI_PRINTF(a, b)
#endif

struct Error : std::runtime_error {
    Error(Exit exit_code, const std::string &text) : std::runtime_error(text), code(exit_code) {}
    Exit code;
};

std::string format(const char *pattern, ...) CLI_PRINTF(1, 2);
[[noreturn]] void fail(Exit code, const char *pattern, ...) CLI_PRINTF(2, 3);
/* Throws when a library call failed: bad numbers are the given code's, memory is Exit::failed. */
void check(lcor_status status, const lcor_error &error, Exit code, const std::string &where);

/* ---- messages: people read stderr, programs read stdout ---- */

bool json_wanted();
bool quiet_wanted();
void say(const char *pattern, ...) CLI_PRINTF(1, 2);  /* silenced by --quiet */
void warn(const char *pattern, ...) CLI_PRINTF(1, 2); /* also kept for the JSON document */
/* Print the one document of --json, with "warnings" added; nothing without --json. */
void print_json(Json document);

/* ---- numbers in C notation, whatever the locale ---- */

std::optional<double> parse_number(const std::string &text); /* finite, the whole text */
std::string number_text(double value);                       /* shortest that reads back equal */
std::string short_text(double value);                        /* four digits, to be read by people */
std::string counted(size_t count, const char *noun);         /* "1 patch", "2 patches" */
std::vector<std::string> split(const std::string &text, char separator);
/* "1,2,3" as exactly `count` finite numbers; Exit::usage names `what` otherwise. */
std::vector<double> parse_numbers(const std::string &text, size_t count, const std::string &what);

/* ---- options: one table gives parsing and --help ---- */

class Options
{
  public:
    /* "lcor correct TEXTURE --illuminance MAP -o OUT [options]" and what it does. */
    Options(std::string usage, std::string about);

    /* `name` is "--name" or "-o"; `meta` names the value in --help. Out values keep their default
     * unless the option is given; all references must outlive parse(). */
    Options &flag(const char *name, bool &out, const char *help);
    Options &text(const char *name, const char *meta, std::string &out, const char *help);
    Options &list(const char *name, const char *meta, std::vector<std::string> &out,
                  const char *help);
    Options &number(const char *name, const char *meta, double &out, const char *help);
    Options &number(const char *name, const char *meta, std::optional<double> &out,
                    const char *help);
    Options &count(const char *name, const char *meta, int &out, const char *help); /* 1..1e6 */
    /* One word of `words`; out becomes its index. */
    Options &choice(const char *name, const std::vector<std::string> &words, int &out,
                    const char *help);
    /* Anything else: `store` throws Error(Exit::usage) on a bad value. */
    Options &custom(const char *name, const char *meta,
                    std::function<void(const std::string &)> store, const char *help);

    /* `--name value`, `--name=value`, operands in any order, `--` ends options. --json, --quiet,
     * --help and --version are understood everywhere. False when --help or --version was answered;
     * throws Error(Exit::usage). */
    [[nodiscard]] bool parse(const Arguments &arguments);

    const std::vector<std::string> &operands() const { return operands_; }
    bool given(const char *name) const;
    /* The only operand, or Exit::usage saying that `what` is missing. */
    const std::string &operand(const char *what) const;

  private:
    struct Entry {
        std::string name, meta, help;
        std::function<void(const std::string &)> store; /* empty meta: called with "" */
        bool given;
    };
    Options &add(const char *name, const char *meta, const char *help,
                 std::function<void(const std::string &)> store);
    Entry *find(const std::string &name);
    void print_help() const;

    std::string usage_, about_;
    std::vector<Entry> entries_;
    std::vector<std::string> operands_;
};

/* ---- the output device: --profile F | --contrast C ---- */

struct Device {
    double contrast = 0.0;         /* c of eq 13a */
    double contrast_u95 = 0.0;     /* 0: not known */
    std::string profile;           /* path, or empty for --contrast */
    std::vector<float> tone_curve; /* of a profile with a grey ramp, else empty */
};

struct DeviceOptions {
    std::string profile;
    std::optional<double> contrast;
    void declare(Options &options);
    bool given() const { return !profile.empty() || contrast; }
    /* Exit::usage, Exit::bad_profile, Exit::permission. A device that is not needed may be left
     * out: it has contrast infinity. */
    Device load(bool needed) const;
};

/* ---- the correction's own options, the same for pictures and for views ---- */

struct CorrectionOptions {
    int reading = 0; /* lcor_reading */
    std::string mean = "adaptive";
    double exponent = 1.0;
    int space; /* lcor_primaries */
    std::string transfer;
    int lightness = 0; /* lcor_lightness */
    int gamut = 0;     /* lcor_gamut */
    bool conventional = false;

    /* Defaults for 8-bit pictures: sRGB primaries and transfer function. */
    CorrectionOptions();
    void declare(Options &options, bool with_space = true);
    /* --mean: the method, or the number given. */
    lcor_mean_method mean_method() const;
    std::optional<double> given_mean() const;
    /* Space and transfer as asked for; "auto" is sRGB for integers and linear for floats. */
    lcor_colour colour(bool float_samples) const;
    /* Filled but for r_mean, rho, sample types and layouts; `colour` must outlive its use. */
    lcor_plan_options plan(const Device &device, const lcor_colour &colour) const;
};

/* ---- long work ---- */

/* A line with time left on a terminal, nothing elsewhere or with --quiet. Parts follow each other:
 * report() takes 0..1 of the whole. */
class Progress
{
  public:
    explicit Progress(std::string what);
    ~Progress();
    Progress(const Progress &) = delete;
    Progress &operator=(const Progress &) = delete;
    void report(double done);
    /* report() as the library wants it; lives as long as this. */
    lcor_progress callback();

  private:
    std::string what_;
    bool shown_;
    double start_, last_ = 0.0;
};

/* A pool for lcor_parallel and for rows of pixels. Work is cut the same way whatever the number of
 * threads, so results have the same bytes. */
class Threads
{
  public:
    explicit Threads(int count); /* 0: as many as the machine has */
    ~Threads();
    Threads(const Threads &) = delete;
    Threads &operator=(const Threads &) = delete;
    int count() const;
    /* task(i) for i in 0..n-1; the first exception is rethrown here. */
    void run(size_t n, const std::function<void(size_t)> &task);
    lcor_parallel parallel();

  private:
    struct Pool;
    std::unique_ptr<Pool> pool_;
};

/* Exit::input if `what` needs more bytes of memory than the machine has or lets the process use;
 * `advice` says what to do. */
void check_memory(double bytes, const std::string &what, const char *advice);

/* ---- files ---- */

/* An output that takes its place only when whole: write to temporary(), then commit(), which syncs
 * and renames. Destroyed uncommitted, or on Ctrl-C, the temporary file is removed and what stood at
 * the path before still stands. Devices and pipes (/dev/stdout) are written to directly. */
class OutputFile
{
  public:
    explicit OutputFile(std::string path); /* Exit::permission or Exit::failed */
    ~OutputFile();
    OutputFile(const OutputFile &) = delete;
    OutputFile &operator=(const OutputFile &) = delete;
    const std::string &path() const { return path_; }
    const std::string &temporary() const { return temporary_; }
    void commit();

  private:
    std::string path_, target_, temporary_;
    int slot_ = -1;
    bool direct_ = false;
};

/* "cannot WHAT 'PATH': reason", for an errno, with what to do about it. */
[[noreturn]] void fail_file(const char *what, const std::string &path, int error);
/* The whole of a file as bytes, at most `limit`; Exit::input (or `missing`) names it otherwise. */
std::string read_file(const std::string &path, uint64_t limit, Exit missing = Exit::input);
std::string read_start(const std::string &path, size_t size); /* its first bytes */
void write_file(const std::string &path, const std::string &bytes);
/* Fails as write_file would for a path that cannot be written to: before the long work. */
void check_output(const std::string &path);
/* Ctrl-C, SIGTERM and SIGHUP remove temporary files and end with 128 + their number; so does
 * exit(), with its own code. */
void handle_signals();

} // namespace cli

#endif
