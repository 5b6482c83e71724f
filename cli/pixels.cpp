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
    if (rows.kind() != LCOR_U8)
        return;
    for (size_t c = 0; c < 3; c++)
        for (int i = 0; i < 256; i++)
            table_[c].push_back(colour.to_xyz[3 + c] * lcor_transfer_to_linear(&colour, i / 255.0));
}

void LuminanceSum::add(size_t y, const uint8_t *row)
{
    const size_t step = rows_.bytes() / rows_.type().size() / rows_.width();
    const size_t green = rows_.grey() ? 0 : 1, blue = rows_.grey() ? 0 : 2;
    std::vector<double> alpha;
    if (rows_.has_alpha())
        rows_.coverage(row, alpha);
    double sum = 0.0, weight = 0.0;
    for (size_t x = 0; x < rows_.width(); x++) {
        const size_t i = x * step;
        double value = 0.0;
        if (rows_.kind() == LCOR_U8) {
            value = table_[0][row[i]] + table_[1][row[i + green]] + table_[2][row[i + blue]];
        } else {
            const size_t index[3] = {i, i + green, i + blue};
            for (size_t c = 0; c < 3; c++)
                value += colour_.to_xyz[3 + c] *
                         lcor_transfer_to_linear(&colour_, rows_.sample(row, index[c]));
            /* Broken pixels count as black, as the correction writes them. */
            value = value > 0.0 ? std::min(value, 1.0) : 0.0;
        }
        const double a = alpha.empty() ? 1.0 : alpha[x];
        sum += a * value;
        weight += a;
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
