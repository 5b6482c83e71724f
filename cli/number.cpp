/* SPDX-License-Identifier: MIT */
#include "cli.h"

#include <charconv>
#include <cmath>

namespace cli
{

std::optional<double> parse_number(const std::string &text)
{
    const char *first = text.data();
    const char *const last = first + text.size();
    if (first != last && *first == '+' && text.size() > 1 && text[1] != '-')
        first++;
    double value = 0.0;
    const auto [end, error] = std::from_chars(first, last, value);
    if (error != std::errc() || end != last || first == last || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::string number_text(double value)
{
    if (std::isnan(value))
        return "nan";
    char buffer[32];
    const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
    return error == std::errc() ? std::string(buffer, end) : std::string();
}

std::string short_text(double value)
{
    char buffer[32];
    const auto [end, error] =
        std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 4);
    return error == std::errc() ? std::string(buffer, end) : std::string();
}

std::string counted(size_t count, const char *noun)
{
    const std::string one = noun;
    const bool hisses = one.size() > 2 && one.compare(one.size() - 2, 2, "ch") == 0;
    return format("%zu %s%s", count, noun, count == 1 ? "" : hisses ? "es" : "s");
}

std::vector<std::string> split(const std::string &text, char separator)
{
    std::vector<std::string> parts;
    size_t start = 0;
    for (;;) {
        const size_t end = text.find(separator, start);
        parts.push_back(text.substr(start, end - start));
        if (end == std::string::npos)
            return parts;
        start = end + 1;
    }
}

std::vector<double> parse_numbers(const std::string &text, size_t count, const std::string &what)
{
    std::vector<double> numbers;
    for (const std::string &part : split(text, ',')) {
        const std::optional<double> value = parse_number(part);
        if (!value)
            fail(Exit::usage, "%s: '%s' is not a number", what.c_str(), part.c_str());
        numbers.push_back(*value);
    }
    if (numbers.size() != count)
        fail(Exit::usage, "%s wants %zu numbers with commas between, '%s' has %zu", what.c_str(),
             count, text.c_str(), numbers.size());
    return numbers;
}

} // namespace cli
