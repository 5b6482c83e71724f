/* SPDX-License-Identifier: MIT */
/* Reflectance of textured surfaces: the area mean of what is drawn on them. */
#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

constexpr double sample_budget = 2e7;

double wrapped(double t, Wrap wrap)
{
    switch (wrap) {
    case Wrap::clamp: return std::clamp(t, 0.0, 1.0);
    case Wrap::mirror: return 1.0 - std::fabs(t - 2.0 * std::floor(0.5 * t) - 1.0);
    case Wrap::repeat: break;
    }
    return t - std::floor(t);
}

bool whole_number(double x) { return std::fabs(x - std::round(x)) < 1e-5; }

/* Does the quad show whole copies of the picture, so that its mean is the picture's? */
bool shows_whole_pictures(const Shape &shape, const Texture &texture)
{
    if (!shape.quad)
        return false;
    const auto &o = shape.corner[0].uv, &a = shape.corner[1].uv, &b = shape.corner[3].uv;
    const double du[2] = {a[0] - o[0], a[1] - o[1]}, dv[2] = {b[0] - o[0], b[1] - o[1]};
    const bool straight = std::fabs(du[1]) < 1e-5 && std::fabs(dv[0]) < 1e-5;
    const bool turned = std::fabs(du[0]) < 1e-5 && std::fabs(dv[1]) < 1e-5;
    if (!straight && !turned)
        return false;
    const double extent_u = straight ? du[0] : dv[0], extent_v = straight ? dv[1] : du[1];
    const auto whole = [](double start, double extent, Wrap wrap) {
        if (!whole_number(extent) || std::fabs(extent) < 0.5)
            return false;
        if (wrap == Wrap::repeat)
            return true;
        if (!whole_number(start))
            return false;
        return wrap == Wrap::mirror ||
               (std::fabs(extent) < 1.5 && std::fabs(start + 0.5 * extent - 0.5) < 1e-4);
    };
    return whole(o[0], extent_u, texture.wrap_u) && whole(o[1], extent_v, texture.wrap_v);
}

bool same_colour(const Shape &shape)
{
    for (size_t i = 1; i < (shape.quad ? 4U : 3U); i++)
        if (length(shape.corner[i].colour - shape.corner[0].colour) > 1e-9)
            return false;
    return true;
}

Vec3 times(const Vec3 &a, const Vec3 &b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

std::vector<double> linear_table(size_t size)
{
    lcor_colour srgb;
    lcor_error error = {};
    check(lcor_colour_init(&srgb, LCOR_PRIMARIES_SRGB, nullptr, LCOR_TRANSFER_SRGB, 1.0,
                           LCOR_LIGHTNESS_CIE, &error),
          error, Exit::failed, "sRGB");
    std::vector<double> table(size);
    for (size_t i = 0; i < size; i++)
        table[i] =
            lcor_transfer_to_linear(&srgb, static_cast<double>(i) / static_cast<double>(size - 1));
    return table;
}

} // namespace

TextureMeans::TextureMeans(const Contents &contents, size_t shapes)
    : contents_(contents),
      most_samples_(static_cast<size_t>(
          std::clamp(std::sqrt(sample_budget / static_cast<double>(shapes + 1)), 8.0, 128.0))),
      linear_u8_(linear_table(256)), whole_(contents.images.size(), Vec3{-1.0, -1.0, -1.0})
{
    for (const Image &image : contents.images)
        if (image.type == LCOR_U16 && linear_u16_.empty())
            linear_u16_ = linear_table(65536);
}

double TextureMeans::linear(const Image &image, bool srgb, size_t x, size_t y, size_t channel) const
{
    const size_t i = (y * image.width + x) * image.channels + channel;
    if (srgb && image.type == LCOR_U8)
        return linear_u8_[image.bytes[i]];
    if (srgb && image.type == LCOR_U16) {
        uint16_t value;
        std::memcpy(&value, &image.bytes[2 * i], sizeof value);
        return linear_u16_[value];
    }
    const double value = image.sample(x, y, channel);
    return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.0;
}

Vec3 TextureMeans::whole(size_t index, bool srgb)
{
    Vec3 &known = whole_[index];
    if (known[0] >= 0.0)
        return known;
    const Image &image = contents_.images[index];
    const size_t step = image.channels >= 3 ? 1 : 0;
    Vec3 sum{0.0, 0.0, 0.0};
    for (size_t y = 0; y < image.height; y++) {
        Vec3 row{0.0, 0.0, 0.0};
        for (size_t x = 0; x < image.width; x++)
            for (size_t c = 0; c < 3; c++)
                row[c] += linear(image, srgb, x, y, c * step);
        sum = sum + row;
    }
    known = 1.0 / static_cast<double>(image.width * image.height) * sum;
    return known;
}

Vec3 TextureMeans::texel(const Texture &texture, double u, double v) const
{
    const Image &image = contents_.images[texture.image];
    const auto index = [](double t, size_t size) {
        return std::min(static_cast<size_t>(t * static_cast<double>(size)), size - 1);
    };
    const size_t x = index(wrapped(u, texture.wrap_u), image.width);
    const size_t y = index(wrapped(v, texture.wrap_v), image.height);
    const size_t step = image.channels >= 3 ? 1 : 0;
    return {linear(image, texture.srgb, x, y, 0), linear(image, texture.srgb, x, y, step),
            linear(image, texture.srgb, x, y, 2 * step)};
}

Vec3 TextureMeans::mean(int texture, const Shape &shape)
{
    if (texture < 0) {
        /* Colours vary linearly: their mean over a triangle or parallelogram is the corners'. */
        const size_t n = shape.quad ? 4 : 3;
        Vec3 sum{0.0, 0.0, 0.0};
        for (size_t i = 0; i < n; i++)
            sum = sum + shape.corner[i].colour;
        return 1.0 / static_cast<double>(n) * sum;
    }
    const Texture &drawn = contents_.textures[static_cast<size_t>(texture)];
    if (shows_whole_pictures(shape, drawn) && same_colour(shape))
        return times(whole(drawn.image, drawn.srgb), shape.corner[0].colour);

    const Vertex &o = shape.corner[0], &a = shape.corner[1], &b = shape.corner[shape.quad ? 3 : 2];
    const Image &image = contents_.images[drawn.image];
    double texels = 1.0;
    for (const Vertex *end : {&a, &b})
        texels = std::max(texels,
                          std::hypot((end->uv[0] - o.uv[0]) * static_cast<double>(image.width),
                                     (end->uv[1] - o.uv[1]) * static_cast<double>(image.height)));
    const size_t n = static_cast<size_t>(
        std::clamp(std::ceil(2.0 * texels), 8.0, static_cast<double>(most_samples_)));
    Vec3 sum{0.0, 0.0, 0.0};
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            double s = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
            double t = (static_cast<double>(j) + 0.5) / static_cast<double>(n);
            if (!shape.quad) {
                /* The unit square onto the triangle, equal areas to equal areas. */
                const double root = std::sqrt(s);
                s = root * (1.0 - t);
                t = root * t;
            }
            const Vec3 colour = o.colour + s * (a.colour - o.colour) + t * (b.colour - o.colour);
            sum = sum +
                  times(colour,
                        texel(drawn, o.uv[0] + s * (a.uv[0] - o.uv[0]) + t * (b.uv[0] - o.uv[0]),
                              o.uv[1] + s * (a.uv[1] - o.uv[1]) + t * (b.uv[1] - o.uv[1])));
        }
    return 1.0 / static_cast<double>(n * n) * sum;
}

} // namespace cli
