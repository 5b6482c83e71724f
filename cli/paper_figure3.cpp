/* SPDX-License-Identifier: MIT */
/* Figure 3: one texture under one light, by the conventional method and by the correction. */
#include "encode.h"
#include "paper.h"
#include "stream.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

/* Colours of less chroma have no hue to speak of. */
constexpr double least_chroma = 2.0;

struct Figure {
    size_t width, height;
    std::vector<double> rgb; /* linear */
};

void write_png(const std::string &path, const Figure &figure, const lcor_colour &stored)
{
    const Encoder encoder(OIIO::TypeDesc::UINT8, false, stored, {});
    OIIO::ImageSpec spec(static_cast<int>(figure.width), static_cast<int>(figure.height), 3,
                         OIIO::TypeDesc::UINT8);
    PictureWriter writer(path, spec);
    std::vector<uint8_t> bytes(figure.height * encoder.row_bytes(figure.width));
    std::vector<float> rgba(4 * figure.width, 1.0F);
    for (size_t y = 0; y < figure.height; y++) {
        for (size_t x = 0; x < figure.width; x++)
            for (size_t c = 0; c < 3; c++)
                rgba[4 * x + c] = static_cast<float>(figure.rgb[3 * (y * figure.width + x) + c]);
        encoder.row(rgba.data(), figure.width, &bytes[y * encoder.row_bytes(figure.width)]);
    }
    writer.write(0, figure.height, OIIO::TypeDesc::UINT8, bytes.data());
    writer.commit();
}

/* How far hues turn from the texture's, and how many pixels have a channel at its end. */
Json judge(const PaperSetup &setup, const Figure &texture, const Figure &shown)
{
    const size_t n = texture.width * texture.height;
    double worst = 0.0, squares = 0.0;
    size_t judged = 0, saturated = 0;
    for (size_t i = 0; i < n; i++) {
        const double *const rgb = &shown.rgb[3 * i];
        double before[3], after[3];
        setup.lab(&texture.rgb[3 * i], before);
        setup.lab(rgb, after);
        saturated +=
            std::max({rgb[0], rgb[1], rgb[2]}) >= 1.0 && std::min({rgb[0], rgb[1], rgb[2]}) < 1.0;
        if (lcor_chroma(before) < least_chroma || lcor_chroma(after) < least_chroma)
            continue;
        const double turn = std::fabs(hue_difference(after, before));
        worst = std::max(worst, turn);
        squares += turn * turn;
        judged++;
    }
    return {{"hue_drift_max_degrees", worst},
            {"hue_drift_rms_degrees",
             judged > 0 ? std::sqrt(squares / static_cast<double>(judged)) : 0.0},
            {"pixels_with_hue", judged},
            {"partly_saturated_share", static_cast<double>(saturated) / static_cast<double>(n)}};
}

} // namespace

Json paper_figure3(const PaperSetup &setup, const Image &image, const std::string &folder)
{
    lcor_colour stored;
    lcor_error error = {};
    check(lcor_colour_init(&stored, LCOR_PRIMARIES_SRGB, nullptr, LCOR_TRANSFER_SRGB, 1.0,
                           LCOR_LIGHTNESS_CIE, &error),
          error, Exit::failed, "colour");
    const size_t n = image.width * image.height;
    const bool colours = image.channels >= 3;
    Figure texture = {image.width, image.height, std::vector<double>(3 * n)};
    Figure map = texture;
    std::vector<double> illuminance(n);
    double rho = 0.0;
    for (size_t y = 0; y < image.height; y++)
        for (size_t x = 0; x < image.width; x++) {
            const size_t i = y * image.width + x;
            illuminance[i] = paper_illuminance(
                (static_cast<double>(x) + 0.5) / static_cast<double>(image.width),
                (static_cast<double>(y) + 0.5) / static_cast<double>(image.height));
            for (size_t c = 0; c < 3; c++) {
                const double linear =
                    lcor_transfer_to_linear(&stored, image.sample(x, y, colours ? c : 0));
                texture.rgb[3 * i + c] = linear;
                map.rgb[3 * i + c] = illuminance[i] / 4.0;
                rho += setup.colour.to_xyz[3 + c] * linear / static_cast<double>(n);
            }
        }
    const double r_mean = rho * paper_mean();
    Figure conventional = texture, corrected = texture;
    setup.show(true, r_mean, rho, illuminance, conventional.rgb);
    setup.show(false, r_mean, rho, illuminance, corrected.rgb);
    write_png(folder + "/figure3a.png", texture, stored);
    write_png(folder + "/figure3b.png", map, stored);
    write_png(folder + "/figure3c.png", conventional, stored);
    write_png(folder + "/figure3d.png", corrected, stored);
    return {{"illuminance", "8^(2/3) under the lamp to 8^(-1/2) in the far corner"},
            {"rho", rho},
            {"r_mean", r_mean},
            {"conventional", judge(setup, texture, conventional)},
            {"corrected", judge(setup, texture, corrected)}};
}

} // namespace cli
