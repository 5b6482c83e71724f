/* SPDX-License-Identifier: MIT */
#include "picture.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

/* A lamp's own colour may be black: its light is shown as if a surface of this reflectance had it.
 */
constexpr double lamp_reflectance = 0.05;
/* Rows of one task, and rows between reports of progress. */
constexpr size_t band_rows = 8, block_rows = 256;

} // namespace

Picture::Picture(const Scene &scene, const lcor_solution *solution, const lcor_camera &camera,
                 double tolerance, Threads &threads)
    : scene_(scene), camera_(camera), threads_(threads)
{
    std::vector<unsigned char> cull;
    for (const SurfaceInfo &surface : scene.surfaces)
        cull.push_back(surface.back_to_back || !scene.materials[surface.material].double_sided);
    lcor_view_options view_options = {};
    view_options.struct_size = sizeof view_options;
    view_options.cull_back = cull.data();
    lcor_error error = {};
    lcor_view *view = nullptr;
    check(lcor_view_new(scene.scene.get(), &camera, &view_options, &view, &error), error,
          Exit::input, "camera");
    view_.reset(view);
    Progress progress("indirect light");
    lcor_field_options field_options = {};
    field_options.struct_size = sizeof field_options;
    field_options.tolerance = tolerance;
    field_options.parallel = threads.parallel();
    field_options.progress = progress.callback();
    lcor_field *field = nullptr;
    check(lcor_field_new(solution, view, &field_options, &field, &error), error, Exit::failed,
          "indirect light");
    field_.reset(field);
    prepare_surfaces();
    light();
}

void Picture::prepare_textures()
{
    lcor_colour srgb, linear;
    lcor_error error = {};
    for (const auto &[colour, transfer] :
         {std::pair{&srgb, LCOR_TRANSFER_SRGB}, std::pair{&linear, LCOR_TRANSFER_LINEAR}})
        check(lcor_colour_init(colour, LCOR_PRIMARIES_SRGB, nullptr, transfer, 1.0,
                               LCOR_LIGHTNESS_CIE, &error),
              error, Exit::failed, "texture");
    textures_.resize(scene_.textures.size());
    threads_.run(textures_.size(), [&](size_t i) {
        const Texture &texture = scene_.textures[i];
        textures_[i] = std::make_unique<MipTexture>(scene_.images[texture.image], texture,
                                                    texture.srgb ? srgb : linear);
    });
}

void Picture::prepare_surfaces()
{
    prepare_textures();
    for (size_t i = 0; i < scene_.surfaces.size(); i++) {
        const SurfaceInfo &info = scene_.surfaces[i];
        const Material &material = scene_.materials[info.material];
        const auto texture = [&](int index) {
            return index < 0 ? nullptr : textures_[static_cast<size_t>(index)].get();
        };
        Surface surface = {};
        surface.texture = texture(material.texture);
        surface.emission_texture = texture(material.emission_texture);
        std::copy(&info.uv[0][0], &info.uv[0][0] + 6, &surface.uv[0][0]);
        for (size_t k = 0; k < 3; k++)
            for (size_t c = 0; c < 3; c++)
                surface.colour[k][c] = info.colour[k][c] * material.colour[c];
        double normal[3];
        const bool front = lcor_view_normal(view_.get(), i, normal) != 0;
        const bool shines = front || (material.double_sided && !info.back_to_back);
        for (size_t c = 0; c < 3 && shines; c++)
            surface.emission[c] = pi * material.emission[c];
        surface.emits = surface.emission[0] + surface.emission[1] + surface.emission[2] > 0.0;
        surface.ratio =
            info.texture_reflectance > 0.0 ? info.reflectance / info.texture_reflectance : 1.0;
        surface.rho = info.texture_reflectance;
        if (surface.emits)
            surface.rho = std::max(surface.rho, lamp_reflectance);
        surfaces_.push_back(surface);
    }
}

double Picture::illuminance(size_t y, size_t sample) const
{
    double values[3] = {};
    std::copy_n(&light_[(rows_[y] + sample) * channels_], channels_, values);
    return scene_.luminance(values, static_cast<int>(channels_));
}

bool Picture::opaque() const
{
    for (size_t y = 0; y < height(); y++) {
        size_t count;
        const lcor_span *const spans = lcor_view_row(view_.get(), y, &count);
        double covered = 0.0;
        for (size_t i = 0; i < count; i++)
            covered += static_cast<double>(spans[i].coverage) * (spans[i].x1 - spans[i].x0);
        if (covered < static_cast<double>(width()) - 1e-3)
            return false;
    }
    return true;
}

void Picture::each_band(size_t y0, size_t y1, const std::function<void(size_t, size_t)> &task) const
{
    threads_.run((y1 - y0 + band_rows - 1) / band_rows, [&](size_t i) {
        const size_t from = y0 + i * band_rows;
        task(from, std::min(from + band_rows, y1));
    });
}

/* Illuminance of all samples: once, since both the mean and the correction need it. */
void Picture::light()
{
    lcor_field_report report;
    lcor_field_get_report(field_.get(), &report);
    channels_ = static_cast<size_t>(report.channels);
    rows_.assign(height() + 1, 0);
    for (size_t y = 0; y < height(); y++) {
        size_t count;
        const lcor_span *const spans = lcor_view_row(view_.get(), y, &count);
        rows_[y + 1] = rows_[y];
        for (size_t i = 0; i < count; i++)
            rows_[y + 1] += spans[i].x1 - spans[i].x0;
    }
    light_.resize(rows_.back() * channels_);
    Progress progress("illuminance");
    for (size_t y0 = 0; y0 < height(); y0 += block_rows) {
        const size_t y1 = std::min(y0 + block_rows, height());
        each_band(y0, y1, [this](size_t from, size_t to) {
            for (size_t y = from; y < to; y++)
                light_row(y);
        });
        progress.report(static_cast<double>(y1) / static_cast<double>(height()));
    }
}

void Picture::light_row(size_t y)
{
    size_t count;
    const lcor_span *const spans = lcor_view_row(view_.get(), y, &count);
    float *out = light_.data() + rows_[y] * channels_;
    std::vector<lcor_place> places(width());
    std::vector<double> uv(2 * width()), total(channels_ * width());
    lcor_error error = {};
    for (size_t i = 0; i < count; i++) {
        const size_t n = spans[i].x1 - spans[i].x0;
        lcor_view_places(view_.get(), y, &spans[i], spans[i].x0, n, places.data());
        for (size_t k = 0; k < n; k++)
            std::copy_n(places[k].uv, 2, &uv[2 * k]);
        check(lcor_field_at(field_.get(), spans[i].surface, n, uv.data(), total.data(), nullptr,
                            &error),
              error, Exit::failed, "illuminance");
        for (size_t k = 0; k < n * channels_; k++)
            *out++ = static_cast<float>(total[k]);
    }
}

/* Filtered colour of a place: texel times factor and vertex colour. */
static std::array<float, 3> texel(const MipTexture *texture, const double (&uv)[3][2],
                                  const lcor_place &at)
{
    if (!texture)
        return {1.0F, 1.0F, 1.0F};
    double place[2], across[2], down[2];
    for (size_t k = 0; k < 2; k++) {
        place[k] = uv[0][k] + at.uv[0] * uv[1][k] + at.uv[1] * uv[2][k];
        across[k] = at.du[0] * uv[1][k] + at.dv[0] * uv[2][k];
        down[k] = at.du[1] * uv[1][k] + at.dv[1] * uv[2][k];
    }
    return texture->sample(place, across, down);
}

std::array<double, 3> Picture::emission(const Surface &surface, const lcor_place &at) const
{
    const std::array<float, 3> factor = texel(surface.emission_texture, surface.uv, at);
    std::array<double, 3> out;
    for (size_t c = 0; c < 3; c++)
        out[c] = surface.emission[c] * static_cast<double>(factor[c]);
    return out;
}

/* Under coloured light, or with light of its own, a surface has the colour X / E, X its exitance in
 * each channel and E the illuminance that gives the luminous exitance at the surface's rho. */
void Picture::row(size_t y, bool with_colour, Row &out) const
{
    size_t count, at = 0;
    const lcor_span *const spans = lcor_view_row(view_.get(), y, &count);
    const float *light = light_.data() + rows_[y] * channels_;
    std::vector<lcor_place> places(width());
    out.illuminance.resize(samples(y));
    out.rho.resize(samples(y));
    out.rgb.resize(with_colour ? 3 * samples(y) : 0);
    for (size_t i = 0; i < count; i++) {
        const Surface &surface = surfaces_[spans[i].surface];
        const size_t n = spans[i].x1 - spans[i].x0;
        if (with_colour || surface.emits)
            lcor_view_places(view_.get(), y, &spans[i], spans[i].x0, n, places.data());
        for (size_t k = 0; k < n; k++, at++, light += channels_) {
            double e[3];
            for (size_t c = 0; c < 3; c++)
                e[c] = surface.ratio * static_cast<double>(light[channels_ == 3 ? c : 0]);
            std::array<double, 3> own{};
            if (surface.emits)
                own = emission(surface, places[k]);
            double all = scene_.luminance(e, static_cast<int>(channels_));
            if (surface.emits)
                all += scene_.luminance(own.data(), 3) / surface.rho;
            out.illuminance[at] = static_cast<float>(all);
            out.rho[at] = static_cast<float>(surface.rho);
            if (!with_colour)
                continue;
            const std::array<float, 3> drawn = texel(surface.texture, surface.uv, places[k]);
            for (size_t c = 0; c < 3; c++) {
                double value = static_cast<double>(drawn[c]) *
                               (surface.colour[0][c] + places[k].uv[0] * surface.colour[1][c] +
                                places[k].uv[1] * surface.colour[2][c]);
                if ((channels_ == 3 || surface.emits) && all > 0.0)
                    value = (value * e[c] + own[c]) / all;
                out.rgb[3 * at + c] = static_cast<float>(std::max(value, 0.0));
            }
        }
    }
}

} // namespace cli
