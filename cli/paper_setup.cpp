/* SPDX-License-Identifier: MIT */
#include "develop.h"
#include "paper.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

constexpr size_t pattern_side = 1000;
constexpr size_t mean_side = 512; /* places a side for the mean of the illuminance */

} // namespace

PaperSetup::PaperSetup(double device_contrast) : contrast(device_contrast)
{
    lcor_error error = {};
    check(lcor_colour_init(&colour, LCOR_PRIMARIES_NTSC, nullptr, LCOR_TRANSFER_LINEAR, 1.0,
                           LCOR_LIGHTNESS_CIE, &error),
          error, Exit::failed, "colour");
}

void PaperSetup::show(bool conventional, double r_mean, double rho,
                      const std::vector<double> &illuminance, std::vector<double> &rgb) const
{
    lcor_plan_options options = {};
    options.struct_size = sizeof options;
    options.contrast = contrast;
    options.r_mean = r_mean;
    options.rho = rho;
    options.colour = &colour;
    options.in_type = options.out_type = options.map_type = LCOR_F64;
    lcor_plan *plan = nullptr;
    lcor_error error = {};
    check(lcor_plan_new(&options, &plan, &error), error, Exit::usage, "correction");
    const PlanPointer owner(plan);
    if (!conventional) {
        lcor_correct_row(plan, 0, illuminance.size(), rgb.data(), illuminance.data(), nullptr,
                         rgb.data(), nullptr);
        return;
    }
    /* rho I of eq 19 on the scale where an illuminance of 1 shows the texture as it is */
    const std::vector<double> whole(illuminance.size(), 1.0);
    lcor_conventional_row(plan, 0, illuminance.size(), rgb.data(), illuminance.data(), whole.data(),
                          rgb.data(), nullptr);
}

double PaperSetup::luminance(const double *rgb) const
{
    double y = 0.0;
    for (size_t c = 0; c < 3; c++)
        y += colour.to_xyz[3 + c] * rgb[c];
    return (1.0 + y * (contrast - 1.0)) / contrast;
}

void PaperSetup::lab(const double *rgb, double out[3]) const
{
    double xyz[3];
    lcor_xyz_from_rgb(&colour, rgb, xyz);
    lcor_lab_from_xyz(&colour, xyz, out);
}

double paper_illuminance(double x, double y)
{
    /* distance from the lamp's foot in units of its height, such that the cosine's cube takes the
     * far corner from 8^(2/3) to 8^(-1/2): the range of section 6 */
    constexpr double foot[2] = {0.35, 0.4};
    const double far = std::hypot(1.0 - foot[0], 1.0 - foot[1]);
    const double reach = std::sqrt(std::pow(8.0, 7.0 / 9.0) - 1.0);
    const double d = std::hypot(x - foot[0], y - foot[1]) / far * reach;
    return std::pow(8.0, 2.0 / 3.0) / std::pow(1.0 + d * d, 1.5);
}

double paper_mean()
{
    std::vector<double> values;
    for (size_t y = 0; y < mean_side; y++)
        for (size_t x = 0; x < mean_side; x++)
            values.push_back(paper_illuminance((static_cast<double>(x) + 0.5) / mean_side,
                                               (static_cast<double>(y) + 0.5) / mean_side));
    double mean = 0.0;
    lcor_error error = {};
    check(lcor_geometric_mean(values.size(), values.data(), nullptr, LCOR_MEAN_ADAPTIVE, &mean,
                              &error),
          error, Exit::failed, "mean");
    return mean;
}

Image paper_pattern(int number)
{
    /* threads, ground: sRGB samples of a wood, a cloth and a plaster */
    static const double colours[3][2][3] = {{{176, 120, 64}, {120, 72, 36}},
                                            {{200, 92, 110}, {150, 52, 84}},
                                            {{226, 222, 206}, {196, 200, 204}}};
    const auto &pair = colours[number % 3];
    Image image;
    image.width = image.height = pattern_side;
    image.channels = 3;
    image.bytes.resize(3 * pattern_side * pattern_side);
    for (size_t y = 0; y < pattern_side; y++)
        for (size_t x = 0; x < pattern_side; x++) {
            const double u = static_cast<double>(x) / pattern_side,
                         v = static_cast<double>(y) / pattern_side;
            const double warp =
                std::sin(2.0 * pi * (24.0 * u + 0.3 * std::sin(2.0 * pi * 3.0 * v)));
            const double weft =
                std::sin(2.0 * pi * (24.0 * v + 0.3 * std::sin(2.0 * pi * 2.0 * u)));
            const double t = 0.5 + 0.5 * warp * weft;
            for (size_t c = 0; c < 3; c++)
                image.bytes[3 * (y * pattern_side + x) + c] =
                    static_cast<uint8_t>(pair[1][c] + t * (pair[0][c] - pair[1][c]) + 0.5);
        }
    return image;
}

double hue_difference(const double a[3], const double b[3])
{
    const double turn = (lcor_hue(a) - lcor_hue(b)) * 180.0 / pi;
    return turn - 360.0 * std::round(turn / 360.0);
}

} // namespace cli
