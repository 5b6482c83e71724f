/* SPDX-License-Identifier: MIT */
/* From a picture of a lit scene to what a device shows: adaptation, then the correction. */
#ifndef LCOR_CLI_DEVELOP_H
#define LCOR_CLI_DEVELOP_H

#include "picture.h"

namespace cli
{

/* A point of the picture that the eye rests on: what lies `degrees` / 2 away from it counts half as
 * much for the adaptation, by a Gaussian of the angle. */
struct Gaze {
    double x, y; /* parts of the picture's width and height from the upper left corner */
    double degrees;
};

/* Geometric mean of r over the displayed pixels (section 4.3), each weighted by how much of it
 * shows a surface and by the gaze. 0 when nothing is lit. */
double mean_over_view(const Picture &picture, const CorrectionOptions &correction,
                      const Device &device, const std::optional<Gaze> &gaze);
/* The same over the patches of all surfaces, weighted by their area. */
double mean_over_surfaces(const Scene &scene, const lcor_solution *solution,
                          lcor_mean_method method);

/* A plan for rows of a picture: linear floats in and out. */
PlanPointer picture_plan(const CorrectionOptions &correction, const Device &device, double r_mean);

/* Applies a plan to the rows of a picture. */
class Developer
{
  public:
    /* The conventional method takes r / r_mean for the rho I of eq 19: a surface of mean luminance
     * then shows its texture unchanged, and a channel of 1 saturates from there on. */
    Developer(const Picture &picture, const lcor_plan *plan, bool conventional, double r_mean);

    /* Linear RGB and coverage of row y, four floats a pixel: colours are straight. Rows of
     * different numbers may be developed at the same time. */
    void row(size_t y, float *rgba, lcor_row_stats &stats) const;
    /* Samples of row y as the plan maps them: row.rgb becomes what is shown. */
    void samples(size_t y, Picture::Row &row, lcor_row_stats *stats) const;
    /* Adds what another thread counted. */
    static void add(lcor_row_stats &into, const lcor_row_stats &from);

  private:
    const Picture &picture_;
    const lcor_plan *plan_;
    const bool conventional_;
    const double r_mean_;
};

} // namespace cli

#endif
