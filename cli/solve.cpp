/* SPDX-License-Identifier: MIT */
#include "scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cli
{

constexpr const char *engine_names[] = {"auto", "links", "gather", "paths"};

void SolveOptions::declare(Options &options)
{
    options
        .number("--tolerance", "T", tolerance,
                "relative error of illuminance to reach, default 0.01")
        .choice("--norm", {"rms", "max"}, norm,
                "over patches: root mean square (default) or largest; pictures by links: both")
        .choice("--engine", {"auto", "links", "gather", "paths"}, engine, "how radiosity is solved")
        .number("--max-seconds", "S", max_seconds,
                "stop solving after S seconds with what there is");
}

static SolutionPointer run(const Scene &scene, const SolveOptions &options, Threads &threads)
{
    if (!(options.tolerance >= 1e-5 && options.tolerance <= 1.0))
        fail(Exit::usage, "--tolerance must lie in 0.00001..1, not %s",
             number_text(options.tolerance).c_str());
    if (options.max_seconds < 0.0)
        fail(Exit::usage, "--max-seconds must not be negative");
    Progress progress("radiosity");
    lcor_radiosity_options settings = {};
    settings.struct_size = sizeof settings;
    settings.tolerance = options.tolerance;
    settings.norm = static_cast<lcor_norm>(std::max(options.norm, 0));
    settings.engine = static_cast<lcor_engine>(options.engine);
    settings.channels = scene.channels;
    std::copy_n(scene.colour.to_xyz + 3, 3, settings.luminance);
    settings.max_seconds = options.max_seconds;
    settings.points = options.points;
    settings.parallel = threads.parallel();
    settings.progress = progress.callback();
    lcor_solution *solution = nullptr;
    lcor_error error = {};
    check(lcor_radiosity_solve(scene.scene.get(), &settings, &solution, &error), error, Exit::input,
          "radiosity");
    return SolutionPointer(solution);
}

SolutionPointer solve(const Scene &scene, const SolveOptions &options, Threads &threads)
{
    SolutionPointer solution = run(scene, options, threads);
    const lcor_radiosity_report *const report = lcor_solution_report(solution.get());
    if (!report->converged)
        warn("radiosity stopped at an estimated error of %s (rms), %s was asked for",
             short_text(report->error_rms).c_str(), number_text(options.tolerance).c_str());
    return solution;
}

SolutionPointer solve_for_picture(const Scene &scene, const SolveOptions &options, Threads &threads)
{
    SolutionPointer solution = solve(scene, options, threads);
    const lcor_radiosity_report *const report = lcor_solution_report(solution.get());
    const double left = options.max_seconds - report->seconds;
    if (options.norm >= 0 || report->engine != LCOR_ENGINE_LINKS || !report->converged ||
        (options.max_seconds > 0.0 && left <= 0.0))
        return solution;
    SolveOptions worst = options;
    worst.norm = LCOR_NORM_MAX;
    worst.max_seconds = std::max(left, 0.0);
    SolutionPointer even = run(scene, worst, threads);
    return lcor_solution_report(even.get())->converged ? std::move(even) : std::move(solution);
}

void say_engine(const lcor_solution *solution)
{
    const lcor_radiosity_report *const report = lcor_solution_report(solution);
    const char *const name = engine_names[report->engine];
    const std::string paths = std::isfinite(report->paths_seconds)
                                  ? ", paths " + short_text(report->paths_seconds)
                                  : std::string();
    if (report->engine_reason == LCOR_REASON_COST)
        say("radiosity by engine %s; estimated seconds: links %s, gather %s%s", name,
            short_text(report->links_seconds).c_str(), short_text(report->gather_seconds).c_str(),
            paths.c_str());
    else
        say("radiosity by engine %s, %s", name, lcor_reason_text(report->engine_reason));
}

Json report_json(const Scene &scene, const lcor_solution *solution)
{
    const lcor_radiosity_report *const report = lcor_solution_report(solution);
    return {{"error_rms", report->error_rms},
            {"error_max", report->error_max},
            {"energy_defect", report->energy_defect},
            {"converged", report->converged != 0},
            {"iterations", report->iterations},
            {"channels", report->channels},
            {"engine", engine_names[report->engine]},
            {"links", report->links},
            {"elements", report->elements},
            {"rays", report->rays},
            {"bytes", report->bytes},
            {"seconds", report->seconds},
            {"models", report->models},
            {"engine_reason", lcor_reason_text(report->engine_reason)},
            {"estimated_seconds",
             {{"links", report->links_seconds},
              {"gather", report->gather_seconds},
              {"paths", report->paths_seconds}}},
            {"visibility_reason", lcor_reason_text(report->visibility_reason)},
            {"channels_reason", scene.channels_reason},
            {"pairs_apart", report->pairs_apart},
            {"pairs_open", report->pairs_open},
            {"pairs_tested", report->pairs_tested},
            {"surfaces_merged", report->surfaces_merged},
            {"merged_into", report->merged_into},
            {"surfaces", scene.surfaces.size()},
            {"triangles", scene.triangles},
            {"triangles_without_area", scene.dropped},
            {"lights", scene.lights},
            {"emitters", scene.emitters}};
}

} // namespace cli
