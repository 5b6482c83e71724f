/* SPDX-License-Identifier: MIT */
#include "develop.h"

#include <algorithm>
#include <cmath>
#include <mutex>

namespace cli
{

namespace
{

/* Doubt about the mean that a further pass removes; 8 bits cannot show it. */
constexpr double view_mean_doubt = 1e-5;
constexpr int most_passes = 4;

/* Weights of a row's samples: coverage times gaze. */
class Weights
{
  public:
    Weights(const Picture &picture, const std::optional<Gaze> &gaze)
        : picture_(picture), gaze_(gaze)
    {
        if (gaze_) {
            double origin[3];
            lcor_camera_ray(&picture.camera(), gaze_->x * static_cast<double>(picture.width()),
                            gaze_->y * static_cast<double>(picture.height()), origin, towards_);
        }
    }

    void row(size_t y, std::vector<double> &out) const
    {
        size_t count;
        const lcor_span *const spans = lcor_view_row(picture_.view(), y, &count);
        out.clear();
        for (size_t i = 0; i < count; i++)
            for (size_t x = spans[i].x0; x < spans[i].x1; x++)
                out.push_back(static_cast<double>(spans[i].coverage) * (gaze_ ? at(x, y) : 1.0));
    }

  private:
    double at(size_t x, size_t y) const
    {
        double origin[3], direction[3], cosine = 0.0;
        lcor_camera_ray(&picture_.camera(), static_cast<double>(x) + 0.5,
                        static_cast<double>(y) + 0.5, origin, direction);
        for (size_t k = 0; k < 3; k++)
            cosine += direction[k] * towards_[k];
        const double part =
            std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / pi / (0.5 * gaze_->degrees);
        return std::exp2(-part * part);
    }

    const Picture &picture_;
    const std::optional<Gaze> gaze_;
    double towards_[3];
};

/* Runs `add` on copies of `mean` until its doubt is small; `add` merges them into `mean`. */
double settled_mean(lcor_mean_method method, const std::function<void(lcor_mean &mean)> &add)
{
    auto mean = std::make_unique<lcor_mean>();
    lcor_mean_init(mean.get());
    add(*mean);
    for (int pass = 1; pass < most_passes && lcor_mean_error(mean.get(), method) > view_mean_doubt;
         pass++) {
        lcor_mean_refine(mean.get(), method);
        add(*mean);
    }
    double r_mean = 0.0;
    lcor_error error = {};
    check(lcor_mean_get(mean.get(), method, &r_mean, &error), error, Exit::input,
          "the picture shows no surface, so there is nothing to adapt to");
    return r_mean;
}

} // namespace

double mean_over_view(const Picture &picture, const CorrectionOptions &correction,
                      const Device &device, const std::optional<Gaze> &gaze)
{
    const Weights weights(picture, gaze);
    const PlanPointer plan = picture_plan(correction, device, 1.0);
    const bool texels = correction.reading == LCOR_READING_TEXEL;
    return settled_mean(correction.mean_method(), [&](lcor_mean &mean) {
        const lcor_mean start = mean;
        bool first = true;
        std::mutex mutex;
        picture.each_band(0, picture.height(), [&](size_t y0, size_t y1) {
            lcor_mean part = start;
            Picture::Row row;
            std::vector<double> weight, r;
            for (size_t y = y0; y < y1; y++) {
                picture.row(y, texels, row);
                weights.row(y, weight);
                r.resize(weight.size());
                lcor_plan_reflectance_row(plan.get(), r.size(), row.rgb.data(),
                                          row.illuminance.data(), row.rho.data(), r.data());
                lcor_mean_add(&part, r.size(), r.data(), weight.data());
            }
            const std::lock_guard<std::mutex> lock(mutex);
            lcor_error error = {};
            if (first)
                mean = part;
            else
                check(lcor_mean_merge(&mean, &part, &error), error, Exit::failed, "mean of r");
            first = false;
        });
    });
}

double mean_over_surfaces(const Scene &scene, const lcor_solution *solution,
                          lcor_mean_method method)
{
    const size_t channels = static_cast<size_t>(lcor_solution_report(solution)->channels);
    std::vector<double> r, areas; /* relative to the largest surface */
    double largest = 0.0;
    for (const SurfaceInfo &surface : scene.surfaces)
        largest = std::max(largest, surface.area);
    lcor_error error = {};
    for (size_t s = 0; s < scene.surfaces.size(); s++) {
        size_t n = 0;
        check(lcor_scene_patch_count(scene.scene.get(), s, &n, &error), error, Exit::failed,
              "patches");
        std::vector<double> centres(3 * n), area(n), total(n * channels);
        double normal[3];
        check(lcor_scene_patch_geometry(scene.scene.get(), s, centres.data(), area.data(), normal,
                                        &error),
              error, Exit::failed, "patches");
        check(lcor_solution_patches(solution, s, LCOR_VALUE_AVERAGE, total.data(), nullptr, &error),
              error, Exit::failed, "patches");
        for (size_t i = 0; i < n; i++) {
            r.push_back(scene.surfaces[s].reflectance *
                        scene.luminance(&total[i * channels], static_cast<int>(channels)));
            areas.push_back(area[i] / largest);
        }
    }
    double r_mean = 0.0;
    check(lcor_geometric_mean(r.size(), r.data(), areas.data(), method, &r_mean, &error), error,
          Exit::input, "mean over the surfaces");
    return r_mean;
}

PlanPointer picture_plan(const CorrectionOptions &correction, const Device &device, double r_mean)
{
    CorrectionOptions linear = correction;
    linear.transfer = "linear";
    const lcor_colour colour = linear.colour(true);
    lcor_plan_options options = linear.plan(device, colour);
    options.r_mean = r_mean;
    options.in_type = options.out_type = LCOR_F32;
    options.tone_curve = nullptr; /* edges are mixed in linear light first */
    options.tone_size = 0;
    lcor_plan *plan = nullptr;
    lcor_error error = {};
    check(lcor_plan_new(&options, &plan, &error), error, Exit::usage, "correction");
    return PlanPointer(plan);
}

Developer::Developer(const Picture &picture, const lcor_plan *plan, bool conventional,
                     double r_mean)
    : picture_(picture), plan_(plan), conventional_(conventional), r_mean_(r_mean)
{
}

void Developer::samples(size_t y, Picture::Row &row, lcor_row_stats *stats) const
{
    if (conventional_)
        for (float &e : row.illuminance)
            e = r_mean_ > 0.0 ? static_cast<float>(static_cast<double>(e) / r_mean_) : 0.0F;
    (conventional_ ? lcor_conventional_row : lcor_correct_row)(
        plan_, y, row.rho.size(), row.rgb.data(), row.illuminance.data(), row.rho.data(),
        row.rgb.data(), stats);
}

void Developer::row(size_t y, float *rgba, lcor_row_stats &stats) const
{
    const size_t width = picture_.width();
    Picture::Row row;
    picture_.row(y, true, row);
    samples(y, row, &stats);
    std::fill_n(rgba, 4 * width, 0.0F);
    size_t count;
    const lcor_span *const spans = lcor_view_row(picture_.view(), y, &count);
    const float *from = row.rgb.data();
    for (size_t i = 0; i < count; i++)
        for (size_t x = spans[i].x0; x < spans[i].x1; x++, from += 3) {
            for (size_t c = 0; c < 3; c++)
                rgba[4 * x + c] += spans[i].coverage * from[c];
            rgba[4 * x + 3] += spans[i].coverage;
        }
    for (size_t x = 0; x < width; x++) {
        float *const pixel = rgba + 4 * x;
        if (pixel[3] <= 0.0F || pixel[3] == 1.0F)
            continue;
        for (size_t c = 0; c < 3; c++)
            pixel[c] /= pixel[3];
        pixel[3] = std::min(pixel[3], 1.0F);
    }
}

void Developer::add(lcor_row_stats &into, const lcor_row_stats &from)
{
    if (from.non_finite > 0 && (into.non_finite == 0 || from.first_bad_row < into.first_bad_row)) {
        into.first_bad_row = from.first_bad_row;
        into.first_bad_pixel = from.first_bad_pixel;
    }
    into.pixels += from.pixels;
    into.clipped_low += from.clipped_low;
    into.clipped_high += from.clipped_high;
    into.out_of_gamut += from.out_of_gamut;
    into.non_finite += from.non_finite;
}

} // namespace cli
