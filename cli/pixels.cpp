/* SPDX-License-Identifier: MIT */
#include "pixels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

PixelRows::PixelRows(OIIO::TypeDesc in, OIIO::TypeDesc out, bool premultiplied, size_t width,
                     size_t channels, int alpha)
    : width_(width), channels_(channels), alpha_(alpha)
{
    const auto bytes = [](OIIO::TypeDesc type) { return type == OIIO::TypeDesc::UINT8; };
    const auto words = [&](OIIO::TypeDesc type) {
        return bytes(type) || type == OIIO::TypeDesc::UINT16;
    };
    if (in == OIIO::TypeDesc::DOUBLE || out == OIIO::TypeDesc::DOUBLE) {
        kind_ = LCOR_F64;
        type_ = OIIO::TypeDesc::DOUBLE;
    } else if (!premultiplied && bytes(in) && bytes(out)) {
        kind_ = LCOR_U8;
        type_ = OIIO::TypeDesc::UINT8;
    } else if (!premultiplied && words(in) && words(out)) {
        kind_ = LCOR_U16;
        type_ = OIIO::TypeDesc::UINT16;
    } else {
        kind_ = LCOR_F32;
        type_ = OIIO::TypeDesc::FLOAT;
    }
}

double PixelRows::sample(const uint8_t *row, size_t index) const
{
    switch (kind_) {
    case LCOR_U8: return row[index] / 255.0;
    case LCOR_U16: {
        uint16_t value;
        std::memcpy(&value, row + index * sizeof value, sizeof value);
        return value / 65535.0;
    }
    case LCOR_F32: {
        float value;
        std::memcpy(&value, row + index * sizeof value, sizeof value);
        return static_cast<double>(value);
    }
    case LCOR_F64: break;
    }
    double value;
    std::memcpy(&value, row + index * sizeof value, sizeof value);
    return value;
}

void PixelRows::scale(uint8_t *row, bool divide) const
{
    const size_t colours = grey() ? 1 : 3;
    for (size_t x = 0; x < width_; x++) {
        const double alpha = sample(row, x * channels_ + static_cast<size_t>(alpha_));
        if (!(alpha > 0.0) || (alpha >= 1.0 && alpha <= 1.0))
            continue;
        for (size_t c = 0; c < colours; c++) {
            const size_t index = x * channels_ + c;
            const double value = sample(row, index);
            const double scaled = divide ? value / alpha : value * alpha;
            const float single = static_cast<float>(scaled);
            if (kind_ == LCOR_F64)
                std::memcpy(row + index * sizeof scaled, &scaled, sizeof scaled);
            else
                std::memcpy(row + index * sizeof single, &single, sizeof single);
        }
    }
}

void PixelRows::spread_grey(const uint8_t *row, std::vector<uint8_t> &rgb) const
{
    const size_t size = type_.size();
    rgb.resize(3 * size * width_);
    for (size_t x = 0; x < width_; x++)
        for (size_t c = 0; c < 3; c++)
            std::memcpy(&rgb[(3 * x + c) * size], row + x * channels_ * size, size);
}

void PixelRows::gather_grey(const std::vector<uint8_t> &rgb, uint8_t *row) const
{
    const size_t size = type_.size();
    for (size_t x = 0; x < width_; x++)
        std::memcpy(row + x * channels_ * size, &rgb[(3 * x + 1) * size], size);
}

void PixelRows::coverage(const uint8_t *row, std::vector<double> &out) const
{
    out.resize(width_);
    for (size_t x = 0; x < width_; x++) {
        const double a = sample(row, x * channels_ + static_cast<size_t>(alpha_));
        out[x] = a > 0.0 ? std::min(a, 1.0) : 0.0;
    }
}

LuminanceSum::LuminanceSum(const lcor_colour &colour, const PixelRows &rows, size_t height)
    : colour_(colour), rows_(rows), luminance_(height), weight_(height)
{
    const size_t levels = rows.kind() == LCOR_U8 ? 256 : rows.kind() == LCOR_U16 ? 65536 : 0;
    for (size_t i = 0; i < levels; i++)
        linear_.push_back(lcor_transfer_to_linear(&colour, static_cast<double>(i) /
                                                               static_cast<double>(levels - 1)));
}

/* Sum of Y of integers none of which is transparent, the usual picture. */
template <typename Sample> double LuminanceSum::sum_opaque(const uint8_t *row, size_t step) const
{
    const double *const m = colour_.to_xyz + 3;
    const size_t green = rows_.grey() ? 0 : 1, blue = rows_.grey() ? 0 : 2;
    const auto luminance = [&](const uint8_t *at) {
        Sample sample[3];
        std::memcpy(&sample[0], at, sizeof(Sample));
        std::memcpy(&sample[1], at + green * sizeof(Sample), sizeof(Sample));
        std::memcpy(&sample[2], at + blue * sizeof(Sample), sizeof(Sample));
        return m[0] * linear_[sample[0]] + m[1] * linear_[sample[1]] + m[2] * linear_[sample[2]];
    };
    const size_t pixel = step * sizeof(Sample);
    double sum = 0.0;
    size_t x = 0;
    /* Four at a time: one long chain of additions would wait for each of them. */
    for (; x + 4 <= rows_.width(); x += 4, row += 4 * pixel)
        sum += (luminance(row) + luminance(row + pixel)) +
               (luminance(row + 2 * pixel) + luminance(row + 3 * pixel));
    for (; x < rows_.width(); x++, row += pixel)
        sum += luminance(row);
    return sum;
}

double LuminanceSum::linear(const uint8_t *row, size_t index) const
{
    if (rows_.kind() == LCOR_U8)
        return linear_[row[index]];
    if (rows_.kind() == LCOR_U16) {
        uint16_t sample;
        std::memcpy(&sample, row + index * sizeof sample, sizeof sample);
        return linear_[sample];
    }
    return lcor_transfer_to_linear(&colour_, rows_.sample(row, index));
}

/* Y of any pixel; broken ones count as black, as the correction writes them. */
double LuminanceSum::luminance(const uint8_t *row, size_t index) const
{
    double value = 0.0;
    for (size_t c = 0; c < 3; c++)
        value += colour_.to_xyz[3 + c] * linear(row, index + (rows_.grey() ? 0 : c));
    return value > 0.0 ? std::min(value, 1.0) : 0.0;
}

void LuminanceSum::add(size_t y, const uint8_t *row)
{
    const size_t step = rows_.bytes() / rows_.type().size() / rows_.width();
    if (!linear_.empty() && !rows_.has_alpha()) {
        luminance_[y] = rows_.kind() == LCOR_U8 ? sum_opaque<uint8_t>(row, step)
                                                : sum_opaque<uint16_t>(row, step);
        weight_[y] = static_cast<double>(rows_.width());
        return;
    }
    std::vector<double> alpha(rows_.width(), 1.0);
    if (rows_.has_alpha())
        rows_.coverage(row, alpha);
    double sum = 0.0, weight = 0.0;
    for (size_t x = 0; x < rows_.width(); x++) {
        sum += alpha[x] * luminance(row, x * step);
        weight += alpha[x];
    }
    luminance_[y] = sum;
    weight_[y] = weight;
}

double LuminanceSum::mean() const
{
    double sum = 0.0, weight = 0.0;
    for (size_t y = 0; y < luminance_.size(); y++) {
        sum += luminance_[y];
        weight += weight_[y];
    }
    return weight > 0.0 ? sum / weight : 0.0;
}

} // namespace cli
