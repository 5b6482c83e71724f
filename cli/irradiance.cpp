/* SPDX-License-Identifier: MIT */
/* `lcor irradiance`: illuminance at points or on patches, as CSV. */
#include "scene.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

constexpr uint64_t table_limit = uint64_t(1) << 30;
/* What is added to a table: the first two, or all with three channels. */
const char *const value_names = "E_direct,E_total,E_red,E_green,E_blue";

struct Points {
    std::vector<std::string> lines; /* as read, for the output's first columns */
    std::vector<double> position, normal;
    std::string header;
};

std::vector<std::string> lines_of(const std::string &text)
{
    std::vector<std::string> lines = split(text, '\n');
    for (std::string &line : lines)
        if (!line.empty() && line.back() == '\r')
            line.pop_back();
    while (!lines.empty() && lines.back().empty())
        lines.pop_back();
    return lines;
}

std::string trimmed(const std::string &text)
{
    const size_t first = text.find_first_not_of(" \t\""), last = text.find_last_not_of(" \t\"");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/* The cells of a line; commas between quotation marks part none. */
std::vector<std::string> cells_of(const std::string &line)
{
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
        quoted = quoted != (c == '"');
        if (c == ',' && !quoted)
            cells.emplace_back();
        else
            cells.back() += c;
    }
    return cells;
}

/* Where columns x, y, z, nx, ny, nz stand; without a header line they are the first six. */
std::vector<size_t> columns_of(const std::string &header, const std::string &path)
{
    const char *const wanted[] = {"x", "y", "z", "nx", "ny", "nz"};
    const std::vector<std::string> names = cells_of(header);
    std::vector<size_t> columns;
    for (const char *name : wanted) {
        const auto found = std::find_if(names.begin(), names.end(),
                                        [&](const std::string &n) { return trimmed(n) == name; });
        if (found == names.end())
            fail(Exit::input, "'%s' has no column %s; its first line must name x,y,z,nx,ny,nz",
                 path.c_str(), name);
        columns.push_back(static_cast<size_t>(found - names.begin()));
    }
    return columns;
}

/* A line without the columns marked. */
std::string without(const std::string &line, const std::vector<bool> &dropped)
{
    const std::vector<std::string> cells = cells_of(line);
    std::string text;
    bool first = true;
    for (size_t i = 0; i < cells.size(); i++) {
        if (i < dropped.size() && dropped[i])
            continue;
        text += (first ? "" : ",") + cells[i];
        first = false;
    }
    return text;
}

/* Results of an earlier run give way to those to come: no two columns have one name. */
void drop_results(Points &points)
{
    const std::vector<std::string> results = split(value_names, ',');
    std::vector<bool> dropped;
    for (const std::string &name : cells_of(points.header))
        dropped.push_back(std::find(results.begin(), results.end(), trimmed(name)) !=
                          results.end());
    if (std::find(dropped.begin(), dropped.end(), true) == dropped.end())
        return;
    points.header = without(points.header, dropped);
    for (std::string &line : points.lines)
        line = without(line, dropped);
}

Points read_points(const std::string &path)
{
    std::string text = read_file(path, table_limit);
    if (text.compare(0, 3, "\xef\xbb\xbf") == 0)
        text.erase(0, 3);
    Points points;
    points.lines = lines_of(text);
    if (points.lines.empty())
        fail(Exit::input, "'%s' is empty; it should hold x,y,z,nx,ny,nz", path.c_str());
    std::vector<size_t> columns = {0, 1, 2, 3, 4, 5};
    if (!parse_number(trimmed(cells_of(points.lines[0])[0]))) {
        points.header = points.lines[0];
        columns = columns_of(points.header, path);
        points.lines.erase(points.lines.begin());
    }
    const size_t first = points.header.empty() ? 1 : 2;
    const size_t width = points.header.empty() ? 6 : cells_of(points.header).size();
    for (size_t i = 0; i < points.lines.size(); i++) {
        const std::vector<std::string> cells = cells_of(points.lines[i]);
        if (cells.size() != width)
            fail(Exit::input, "'%s' line %zu: %s instead of %zu", path.c_str(), i + first,
                 counted(cells.size(), "column").c_str(), width);
        double n[6];
        for (size_t k = 0; k < 6; k++) {
            const std::optional<double> value = parse_number(trimmed(cells[columns[k]]));
            if (!value)
                fail(Exit::input, "'%s' line %zu: no number in column %zu", path.c_str(), i + first,
                     columns[k] + 1);
            n[k] = *value;
        }
        const double length = std::hypot(n[3], n[4], n[5]);
        if (!(length > 0.0))
            fail(Exit::input, "'%s' line %zu: the normal has no length", path.c_str(), i + first);
        points.position.insert(points.position.end(), n, n + 3);
        for (size_t k = 3; k < 6; k++)
            points.normal.push_back(n[k] / length);
    }
    drop_results(points);
    return points;
}

std::string values_text(const Scene &scene, const double *direct, const double *total, int channels)
{
    std::string text = "," + number_text(scene.luminance(direct, channels)) + "," +
                       number_text(scene.luminance(total, channels));
    for (int c = 0; channels == 3 && c < 3; c++)
        text += "," + number_text(total[c]);
    return text;
}

std::string value_header(int channels)
{
    const std::string names = value_names;
    return "," + names.substr(0, channels == 3 ? names.npos : names.find(",E_red")) + "\n";
}

std::string points_table(const Scene &scene, const lcor_solution *solution, const Points &points)
{
    const int channels = lcor_solution_report(solution)->channels;
    const size_t n = points.lines.size(), step = static_cast<size_t>(channels);
    std::vector<double> direct(n * step), total(n * step);
    lcor_error error = {};
    check(lcor_solution_at(solution, n, points.position.data(), points.normal.data(), total.data(),
                           direct.data(), &error),
          error, Exit::input, "irradiance");
    std::string text =
        (points.header.empty() ? "x,y,z,nx,ny,nz" : points.header) + value_header(channels);
    for (size_t i = 0; i < n; i++)
        text += points.lines[i] +
                values_text(scene, &direct[i * step], &total[i * step], channels) + "\n";
    return text;
}

/* Patch [i, j] of a quad stands at i * nv + j; a triangle's row i holds 2 (n - i) - 1. */
std::string patches_table(const Scene &scene, const lcor_solution *solution, size_t *count)
{
    const int channels = lcor_solution_report(solution)->channels;
    const size_t step = static_cast<size_t>(channels);
    lcor_error error = {};
    std::string text = "surface,i,j,x,y,z,nx,ny,nz,area" + value_header(channels);
    *count = 0;
    for (size_t s = 0; s < scene.surfaces.size(); s++) {
        size_t n = 0;
        check(lcor_scene_patch_count(scene.scene.get(), s, &n, &error), error, Exit::failed,
              "patches");
        std::vector<double> centre(3 * n), area(n), direct(n * step), total(n * step);
        double normal[3];
        check(lcor_scene_patch_geometry(scene.scene.get(), s, centre.data(), area.data(), normal,
                                        &error),
              error, Exit::failed, "patches");
        check(lcor_solution_patches(solution, s, LCOR_VALUE_AVERAGE, total.data(), direct.data(),
                                    &error),
              error, Exit::failed, "patches");
        const SurfaceInfo &info = scene.surfaces[s];
        size_t i = 0, j = 0;
        for (size_t p = 0; p < n; p++) {
            text += std::to_string(s) + "," + std::to_string(i) + "," + std::to_string(j);
            for (size_t k = 0; k < 3; k++)
                text += "," + number_text(centre[3 * p + k]);
            for (const double x : normal)
                text += "," + number_text(x);
            text += "," + number_text(area[p]);
            text += values_text(scene, &direct[p * step], &total[p * step], channels) + "\n";
            const size_t row = info.quad ? info.patches[1] : 2 * (info.patches[0] - i) - 1;
            if (++j == row) {
                i++;
                j = 0;
            }
        }
        *count += n;
    }
    return text;
}

} // namespace

Exit run_irradiance(const Arguments &arguments)
{
    SceneOptions scene_options;
    SolveOptions solve_options;
    std::string points_path, patches_path, output, report_path;
    int thread_count = 0;
    Options options(
        "lcor irradiance SCENE --points P.csv -o E.csv [options]\n"
        "       lcor irradiance SCENE --patches E.csv [options]",
        "Illuminance (lux, for candela and metres) at points with normals, or the mean over\n"
        "every patch. E_direct is the light of lamps without area, E_total adds emitting\n"
        "surfaces and interreflection.");
    options.text("--points", "P.csv", points_path, "columns x,y,z,nx,ny,nz; others are kept")
        .text("-o", "E.csv", output, "where the points go, with E_direct,E_total added")
        .custom(
            "--patches", "E.csv|N",
            [&](const std::string &value) {
                const std::optional<double> n = parse_number(value);
                if (!n)
                    patches_path = value;
                else if (*n >= 1.0 && *n <= 4096.0 && *n == std::floor(*n))
                    scene_options.patches = static_cast<int>(*n);
                else
                    fail(Exit::usage,
                         "--patches wants a file for the patches, or their number 1..4096 along an "
                         "edge, not '%s'",
                         value.c_str());
            },
            "write every patch to E.csv; N sets N x N patches a surface (both may be given)")
        .text("--report", "R.json", report_path, "write the solver's report");
    scene_options.declare_light(options);
    solve_options.declare(options);
    options.count("--threads", "N", thread_count, "default: as many as the machine has");
    if (!options.parse(arguments))
        return Exit::ok;
    const std::string scene_path = options.operand("a scene");
    if (points_path.empty() && patches_path.empty())
        fail(Exit::usage, "where? give --points P.csv -o E.csv, or --patches E.csv");
    if (!points_path.empty() && output.empty())
        fail(Exit::usage, "--points needs -o E.csv for the result");
    for (const std::string &path : {output, patches_path, report_path})
        if (!path.empty())
            check_output(path);
    Points points;
    if (!points_path.empty())
        points = read_points(points_path);
    if (patches_path.empty())
        solve_options.points = points.lines.size();
    Threads threads(thread_count);
    const Scene scene = load_scene(scene_path, scene_options, threads);
    const SolutionPointer solution = solve(scene, solve_options, threads);
    Json report = report_json(scene, solution.get());
    if (!points_path.empty()) {
        write_file(output, points_table(scene, solution.get(), points));
        report["points"] = points.lines.size();
        say("%s: illuminance at %s", output.c_str(), counted(points.lines.size(), "point").c_str());
    }
    if (!patches_path.empty()) {
        size_t count = 0;
        write_file(patches_path, patches_table(scene, solution.get(), &count));
        report["patches"] = count;
        say("%s: illuminance of %s", patches_path.c_str(), counted(count, "patch").c_str());
    }
    say_engine(solution.get());
    if (!report_path.empty())
        write_file(report_path, report.dump(2) + "\n");
    print_json(report);
    return Exit::ok;
}

} // namespace cli
