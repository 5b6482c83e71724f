/* SPDX-License-Identifier: MIT */
#include "aov.h"
#include "stream.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cli
{

namespace
{

using Rgb = std::array<uint8_t, 3>;

constexpr Rgb paper = {255, 255, 255}, ink = {0, 0, 0}, nothing = {96, 96, 96};
/* Ranges of more than this are shown in logarithms. */
constexpr double log_ratio = 50.0;

/* From dark violet over blue, green and yellow to nearly white: lightness rises all the way, so
 * that it reads in grey as well. */
constexpr Rgb stops[] = {{20, 4, 40},     {58, 20, 110},  {52, 60, 160},  {28, 104, 168},
                         {16, 140, 150},  {40, 172, 110}, {120, 198, 64}, {208, 214, 56},
                         {250, 228, 130}, {255, 250, 220}};

Rgb colour_of(double part)
{
    constexpr size_t last = std::size(stops) - 1;
    const double at = std::clamp(part, 0.0, 1.0) * last;
    const size_t left = std::min(static_cast<size_t>(at), last - 1);
    const double t = at - static_cast<double>(left);
    Rgb rgb;
    for (size_t c = 0; c < 3; c++)
        rgb[c] =
            static_cast<uint8_t>(stops[left][c] + t * (stops[left + 1][c] - stops[left][c]) + 0.5);
    return rgb;
}

/* Glyphs of 5 x 7, a row a byte, the left pixel at bit 4. */
struct Glyph {
    char sign;
    uint8_t rows[7];
};
constexpr Glyph glyphs[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},
    {'2', {14, 17, 1, 2, 4, 8, 31}},     {'3', {31, 2, 4, 2, 1, 17, 14}},
    {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},
    {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 2, 12}},
    {'.', {0, 0, 0, 0, 0, 12, 12}},      {'-', {0, 0, 0, 31, 0, 0, 0}},
    {'+', {0, 4, 4, 31, 4, 4, 0}},       {'e', {0, 0, 14, 17, 31, 16, 14}},
    {'l', {12, 4, 4, 4, 4, 4, 14}},      {'x', {0, 0, 17, 10, 4, 10, 17}},
};

class Canvas
{
  public:
    Canvas(size_t width, size_t height) : width_(width), pixels_(3 * width * height)
    {
        for (size_t i = 0; i < width * height; i++)
            std::copy(paper.begin(), paper.end(), &pixels_[3 * i]);
    }
    void set(size_t x, size_t y, const Rgb &rgb)
    {
        const size_t i = 3 * (y * width_ + x);
        if (x < width_ && i < pixels_.size())
            std::copy(rgb.begin(), rgb.end(), &pixels_[i]);
    }
    void fill(size_t x, size_t y, size_t w, size_t h, const Rgb &rgb)
    {
        for (size_t j = y; j < y + h; j++)
            for (size_t i = x; i < x + w; i++)
                set(i, j, rgb);
    }
    void text(size_t x, size_t y, size_t scale, const std::string &line)
    {
        for (const char sign : line) {
            const auto glyph = std::find_if(std::begin(glyphs), std::end(glyphs),
                                            [&](const Glyph &g) { return g.sign == sign; });
            for (size_t j = 0; j < 7 && glyph != std::end(glyphs); j++)
                for (size_t i = 0; i < 5; i++)
                    if (glyph->rows[j] >> (4 - i) & 1)
                        fill(x + i * scale, y + j * scale, scale, scale, ink);
            x += 6 * scale;
        }
    }
    const uint8_t *data() const { return pixels_.data(); }

  private:
    size_t width_;
    std::vector<uint8_t> pixels_;
};

/* Illuminance along the scale. */
struct Scale {
    double low, high;
    bool logarithmic;
    double part(double lux) const
    {
        if (logarithmic)
            return std::log(std::max(lux, low) / low) / std::log(high / low);
        return high > low ? (lux - low) / (high - low) : 0.5;
    }
    double lux(double part) const
    {
        return logarithmic ? low * std::pow(high / low, part) : low + part * (high - low);
    }
};

Scale scale_of(const std::vector<float> &lux)
{
    Scale scale = {HUGE_VAL, 0.0, false};
    for (const float e : lux)
        if (e >= 0.0F) {
            scale.low = std::min(scale.low, static_cast<double>(e));
            scale.high = std::max(scale.high, static_cast<double>(e));
        }
    if (!(scale.low <= scale.high))
        scale.low = scale.high = 0.0;
    scale.logarithmic = scale.high > log_ratio * scale.low && scale.high > 0.0;
    if (scale.logarithmic) /* four decades at most: below lies darkness */
        scale.low = std::max(scale.low, 1e-4 * scale.high);
    return scale;
}

/* Three digits, in C notation: whole multiples of a power of ten keep them short. */
std::string label(double lux)
{
    if (!(lux > 0.0))
        return "0 lx";
    const double power = std::floor(std::log10(lux)) - 2.0;
    const double digits = std::round(lux / std::pow(10.0, power));
    return number_text(power < 0.0 ? digits / std::pow(10.0, -power)
                                   : digits * std::pow(10.0, power)) +
           " lx";
}

void draw_legend(Canvas &canvas, const Scale &scale, size_t left, size_t height, size_t size)
{
    constexpr size_t steps = 4;
    const size_t bar = 4 * size, margin = 6 * size;
    const size_t top = margin, bottom = std::max(height - std::min(margin, height - 1), top + 2);
    for (size_t y = top; y < bottom; y++)
        canvas.fill(
            left + margin / 2, y, bar, 1,
            colour_of(1.0 - static_cast<double>(y - top) / static_cast<double>(bottom - 1 - top)));
    for (size_t i = 0; i <= steps; i++) {
        const double part = static_cast<double>(i) / steps;
        const size_t y =
            bottom - 1 - static_cast<size_t>(part * static_cast<double>(bottom - 1 - top) + 0.5);
        canvas.fill(left + margin / 2 + bar, y, size, 1, ink);
        canvas.text(left + margin / 2 + bar + 2 * size, y - std::min(y, 7 * size / 4),
                    std::max<size_t>(size / 2, 1), label(scale.lux(part)));
    }
}

} // namespace

void write_false_colour(const std::string &path, const std::vector<float> &lux, size_t width,
                        size_t height, const Provenance &provenance)
{
    const Scale scale = scale_of(lux);
    const size_t size = std::max<size_t>(2, height / 150); /* of the legend's details */
    const size_t legend =
        6 * size / 2 + 4 * size + 2 * size + 10 * (6 * std::max<size_t>(size / 2, 1));
    Canvas canvas(width + legend, height);
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            const double e = static_cast<double>(lux[y * width + x]);
            canvas.set(x, y, e < 0.0 ? nothing : colour_of(scale.part(e)));
        }
    draw_legend(canvas, scale, width, height, size);
    OIIO::ImageSpec spec(static_cast<int>(width + legend), static_cast<int>(height), 3,
                         OIIO::TypeDesc::UINT8);
    describe(spec, provenance);
    PictureWriter writer(path, spec);
    writer.write(0, height, OIIO::TypeDesc::UINT8, canvas.data());
    writer.commit();
}

} // namespace cli
