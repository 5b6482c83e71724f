/* SPDX-License-Identifier: MIT */
/* `lcor render`: a view of a scene, corrected for a device. */
#include "render.h"
#include "aov.h"
#include "stream.h"

#include <cstdio>
#include <sys/stat.h>

namespace cli
{

namespace
{

/* Of a pixel, at least: its light and where estimates of it stand. */
constexpr double picture_bytes = 12.0;
constexpr uint64_t adaptation_limit = uint64_t(1) << 16;

struct RenderOptions {
    std::string scene, output, camera, adaptation;
    PictureSize size;
    std::optional<Gaze> gaze;
    int mean_over = 0; /* index into {"view", "surfaces"} */
    int threads = 0;
    std::vector<std::string> aov_texts;
    std::vector<AovRequest> aovs;
    SceneOptions scene_options;
    SolveOptions solve;
    DeviceOptions device;
    CorrectionOptions correction;
    PictureFormat format;
};

void declare(Options &options, RenderOptions &render)
{
    options.text("-o", "FILE", render.output, "the picture: .png, .tif, .jpg or .exr")
        .text("--camera", "NAME", render.camera,
              "one of the scene's; default its first, or one that sees all")
        .custom(
            "--size", "WxH",
            [&](const std::string &text) { render.size = PictureSize::parse(text); },
            "pixels; default 1280 wide in the camera's shape");
    render.format.declare(options);
    render.device.declare(options);
    render.correction.declare(options, false);
    options
        .text("--adaptation", "FILE", render.adaptation,
              "take the mean of r from FILE, or write it there if FILE does not exist yet")
        .choice("--mean-over", {"view", "surfaces"}, render.mean_over,
                "mean of r over the displayed pixels (default) or over all surfaces")
        .custom(
            "--gaze", "X,Y,DEGREES",
            [&](const std::string &text) {
                const std::vector<double> n = parse_numbers(text, 3, "--gaze");
                if (!(n[0] >= 0.0 && n[0] <= 1.0 && n[1] >= 0.0 && n[1] <= 1.0 && n[2] > 0.0))
                    fail(Exit::usage,
                         "--gaze %s: X and Y are parts of the picture, 0..1 from its upper left "
                         "corner, and DEGREES is more than 0",
                         text.c_str());
                render.gaze = Gaze{n[0], n[1], n[2]};
            },
            "weigh the mean towards a point of the picture; half weight DEGREES/2 away")
        .list("--aov", "NAME=FILE", render.aov_texts,
              "also write an auxiliary picture; `--aov list` names them");
    render.solve.declare(options);
    render.scene_options.declare(options);
    options.count("--threads", "N", render.threads, "default: as many as the machine has");
}

/* `r_mean NUMBER`; other lines and # comments are for people. */
double read_adaptation(const std::string &path)
{
    for (const std::string &line : split(read_file(path, adaptation_limit), '\n')) {
        const std::vector<std::string> words = split(line.substr(0, line.find('\r')), ' ');
        if (words.size() != 2 || words[0] != "r_mean")
            continue;
        const std::optional<double> value = parse_number(words[1]);
        if (!value || !(*value >= 0.0))
            fail(Exit::input, "'%s': r_mean must be a number >= 0, not '%s'", path.c_str(),
                 words[1].c_str());
        return *value;
    }
    fail(Exit::input, "'%s' has no line `r_mean NUMBER`; delete it to have it written anew",
         path.c_str());
}

bool exists(const std::string &path)
{
    struct stat info;
    return stat(path.c_str(), &info) == 0;
}

bool shows_surface(const Picture &picture)
{
    size_t count = 0;
    for (size_t y = 0; y < picture.height() && count == 0; y++)
        lcor_view_row(picture.view(), y, &count);
    return count > 0;
}

double find_mean(const RenderOptions &render, const Device &device, const Picture &picture,
                 const lcor_solution *solution, const std::optional<double> &shared)
{
    if (render.correction.given_mean())
        return *render.correction.given_mean();
    if (shared)
        return *shared;
    if (render.mean_over == 0 && !shows_surface(picture))
        fail(Exit::input,
             "scene '%s': its camera sees no surface, so there is nothing to adapt to; choose "
             "another with --camera, or --mean-over surfaces",
             render.scene.c_str());
    const double r_mean =
        render.mean_over == 1
            ? mean_over_surfaces(picture.scene(), solution, render.correction.mean_method())
            : mean_over_view(picture, render.correction, device, render.gaze);
    if (!(r_mean > 0.0))
        warn("nothing that is seen is lit: the picture comes out black");
    if (!render.adaptation.empty()) {
        write_file(render.adaptation,
                   "# adaptation of lcor render: mean of illuminance times reflectance\n"
                   "r_mean " +
                       number_text(r_mean) + "\n");
        say("%s: adaptation written, r_mean %s", render.adaptation.c_str(),
            number_text(r_mean).c_str());
    }
    return r_mean;
}

void check_options(const RenderOptions &render)
{
    if (render.output.empty())
        fail(Exit::usage, "where to? give -o PICTURE");
    render.format.type(render.output);
    check_picture_path(render.output);
    for (const AovRequest &aov : render.aovs)
        check_picture_path(aov.path);
    if (render.mean_over == 1 && render.gaze)
        fail(Exit::usage, "--gaze weighs displayed pixels; it cannot go with --mean-over surfaces");
}

Json statistics(const lcor_row_stats &stats)
{
    return {{"pixels", stats.pixels},
            {"clipped_low", stats.clipped_low},
            {"clipped_high", stats.clipped_high},
            {"out_of_gamut", stats.out_of_gamut},
            {"non_finite", stats.non_finite}};
}

void render_scene(const RenderOptions &render, const std::string &command)
{
    Threads threads(render.threads);
    const Device device = render.device.load(!render.correction.conventional);
    std::optional<double> shared; /* read before the long work, so that a bad file costs none */
    if (!render.adaptation.empty() && exists(render.adaptation))
        shared = read_adaptation(render.adaptation);
    else if (!render.adaptation.empty())
        check_output(render.adaptation);
    const Scene scene = load_scene(render.scene, render.scene_options, threads);
    const SceneCamera camera = choose_camera(scene, render.camera);
    const lcor_camera sized = sized_camera(camera, render.size);
    check_memory(
        picture_bytes * static_cast<double>(sized.size_x) * static_cast<double>(sized.size_y),
        format("a picture of %zu x %zu", sized.size_x, sized.size_y), "give a smaller --size");
    const SolutionPointer solution = solve_for_picture(scene, render.solve, threads);
    const Picture picture(scene, solution.get(), sized, 0.1 * render.solve.tolerance, threads);
    const double r_mean = find_mean(render, device, picture, solution.get(), shared);
    const PlanPointer plan = picture_plan(render.correction, device, r_mean);
    const Developer developer(picture, plan.get(), render.correction.conventional, r_mean);
    const lcor_radiosity_report *const report = lcor_solution_report(solution.get());
    Provenance provenance;
    provenance.command = command;
    provenance.inputs = {render.scene};
    if (!device.profile.empty())
        provenance.inputs.push_back(device.profile);
    provenance.details = {{"method", render.correction.conventional ? "conventional" : "corrected"},
                          {"contrast", device.contrast},
                          {"r_mean", r_mean},
                          {"tolerance", render.solve.tolerance},
                          {"error_rms", report->error_rms}};
    const lcor_row_stats stats = write_picture(render.output, picture, developer, render.format,
                                               render.correction, device, provenance);
    for (const AovRequest &aov : render.aovs)
        write_aov(aov, {picture, developer, render.correction, device, r_mean}, provenance);
    say("%s: %zu x %zu, %s", render.output.c_str(), picture.width(), picture.height(),
        render.correction.conventional
            ? "conventional method"
            : ("corrected for contrast " + short_text(device.contrast)).c_str());
    say_engine(solution.get());
    lcor_field_report field;
    lcor_field_get_report(picture.field(), &field);
    Json document = {{"output", render.output},
                     {"width", picture.width()},
                     {"height", picture.height()},
                     {"camera", camera.name}};
    document.update(provenance.details);
    document["field"] = {{"error", field.error}, {"samples", field.samples}};
    document["statistics"] = statistics(stats);
    document["radiosity"] = report_json(scene, solution.get());
    print_json(document);
}

} // namespace

Exit run_render(const Arguments &arguments)
{
    RenderOptions render;
    Options options(
        "lcor render SCENE -o PICTURE (--profile FILE | --contrast C) [options]",
        "What a camera sees of a scene (.gltf, .glb, .obj), lit by radiosity, with its lightness\n"
        "corrected for a device of limited contrast; or by the conventional method, to compare.");
    declare(options, render);
    if (!options.parse(arguments))
        return Exit::ok;
    if (render.aov_texts == std::vector<std::string>{"list"}) {
        std::fputs(aov_list().c_str(), stdout);
        return Exit::ok;
    }
    render.aovs = parse_aovs(render.aov_texts);
    render.scene = options.operand("a scene");
    render.correction.space = render.scene_options.space;
    check_options(render);
    render_scene(render, command_line("render", arguments));
    return Exit::ok;
}

} // namespace cli
