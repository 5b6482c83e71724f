/* SPDX-License-Identifier: MIT */
/* The experiments of the paper's sections 5 and 6, repeated. */
#ifndef LCOR_CLI_PAPER_H
#define LCOR_CLI_PAPER_H

#include "cli.h"
#include "image.h"

#include <string>
#include <vector>

namespace cli
{

/* A device and a mapping as the paper has them: eq 1's primaries, linear RGB. */
struct PaperSetup {
    double contrast = 23.4; /* section 5.1 */
    lcor_colour colour;     /* of eq 1 */
    explicit PaperSetup(double device_contrast);
    /* r of `illuminance` times `rho`; corrected or by eq 19. rgb: n pixels, linear, in place. */
    void show(bool conventional, double r_mean, double rho, const std::vector<double> &illuminance,
              std::vector<double> &rgb) const;
    /* Display luminance over Jmax (eq 10). */
    double luminance(const double *rgb) const;
    void lab(const double *rgb, double out[3]) const;
};

/* Illuminance of Figure 3 (b): a lamp before a wall, from 8^(2/3) under it to 8^(-1/2) in the
 * farthest corner by the cube of the cosine. (0, 0) is the upper left corner. */
double paper_illuminance(double x, double y);
/* Mean of it over the picture (section 4.3). */
double paper_mean();

/* A texture for those who give none: woven threads of one hue. */
Image paper_pattern(int number);

/* Degrees from -180 to 180. */
double hue_difference(const double a[3], const double b[3]);

/* Writes figure3{a,b,c,d}.png into the folder; returns what was measured. */
Json paper_figure3(const PaperSetup &setup, const Image &image, const std::string &folder);
/* Writes figure5.csv; returns what was measured. */
Json paper_figure5(const PaperSetup &setup, const std::string &folder);

} // namespace cli

#endif
