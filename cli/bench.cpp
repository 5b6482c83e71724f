/* SPDX-License-Identifier: MIT */
/* `lcor bench`: the trade of speed against accuracy on this machine. */
#include "glb.h"
#include "gltf.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

namespace cli
{

namespace
{

double seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/* The shortest of a few runs: the others were disturbed. */
template <class Work> double best_seconds(int runs, Work work)
{
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i < runs; i++) {
        const double start = seconds();
        work();
        best = std::min(best, seconds() - start);
    }
    return best;
}

std::vector<double> patch_values(const Scene &scene, const lcor_solution *solution)
{
    std::vector<double> all;
    lcor_error error = {};
    for (size_t s = 0; s < scene.surfaces.size(); s++) {
        size_t n = 0;
        check(lcor_scene_patch_count(scene.scene.get(), s, &n, &error), error, Exit::failed,
              "bench");
        std::vector<double> values(n);
        check(
            lcor_solution_patches(solution, s, LCOR_VALUE_AVERAGE, values.data(), nullptr, &error),
            error, Exit::failed, "bench");
        all.insert(all.end(), values.begin(), values.end());
    }
    return all;
}

/* The paper's room at several tolerances, against the strictest of them. */
Json radiosity(Threads &threads)
{
    SceneOptions scene_options;
    const Scene scene = build_scene(parse_gltf(paper_room(50), "the paper's room", "", threads),
                                    scene_options, "the paper's room", threads);
    SolveOptions options;
    options.tolerance = 1e-4;
    const std::vector<double> reference = patch_values(scene, solve(scene, options, threads).get());
    double mean = 0.0;
    for (const double e : reference)
        mean += e / static_cast<double>(reference.size());
    Json rows = Json::array();
    for (const double tolerance : {0.1, 0.03, 0.01, 0.003, 0.001}) {
        options.tolerance = tolerance;
        SolutionPointer solution;
        std::vector<double> values;
        const double solving = best_seconds(3, [&] { solution = solve(scene, options, threads); });
        const double reading =
            best_seconds(3, [&] { values = patch_values(scene, solution.get()); });
        double squares = 0.0, worst = 0.0;
        for (size_t i = 0; i < values.size(); i++) {
            const double error = (values[i] - reference[i]) / std::max(reference[i], 0.02 * mean);
            squares += error * error;
            worst = std::max(worst, std::fabs(error));
        }
        const lcor_radiosity_report *const report = lcor_solution_report(solution.get());
        rows.push_back({{"tolerance", tolerance},
                        {"solve_ms", 1e3 * solving},
                        {"patches_ms", 1e3 * reading},
                        {"error_rms", std::sqrt(squares / static_cast<double>(values.size()))},
                        {"error_max", worst},
                        {"estimated_rms", report->error_rms},
                        {"bytes", report->bytes}});
    }
    return rows;
}

/* A row of pixels of every colour under light from dark to bright. */
Json correction()
{
    constexpr size_t WIDTH = 4096, ROWS = 64;
    static const struct {
        const char *name;
        lcor_sample type;
        size_t size;
    } depths[] = {{"8 bit", LCOR_U8, 1}, {"16 bit", LCOR_U16, 2}, {"float", LCOR_F32, 4}};
    std::vector<float> light(WIDTH);
    for (size_t x = 0; x < WIDTH; x++)
        light[x] = 0.1F + 2.0F * static_cast<float>(x) / static_cast<float>(WIDTH);
    Json rows = Json::array();
    for (const auto &kind : depths) {
        CorrectionOptions defaults;
        const lcor_colour colour = defaults.colour(kind.type == LCOR_F32);
        Device device;
        device.contrast = 23.4;
        lcor_plan_options options = defaults.plan(device, colour);
        options.r_mean = 0.5;
        options.rho = 0.5;
        options.in_type = options.out_type = kind.type;
        lcor_plan *plan = nullptr;
        lcor_error error = {};
        check(lcor_plan_new(&options, &plan, &error), error, Exit::failed, "bench");
        std::vector<uint8_t> pixels(3 * WIDTH * kind.size), out(pixels.size());
        uint32_t state = 1;
        for (size_t i = 0; i < 3 * WIDTH; i++) {
            state = state * 1664525U + 1013904223U;
            const float value = static_cast<float>(state >> 8) / 16777216.0F;
            if (kind.type == LCOR_F32)
                std::copy_n(reinterpret_cast<const uint8_t *>(&value), 4, &pixels[4 * i]);
            else
                std::fill_n(&pixels[kind.size * i], kind.size, static_cast<uint8_t>(state >> 24));
        }
        const double time = best_seconds(5, [&] {
            for (size_t y = 0; y < ROWS; y++)
                lcor_correct_row(plan, y, WIDTH, pixels.data(), light.data(), nullptr, out.data(),
                                 nullptr);
        });
        lcor_plan_free(plan);
        rows.push_back({{"samples", kind.name}, {"ns_per_pixel", 1e9 * time / (WIDTH * ROWS)}});
    }
    return rows;
}

void print_people(const Json &radiosity_rows, const Json &correction_rows)
{
    std::printf("Radiosity, the paper's room of 15,000 patches; errors against tolerance 0.0001:\n"
                "%10s %12s %12s %11s %11s %13s %9s\n",
                "tolerance", "solve ms", "patches ms", "rms %", "worst %", "estimated %", "MB");
    for (const Json &row : radiosity_rows)
        std::printf("%10s %12.2f %12.2f %11.3f %11.3f %13.3f %9.2f\n",
                    number_text(row["tolerance"]).c_str(), row["solve_ms"].get<double>(),
                    row["patches_ms"].get<double>(), 100.0 * row["error_rms"].get<double>(),
                    100.0 * row["error_max"].get<double>(),
                    100.0 * row["estimated_rms"].get<double>(), 1e-6 * row["bytes"].get<double>());
    std::printf("\nCorrection, one thread:\n%10s %12s\n", "samples", "ns a pixel");
    for (const Json &row : correction_rows)
        std::printf("%10s %12.1f\n", row["samples"].get<std::string>().c_str(),
                    row["ns_per_pixel"].get<double>());
}

} // namespace

Exit run_bench(const Arguments &arguments)
{
    int thread_count = 0;
    Options options("lcor bench [options]",
                    "Speed against accuracy on this machine; takes some seconds.");
    options.count("--threads", "N", thread_count, "default: as many as the machine has");
    if (!options.parse(arguments))
        return Exit::ok;
    if (!options.operands().empty())
        fail(Exit::usage, "'%s' is left over; lcor bench takes options only",
             options.operands()[0].c_str());
    Threads threads(thread_count);
    const Json radiosity_rows = radiosity(threads), correction_rows = correction();
    if (!json_wanted())
        print_people(radiosity_rows, correction_rows);
    print_json({{"threads", threads.count()},
                {"radiosity", radiosity_rows},
                {"correction", correction_rows}});
    return Exit::ok;
}

} // namespace cli
