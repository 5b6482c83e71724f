/* SPDX-License-Identifier: MIT */
#include "message.h"

#include <algorithm>
#include <cstdio>

namespace cli
{

namespace
{

double number_value(const std::string &name, const std::string &value)
{
    const std::optional<double> number = parse_number(value);
    if (!number)
        fail(Exit::usage, "%s wants a number such as 1.5, not '%s'", name.c_str(), value.c_str());
    return *number;
}

std::string joined(const std::vector<std::string> &words)
{
    std::string text;
    for (const std::string &word : words)
        text += (text.empty() ? "" : "|") + word;
    return text;
}

} // namespace

Options::Options(std::string usage, std::string about)
    : usage_(std::move(usage)), about_(std::move(about))
{
}

Options &Options::add(const char *name, const char *meta, const char *help,
                      std::function<void(const std::string &)> store)
{
    entries_.push_back({name, meta, help, std::move(store), false});
    return *this;
}

Options &Options::flag(const char *name, bool &out, const char *help)
{
    return add(name, "", help, [&out](const std::string &) { out = true; });
}

Options &Options::text(const char *name, const char *meta, std::string &out, const char *help)
{
    return add(name, meta, help, [&out, name](const std::string &value) {
        if (value.empty())
            fail(Exit::usage, "%s wants a value", name);
        out = value;
    });
}

Options &Options::list(const char *name, const char *meta, std::vector<std::string> &out,
                       const char *help)
{
    return add(name, meta, help, [&out](const std::string &value) { out.push_back(value); });
}

Options &Options::number(const char *name, const char *meta, double &out, const char *help)
{
    return add(name, meta, help,
               [&out, name](const std::string &value) { out = number_value(name, value); });
}

Options &Options::number(const char *name, const char *meta, std::optional<double> &out,
                         const char *help)
{
    return add(name, meta, help,
               [&out, name](const std::string &value) { out = number_value(name, value); });
}

Options &Options::count(const char *name, const char *meta, int &out, const char *help)
{
    return add(name, meta, help, [&out, name](const std::string &value) {
        const bool digits = !value.empty() && value.size() <= 7 &&
                            value.find_first_not_of("0123456789") == std::string::npos;
        const int number = digits ? std::stoi(value) : 0;
        if (number < 1 || number > 1000000)
            fail(Exit::usage, "%s wants a whole number from 1 to 1000000, not '%s'", name,
                 value.c_str());
        out = number;
    });
}

Options &Options::choice(const char *name, const std::vector<std::string> &words, int &out,
                         const char *help)
{
    const std::string meta = joined(words);
    return add(name, meta.c_str(), help, [&out, name, words, meta](const std::string &value) {
        const auto found = std::find(words.begin(), words.end(), value);
        if (found == words.end())
            fail(Exit::usage, "%s is one of %s, not '%s'", name, meta.c_str(), value.c_str());
        out = static_cast<int>(found - words.begin());
    });
}

Options &Options::custom(const char *name, const char *meta,
                         std::function<void(const std::string &)> store, const char *help)
{
    return add(name, meta, help, std::move(store));
}

Options::Entry *Options::find(const std::string &name)
{
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry &entry) { return entry.name == name; });
    return found == entries_.end() ? nullptr : &*found;
}

bool Options::given(const char *name) const
{
    return std::any_of(entries_.begin(), entries_.end(),
                       [&](const Entry &entry) { return entry.name == name && entry.given; });
}

const std::string &Options::operand(const char *what) const
{
    if (operands_.empty())
        fail(Exit::usage, "%s is missing; usage: %s", what, usage_.c_str());
    if (operands_.size() > 1)
        fail(Exit::usage, "'%s' is left over; usage: %s", operands_[1].c_str(), usage_.c_str());
    return operands_[0];
}

bool Options::parse(const Arguments &arguments)
{
    for (size_t i = 0; i < arguments.size(); i++) {
        const std::string &argument = arguments[i];
        if (argument == "--") {
            operands_.insert(operands_.end(), arguments.begin() + static_cast<long>(i) + 1,
                             arguments.end());
            break;
        }
        if (argument.size() < 2 || argument[0] != '-') {
            operands_.push_back(argument);
            continue;
        }
        if (argument == "--json" || argument == "--quiet")
            continue; /* main() has seen them */
        if (argument == "--help" || argument == "-h") {
            print_help();
            return false;
        }
        if (argument == "--version") {
            std::printf("lcor %s\n", lcor_version());
            return false;
        }
        const size_t equals =
            argument.compare(0, 2, "--") == 0 ? argument.find('=') : argument.npos;
        const std::string name = argument.substr(0, equals);
        Entry *const entry = find(name);
        if (!entry)
            fail(Exit::usage, "unknown option '%s'; --help lists them", name.c_str());
        entry->given = true;
        if (entry->meta.empty()) {
            if (equals != argument.npos)
                fail(Exit::usage, "%s takes no value", name.c_str());
            entry->store("");
        } else if (equals != argument.npos) {
            entry->store(argument.substr(equals + 1));
        } else if (++i < arguments.size()) {
            entry->store(arguments[i]);
        } else {
            fail(Exit::usage, "%s wants a value", name.c_str());
        }
    }
    return true;
}

void Options::print_help() const
{
    std::printf("usage: %s\n\n%s\n\n", usage_.c_str(), about_.c_str());
    const auto line = [](const std::string &left, const std::string &help) {
        if (left.size() <= 26)
            std::printf("  %-26s %s\n", left.c_str(), help.c_str());
        else
            std::printf("  %s\n  %-26s %s\n", left.c_str(), "", help.c_str());
    };
    for (const Entry &entry : entries_)
        line(entry.meta.empty() ? entry.name : entry.name + " " + entry.meta, entry.help);
    line("--json", "one JSON document on stdout; messages stay on stderr");
    line("--quiet", "no messages but warnings and errors");
    line("--help, --version", "this text; the version");
}

} // namespace cli
