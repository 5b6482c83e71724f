/* SPDX-License-Identifier: MIT */
#include "cli.h"
#include "message.h"

#include <cstdio>
#include <exception>
#include <new>

namespace
{

const cli::Command commands[] = {
    {"correct", "correct a picture's lightness for a device and an illuminance", cli::run_correct},
    {"render", "what a camera sees of a scene, corrected for a device", cli::run_render},
    {"irradiance", "illuminance of a scene at points or on patches", cli::run_irradiance},
    {"room", "write the paper's room as a glTF scene", cli::run_room},
    {"paper", "the paper's experiments, repeated and measured", cli::run_paper},
    {"info", "what a profile, scene or picture holds", cli::run_info},
    {"bench", "speed against accuracy on this machine", cli::run_bench},
};

void print_help()
{
    std::printf("usage: lcor COMMAND [options]\n\n"
                "Lightness correction for photorealistic rendering on devices of limited "
                "contrast.\n\n");
    for (const cli::Command &command : commands)
        std::printf("  %-11s %s\n", command.name, command.summary);
    std::printf("\n`lcor COMMAND --help` lists a command's options; lcor(1) is the manual.\n"
                "Everywhere: --json (one document on stdout), --quiet, --help, --version.\n");
}

/* Messages obey --json and --quiet wherever they stand, an unknown command's too. */
void choose_messages(const cli::Arguments &arguments)
{
    for (const std::string &argument : arguments) {
        if (argument == "--")
            break;
        if (argument == "--json")
            cli::set_json(true);
        if (argument == "--quiet")
            cli::set_quiet(true);
    }
}

cli::Exit dispatch(cli::Arguments arguments)
{
    choose_messages(arguments);
    while (!arguments.empty() && (arguments[0] == "--json" || arguments[0] == "--quiet"))
        arguments.erase(arguments.begin());
    const std::string first = arguments.empty() ? "" : arguments[0];
    if (first == "--help" || first == "-h" || first == "help") {
        print_help();
        return cli::Exit::ok;
    }
    if (first == "--version") {
        std::printf("lcor %s\n", lcor_version());
        return cli::Exit::ok;
    }
    for (const cli::Command &command : commands)
        if (first == command.name)
            return command.run(cli::Arguments(arguments.begin() + 1, arguments.end()));
    if (first.empty())
        cli::fail(cli::Exit::usage, "which command? `lcor --help` lists them");
    cli::fail(cli::Exit::usage, "unknown %s '%s'; `lcor --help` lists the commands",
              first[0] == '-' ? "option" : "command", first.c_str());
}

cli::Exit report(cli::Exit code, const char *text)
{
    std::fprintf(stderr, "lcor: %s\n", text);
    cli::print_json({{"error", {{"code", static_cast<int>(code)}, {"text", text}}}});
    return code;
}

cli::Exit guarded(const cli::Arguments &arguments)
{
    try {
        return dispatch(arguments);
    } catch (const cli::Error &error) {
        return report(error.code, error.what());
    } catch (const std::bad_alloc &) {
        return report(cli::Exit::failed, "out of memory");
    } catch (const std::exception &error) {
        return report(cli::Exit::failed, error.what());
    }
}

} // namespace

int main(int argc, char **argv)
{
    cli::handle_signals();
    cli::Exit code = guarded(cli::Arguments(argv + (argc > 0 ? 1 : 0), argv + argc));
    if (std::fflush(stdout) != 0 && code == cli::Exit::ok)
        code = report(cli::Exit::failed, "cannot write to stdout");
    return static_cast<int>(code);
}
