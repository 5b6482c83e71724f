/* SPDX-License-Identifier: MIT */
#include "texture.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

/* Longest footprint in units of its width; longer ones are blurred a little instead. */
constexpr double most_probes = 16.0;

uint16_t to_stored(double linear)
{
    return static_cast<uint16_t>(std::clamp(linear, 0.0, 1.0) * 65535.0 + 0.5);
}

/* Linear value of every stored 8- or 16-bit sample. */
std::vector<uint16_t> linear_table(lcor_sample type, const lcor_colour &transfer)
{
    const size_t count = type == LCOR_U8 ? 256 : type == LCOR_U16 ? 65536 : 0;
    std::vector<uint16_t> table(count);
    for (size_t i = 0; i < count; i++)
        table[i] = to_stored(lcor_transfer_to_linear(
            &transfer, static_cast<double>(i) / static_cast<double>(count - 1)));
    return table;
}

/* The interval of `size` source texels under destination texel `i` of `count`, with weights. */
struct Cover {
    size_t first;
    float weights[3];
};

std::vector<Cover> covers(size_t size, size_t count)
{
    std::vector<Cover> out(count);
    const double step = static_cast<double>(size) / static_cast<double>(count);
    for (size_t i = 0; i < count; i++) {
        const double low = static_cast<double>(i) * step, high = low + step;
        out[i].first = std::min(static_cast<size_t>(low), size - 1);
        for (size_t k = 0; k < 3; k++) {
            const double left = static_cast<double>(out[i].first + k);
            const double length = std::min(high, left + 1.0) - std::max(low, left);
            out[i].weights[k] =
                out[i].first + k < size ? static_cast<float>(std::max(length, 0.0) / step) : 0.0F;
        }
    }
    return out;
}

} // namespace

/* How a pixel's footprint is read: `count` probes along its longer axis, each from two levels. */
struct MipTexture::Footprint {
    double step[2]; /* between probes, in u and v */
    int count;
    size_t level;  /* the finer one */
    float coarser; /* weight of the next one */
};

MipTexture::MipTexture(const Image &image, const Texture &texture, const lcor_colour &transfer)
    : wrap_u_(texture.wrap_u), wrap_v_(texture.wrap_v), nearest_(texture.nearest)
{
    const std::vector<uint16_t> table = linear_table(image.type, transfer);
    Level base{image.width, image.height,
               std::vector<uint16_t>(image.width * image.height * STRIDE)};
    const size_t green = image.channels >= 3 ? 1 : 0, blue = image.channels >= 3 ? 2 : 0;
    const size_t pick[3] = {0, green, blue};
    uint16_t *out = base.texels.data();
    for (size_t y = 0; y < image.height; y++)
        for (size_t x = 0; x < image.width; x++, out += STRIDE)
            for (size_t c = 0; c < 3; c++) {
                const size_t i = (y * image.width + x) * image.channels + pick[c];
                if (image.type == LCOR_U8) {
                    out[c] = table[image.bytes[i]];
                } else if (image.type == LCOR_U16) {
                    uint16_t stored;
                    std::memcpy(&stored, &image.bytes[i * sizeof stored], sizeof stored);
                    out[c] = table[stored];
                } else {
                    out[c] =
                        to_stored(lcor_transfer_to_linear(&transfer, image.sample(x, y, pick[c])));
                }
            }
    levels_.push_back(std::move(base));
    while (levels_.back().width > 1 || levels_.back().height > 1)
        levels_.push_back(halved(levels_.back()));
}

MipTexture::Level MipTexture::halved(const Level &from) const
{
    Level to{(from.width + 1) / 2, (from.height + 1) / 2, {}};
    to.texels.resize(to.width * to.height * STRIDE);
    const std::vector<Cover> columns = covers(from.width, to.width);
    const std::vector<Cover> rows = covers(from.height, to.height);
    std::vector<float> sums(from.width * STRIDE);
    uint16_t *out = to.texels.data();
    for (const Cover &row : rows) {
        std::fill(sums.begin(), sums.end(), 0.0F);
        for (size_t k = 0; k < 3; k++) {
            if (row.weights[k] <= 0.0F)
                continue;
            const uint16_t *const in = &from.texels[(row.first + k) * from.width * STRIDE];
            for (size_t i = 0; i < sums.size(); i++)
                sums[i] += row.weights[k] * static_cast<float>(in[i]);
        }
        for (const Cover &column : columns) {
            for (size_t c = 0; c < STRIDE; c++) {
                float sum = 0.5F; /* rounds */
                for (size_t k = 0; k < 3; k++)
                    if (column.weights[k] > 0.0F)
                        sum += column.weights[k] * sums[(column.first + k) * STRIDE + c];
                out[c] = static_cast<uint16_t>(std::min(sum, 65535.0F));
            }
            out += STRIDE;
        }
    }
    return to;
}

size_t MipTexture::wrapped(double texel, size_t size, Wrap wrap) const
{
    const double length = static_cast<double>(size);
    double at = texel;
    if (wrap == Wrap::repeat) {
        at -= length * std::floor(at / length);
    } else if (wrap == Wrap::mirror) {
        at -= 2.0 * length * std::floor(at / (2.0 * length));
        at = at < length ? at : 2.0 * length - 1.0 - at;
    }
    return static_cast<size_t>(std::clamp(at, 0.0, length - 1.0));
}

void MipTexture::add_bilinear(const Level &level, double u, double v, float weight,
                              float *sum) const
{
    const double x = u * static_cast<double>(level.width) - 0.5;
    const double y = v * static_cast<double>(level.height) - 0.5;
    const double left = std::floor(x), top = std::floor(y);
    const float s = static_cast<float>(x - left), t = static_cast<float>(y - top);
    size_t i0, i1, j0, j1;
    if (left >= 0.0 && top >= 0.0 && left + 1.0 < static_cast<double>(level.width) &&
        top + 1.0 < static_cast<double>(level.height)) {
        i0 = static_cast<size_t>(left);
        j0 = static_cast<size_t>(top);
        i1 = i0 + 1;
        j1 = j0 + 1;
    } else {
        i0 = wrapped(left, level.width, wrap_u_);
        i1 = wrapped(left + 1.0, level.width, wrap_u_);
        j0 = wrapped(top, level.height, wrap_v_);
        j1 = wrapped(top + 1.0, level.height, wrap_v_);
    }
    const uint16_t *const upper = &level.texels[j0 * level.width * STRIDE];
    const uint16_t *const lower = &level.texels[j1 * level.width * STRIDE];
    const float w00 = weight * (1.0F - s) * (1.0F - t), w10 = weight * s * (1.0F - t);
    const float w01 = weight * (1.0F - s) * t, w11 = weight * s * t;
    for (size_t c = 0; c < STRIDE; c++)
        sum[c] += w00 * static_cast<float>(upper[i0 * STRIDE + c]) +
                  w10 * static_cast<float>(upper[i1 * STRIDE + c]) +
                  w01 * static_cast<float>(lower[i0 * STRIDE + c]) +
                  w11 * static_cast<float>(lower[i1 * STRIDE + c]);
}

void MipTexture::add_probe(double u, double v, const Footprint &footprint, float weight,
                           float *sum) const
{
    const float finer = 1.0F - footprint.coarser;
    add_bilinear(levels_[footprint.level], u, v, weight * finer, sum);
    if (footprint.coarser > 0.0F)
        add_bilinear(levels_[footprint.level + 1], u, v, weight * footprint.coarser, sum);
}

std::array<float, 3> MipTexture::sample(const double place[2], const double across[2],
                                        const double down[2]) const
{
    const double width = static_cast<double>(levels_[0].width);
    const double height = static_cast<double>(levels_[0].height);
    /* A pixel's image in texels is an ellipse, J times the unit circle: axes of J J^T. */
    const double ax = across[0] * width, ay = across[1] * height;
    const double bx = down[0] * width, by = down[1] * height;
    const double p = ax * ax + bx * bx, q = ax * ay + bx * by, r = ay * ay + by * by;
    const double middle = 0.5 * (p + r), half = 0.5 * (p - r);
    const double spread = std::sqrt(half * half + q * q);
    const double longer = std::sqrt(middle + spread);
    double shorter = std::sqrt(std::max(middle - spread, 0.0));
    Footprint footprint = {{0.0, 0.0}, 1, 0, 0.0F};
    shorter = std::max({shorter, longer / most_probes, 1.0});
    if (!(longer < 1e9)) { /* seen edge-on: the whole picture */
        footprint.level = levels_.size() - 1;
    } else if (longer > 1.0) {
        footprint.count = static_cast<int>(std::ceil(longer / shorter - 1e-6));
        /* Direction of the longer axis: the larger of the two forms of the eigenvector. */
        const double ex = half >= 0.0 ? spread + half : q, ey = half >= 0.0 ? q : spread - half;
        const double length = std::sqrt(ex * ex + ey * ey);
        const double scale = length > 0.0 ? longer / length / footprint.count : 0.0;
        footprint.step[0] = ex * scale / width;
        footprint.step[1] = ey * scale / height;
        int exponent;
        const double mantissa = std::frexp(shorter, &exponent); /* 0.5..1, shorter >= 1 */
        footprint.level = std::min(static_cast<size_t>(exponent - 1), levels_.size() - 1);
        if (footprint.level + 1 < levels_.size())
            footprint.coarser = static_cast<float>(2.0 * mantissa - 1.0);
    }
    float sum[STRIDE] = {};
    if (nearest_ && longer <= 1.0) {
        const size_t x = wrapped(std::floor(place[0] * width), levels_[0].width, wrap_u_);
        const size_t y = wrapped(std::floor(place[1] * height), levels_[0].height, wrap_v_);
        for (size_t c = 0; c < 3; c++)
            sum[c] = static_cast<float>(levels_[0].texels[(y * levels_[0].width + x) * STRIDE + c]);
    } else {
        const float weight = 1.0F / static_cast<float>(footprint.count);
        const double first = -0.5 * (footprint.count - 1);
        for (int i = 0; i < footprint.count; i++)
            add_probe(place[0] + (first + i) * footprint.step[0],
                      place[1] + (first + i) * footprint.step[1], footprint, weight, sum);
    }
    constexpr float unit = 1.0F / 65535.0F;
    return {sum[0] * unit, sum[1] * unit, sum[2] * unit};
}

} // namespace cli
