/* SPDX-License-Identifier: MIT */
#include "message.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <ctime>
#include <unistd.h>

namespace cli
{

namespace
{

struct Console {
    bool json = false, quiet = false, silent = false;
    bool line_open = false; /* a progress line stands on the terminal */
    std::vector<std::string> warnings;
};

Console &console()
{
    static Console the_console;
    return the_console;
}

/* Length of the UTF-8 character that starts at `at`, 0 where there is none. */
size_t utf8_length(const std::string &text, size_t at)
{
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(at);
    const size_t length = first < 0x80   ? 1
                          : first < 0xC2 ? 0
                          : first < 0xE0 ? 2
                          : first < 0xF0 ? 3
                          : first < 0xF5 ? 4
                                         : 0;
    if (length == 0 || at + length > text.size())
        return 0;
    for (size_t i = 1; i < length; i++)
        if ((byte(at + i) & 0xC0) != 0x80)
            return 0;
    return length;
}

/* One line of text, whatever bytes a file's name or content holds. */
std::string printable(const std::string &text)
{
    std::string out;
    for (size_t at = 0; at < text.size();) {
        const size_t length = utf8_length(text, at);
        const auto first = static_cast<unsigned char>(text[at]);
        if (length == 0)
            out += '?';
        else if (first < ' ' || first == 127)
            out += ' ';
        else
            out.append(text, at, length);
        at += length == 0 ? 1 : length;
    }
    return out;
}

std::string formatted(const char *pattern, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    const int size = std::vsnprintf(nullptr, 0, pattern, arguments);
    std::string text(size > 0 ? static_cast<size_t>(size) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, pattern, again);
    va_end(again);
    return printable(text);
}

double seconds()
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void close_line()
{
    if (console().line_open)
        std::fputs("\r\033[K", stderr);
    console().line_open = false;
}

} // namespace

void set_json(bool wanted) { console().json = wanted; }
void set_quiet(bool wanted) { console().quiet = wanted; }
void set_silent(bool wanted) { console().silent = wanted; }
bool json_wanted() { return console().json; }
bool quiet_wanted() { return console().quiet; }

std::string format(const char *pattern, ...)
{
    va_list arguments;
    va_start(arguments, pattern);
    std::string text = formatted(pattern, arguments);
    va_end(arguments);
    return text;
}

void fail(Exit code, const char *pattern, ...)
{
    va_list arguments;
    va_start(arguments, pattern);
    const std::string text = formatted(pattern, arguments);
    va_end(arguments);
    throw Error(code, text);
}

void check(lcor_status status, const lcor_error &error, Exit code, const std::string &where)
{
    if (status == LCOR_OK)
        return;
    if (status == LCOR_ERR_NOMEM)
        code = Exit::failed;
    fail(code, "%s: %s", where.c_str(), error.text);
}

void say(const char *pattern, ...)
{
    if (console().quiet)
        return;
    va_list arguments;
    va_start(arguments, pattern);
    const std::string text = formatted(pattern, arguments);
    va_end(arguments);
    close_line();
    std::fprintf(stderr, "%s\n", text.c_str());
}

void warn(const char *pattern, ...)
{
    if (console().silent)
        return;
    va_list arguments;
    va_start(arguments, pattern);
    const std::string text = formatted(pattern, arguments);
    va_end(arguments);
    close_line();
    std::fprintf(stderr, "lcor: warning: %s\n", text.c_str());
    console().warnings.push_back(text);
}

void print_json(Json document)
{
    if (!console().json)
        return;
    document["warnings"] = console().warnings;
    const std::string text = document.dump(2, ' ', false, Json::error_handler_t::replace);
    std::printf("%s\n", text.c_str());
}

Progress::Progress(std::string what)
    : what_(std::move(what)), shown_(!console().quiet && isatty(STDERR_FILENO) != 0),
      start_(seconds())
{
}

Progress::~Progress() { close_line(); }

void Progress::report(double done)
{
    const double now = seconds();
    /* Nothing for work that is over at once, then ten times a second. */
    if (!shown_ || now - start_ < 0.5 || now - last_ < 0.1)
        return;
    last_ = now;
    const double left = done > 0.01 ? (now - start_) * (1.0 - done) / done : -1.0;
    std::fprintf(stderr, "\r\033[K%s: %3.0f %%", what_.c_str(), 100.0 * done);
    if (left >= 60.0)
        std::fprintf(stderr, ", %ld min %ld s left", std::lround(left) / 60,
                     std::lround(left) % 60);
    else if (left >= 0.0)
        std::fprintf(stderr, ", %ld s left", std::lround(left));
    std::fflush(stderr);
    console().line_open = true;
}

lcor_progress Progress::callback()
{
    return {[](void *user, double done) {
                static_cast<Progress *>(user)->report(done);
                return 0;
            },
            this};
}

} // namespace cli
