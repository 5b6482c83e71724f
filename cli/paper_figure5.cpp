/* SPDX-License-Identifier: MIT */
/* Table 4 and Figure 5: one colour under growing illuminance. */
#include "paper.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

constexpr double colour_of_table4[3] = {250.0 / 255.0, 50.0 / 255.0, 150.0 / 255.0};
/* Steps of equal ratio from 8^-3/2 to 8^3/2. */
constexpr int steps = 1200;
constexpr double decades = 3.0; /* powers of 8 from end to end */
/* H counts as proportional to illuminance within this part. */
constexpr double proportional = 0.01;
/* Bends of a curve, as changes of its logarithmic slope from one step to the next: a smooth curve's
 * fall with the step, a kink's do not. */
constexpr double kink = 0.1;

struct Curve {
    std::vector<double> luminance, hue, chroma;
};

struct Range {
    size_t first, last; /* steps */
};

double illuminance_of(size_t step)
{
    return std::pow(8.0, decades * (static_cast<double>(step) / steps - 0.5));
}

Curve sweep(const PaperSetup &setup, bool conventional, double r_mean, double rho)
{
    std::vector<double> illuminance, rgb;
    for (size_t i = 0; i <= steps; i++) {
        illuminance.push_back(illuminance_of(i));
        rgb.insert(rgb.end(), colour_of_table4, colour_of_table4 + 3);
    }
    setup.show(conventional, r_mean, rho, illuminance, rgb);
    Curve curve;
    double texture[3];
    setup.lab(colour_of_table4, texture);
    for (size_t i = 0; i <= steps; i++) {
        double lab[3];
        setup.lab(&rgb[3 * i], lab);
        curve.luminance.push_back(setup.luminance(&rgb[3 * i]));
        curve.hue.push_back(lcor_chroma(lab) > 1e-3 ? hue_difference(lab, texture) : 0.0);
        curve.chroma.push_back(lcor_chroma(lab));
    }
    return curve;
}

/* The widest run of steps over which luminance over illuminance keeps within `proportional` of its
 * value in the run's middle. */
Range proportional_range(const Curve &curve)
{
    const auto ratio = [&](size_t i) { return curve.luminance[i] / illuminance_of(i); };
    Range best = {0, 0};
    for (size_t middle = 0; middle <= steps; middle++) {
        Range range = {middle, middle};
        const auto near = [&](size_t i) {
            return std::fabs(ratio(i) / ratio(middle) - 1.0) <= proportional;
        };
        while (range.first > 0 && near(range.first - 1))
            range.first--;
        while (range.last < steps && near(range.last + 1))
            range.last++;
        if (range.last - range.first > best.last - best.first)
            best = range;
    }
    return best;
}

/* Illuminances strictly inside first..last at which the slope of ln `values` over ln I jumps. */
Json kinks(const std::vector<double> &values, size_t first, size_t last)
{
    const double step = std::log(8.0) * decades / steps;
    Json found = Json::array();
    size_t previous = 0;
    for (size_t i = first + 2; i + 2 <= last; i++) {
        if (!(values[i - 1] > 0.0 && values[i] > 0.0 && values[i + 1] > 0.0))
            continue;
        const double before = std::log(values[i] / values[i - 1]) / step;
        const double after = std::log(values[i + 1] / values[i]) / step;
        if (std::fabs(after - before) <= kink)
            continue;
        if (previous == 0 || i > previous + 2) /* one kink may show in two steps */
            found.push_back(illuminance_of(i));
        previous = i;
    }
    return found;
}

Json judge(const Curve &curve, double first_shown, double last_shown)
{
    const Range range = proportional_range(curve);
    Range shown = {0, steps};
    while (shown.first < steps && illuminance_of(shown.first) <= first_shown)
        shown.first++;
    while (shown.last > 0 && illuminance_of(shown.last) >= last_shown)
        shown.last--;
    double drift = 0.0;
    for (size_t i = shown.first; i <= shown.last; i++)
        drift = std::max(drift, std::fabs(curve.hue[i]));
    return {{"proportional_from", illuminance_of(range.first)},
            {"proportional_to", illuminance_of(range.last)},
            {"proportional_ratio", illuminance_of(range.last) / illuminance_of(range.first)},
            {"hue_drift_max_degrees", drift},
            {"chroma_max", *std::max_element(curve.chroma.begin(), curve.chroma.end())},
            {"luminance_kinks", kinks(curve.luminance, shown.first, shown.last)},
            {"chroma_kinks", kinks(curve.chroma, shown.first, shown.last)}};
}

std::string table(const Curve &conventional, const Curve &corrected)
{
    std::string text =
        "illuminance,H_conventional,H_corrected,hue_shift_conventional,hue_shift_corrected,"
        "chroma_conventional,chroma_corrected\n";
    for (size_t i = 0; i <= steps; i++) {
        text += number_text(illuminance_of(i));
        for (const double value :
             {conventional.luminance[i], corrected.luminance[i], conventional.hue[i],
              corrected.hue[i], conventional.chroma[i], corrected.chroma[i]})
            text += "," + number_text(value);
        text += "\n";
    }
    return text;
}

} // namespace

Json paper_figure5(const PaperSetup &setup, const std::string &folder)
{
    double rho = 0.0;
    for (size_t c = 0; c < 3; c++)
        rho += setup.colour.to_xyz[3 + c] * colour_of_table4[c];
    const double r_mean = rho * paper_mean();
    const Curve conventional = sweep(setup, true, r_mean, rho),
                corrected = sweep(setup, false, r_mean, rho);
    write_file(folder + "/figure5.csv", table(conventional, corrected));
    const double mean = r_mean / rho;
    const double first = mean * 2.0 / (setup.contrast + 1.0),
                 last = first * setup.contrast; /* eq 8 */
    return {{"rgb", {250, 50, 150}},
            {"shown_from", first},
            {"shown_to", last},
            {"paper_proportional_ratio", std::pow(8.0, 7.0 / 6.0)},
            {"conventional", judge(conventional, first, last)},
            {"corrected", judge(corrected, first, last)}};
}

} // namespace cli
