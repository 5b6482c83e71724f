/* SPDX-License-Identifier: MIT */
#include "aov.h"
#include "stream.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

enum class Aov {
    illuminance,
    direct,
    indirect,
    alpha,
    reflectance,
    r,
    beta,
    k,
    luminance,
    clip,
    gamut,
    depth,
    normal,
    uv,
    surface,
    false_colour
};

/* How the pieces of a pixel make one value, and how 8 or 16 bits hold it. */
enum class Mix { mean, largest };
enum class Range { free, unit, sign }; /* any number; 0..1; -1..1, stored as 0..1 */

struct Kind {
    Aov what;
    const char *name;
    size_t channels;
    Mix mix;
    Range range;
    const char *about;
};

const Kind kinds[] = {
    {Aov::illuminance, "illuminance", 1, Mix::mean, Range::free, "lux"},
    {Aov::direct, "direct", 1, Mix::mean, Range::free, "lux straight from lights without area"},
    {Aov::indirect, "indirect", 1, Mix::mean, Range::free, "lux from surfaces"},
    {Aov::alpha, "alpha", 1, Mix::mean, Range::unit, "part of the pixel that shows a surface"},
    {Aov::reflectance, "reflectance", 1, Mix::mean, Range::unit, "rho of the surface"},
    {Aov::r, "r", 1, Mix::mean, Range::free, "virtual reflectance: illuminance times rho [lm/m2]"},
    {Aov::beta, "beta", 1, Mix::mean, Range::free, "lightness correction coefficient (eq 12)"},
    {Aov::k, "k", 1, Mix::mean, Range::free, "chroma factor (eq 16), before the gamut rule"},
    {Aov::luminance, "H", 1, Mix::mean, Range::unit, "display luminance over Jmax (eq 10)"},
    {Aov::clip, "clip", 1, Mix::largest, Range::sign,
     "-1 darker, 1 lighter than the device shows (eq 8)"},
    {Aov::gamut, "gamut", 1, Mix::largest, Range::unit, "1 where the colour left RGB 0..1"},
    {Aov::depth, "depth", 1, Mix::largest, Range::free, "distance along the camera's axis"},
    {Aov::normal, "normal", 3, Mix::largest, Range::sign, "towards the camera"},
    {Aov::uv, "uv", 2, Mix::largest, Range::free, "place along the surface's edges"},
    {Aov::surface, "surface", 1, Mix::largest, Range::free, "number of the surface, -1 for none"},
    {Aov::false_colour, "false-colour", 3, Mix::mean, Range::unit,
     "illuminance as colours, with its scale"},
};

/* CIE 1976 f of eqs 2-4 and the lightness' part of it. */
double lightness_f(double y)
{
    return y > 216.0 / 24389.0 ? std::cbrt(y) : (24389.0 / 27.0 * y + 16.0) / 116.0;
}

/* Values of the samples of one row. */
class RowValues
{
  public:
    RowValues(const AovInput &input, const Kind &kind) : input_(input), kind_(kind) {}

    /* `out`: channels a sample. */
    void row(size_t y, std::vector<float> &out)
    {
        const Picture &picture = input_.picture;
        picture.row(y, true, row_);
        out.assign(picture.samples(y) * kind_.channels, 0.0F);
        size_t count, at = 0;
        const lcor_span *const spans = lcor_view_row(picture.view(), y, &count);
        for (size_t i = 0; i < count; i++) {
            const size_t n = spans[i].x1 - spans[i].x0;
            places_.resize(n);
            lcor_view_places(picture.view(), y, &spans[i], spans[i].x0, n, places_.data());
            for (size_t k = 0; k < n; k++, at++)
                sample(spans[i].surface, y, k, at, &out[at * kind_.channels]);
        }
    }

  private:
    void sample(size_t surface, size_t y, size_t k, size_t at, float *out) const
    {
        double normal[3];
        switch (kind_.what) {
        case Aov::illuminance:
        case Aov::false_colour: *out = static_cast<float>(input_.picture.illuminance(y, at)); break;
        case Aov::direct: *out = static_cast<float>(direct(surface, k)); break;
        case Aov::indirect:
            *out = static_cast<float>(
                std::max(input_.picture.illuminance(y, at) - direct(surface, k), 0.0));
            break;
        case Aov::alpha: *out = 1.0F; break;
        case Aov::reflectance:
            *out = static_cast<float>(input_.picture.scene().surfaces[surface].reflectance);
            break;
        case Aov::r: *out = static_cast<float>(r(at)); break;
        case Aov::beta:
            *out = rho(at) > 0.0 ? static_cast<float>(target(at) / rho(at)) : 0.0F;
            break;
        case Aov::k: *out = static_cast<float>(chroma_factor(at)); break;
        case Aov::luminance: *out = static_cast<float>(display_luminance(at)); break;
        case Aov::clip: *out = static_cast<float>(clipped(at)); break;
        case Aov::gamut: *out = left_gamut(at) ? 1.0F : 0.0F; break;
        case Aov::depth: *out = static_cast<float>(places_[k].depth); break;
        case Aov::normal:
            lcor_view_normal(input_.picture.view(), surface, normal);
            std::copy(normal, normal + 3, out);
            break;
        case Aov::uv: std::copy(places_[k].uv, places_[k].uv + 2, out); break;
        case Aov::surface: *out = static_cast<float>(surface); break;
        }
    }

    double direct(size_t surface, size_t k) const
    {
        lcor_error error = {};
        lcor_field_report report;
        double values[3];
        lcor_field_get_report(input_.picture.field(), &report);
        check(lcor_field_at(input_.picture.field(), surface, 1, places_[k].uv, nullptr, values,
                            &error),
              error, Exit::failed, "direct light");
        return input_.picture.scene().luminance(values, report.channels);
    }

    double rho(size_t at) const { return static_cast<double>(row_.rho[at]); }
    double r(size_t at) const { return static_cast<double>(row_.illuminance[at]) * rho(at); }
    double q(size_t at) const { return input_.r_mean > 0.0 ? r(at) / input_.r_mean : 0.0; }
    double texel(size_t at) const
    {
        const double *const row = input_.picture.scene().colour.to_xyz + 3;
        return row[0] * static_cast<double>(row_.rgb[3 * at]) +
               row[1] * static_cast<double>(row_.rgb[3 * at + 1]) +
               row[2] * static_cast<double>(row_.rgb[3 * at + 2]);
    }

    /* beta rho (eq 12), for the texel's own r when that is the reading. */
    double target(size_t at) const
    {
        const bool own = input_.correction.reading == LCOR_READING_TEXEL;
        const double part = own && rho(at) > 0.0 ? q(at) * texel(at) / rho(at) : q(at);
        return 0.5 + 0.5 * (std::pow(part, input_.correction.exponent) - 1.0) *
                         (1.0 + 2.0 / (input_.device.contrast - 1.0));
    }

    double new_reflectance(size_t at) const /* eq 11 */
    {
        const bool own = input_.correction.reading == LCOR_READING_TEXEL;
        return std::clamp(own || rho(at) <= 0.0 ? target(at) : target(at) * texel(at) / rho(at),
                          0.0, 1.0);
    }

    double chroma_factor(size_t at) const /* eq 16 */
    {
        const double before = lightness_f(texel(at)), after = lightness_f(new_reflectance(at));
        constexpr double black = 4.0 / 29.0;
        if (after <= before)
            return before > black ? (after - black) / (before - black) : 1.0;
        return before < 1.0 ? (1.0 - after) / (1.0 - before) : 1.0;
    }

    /* What the pixel's colour shows, whatever the method. */
    double display_luminance(size_t at) const
    {
        const std::array<float, 3> rgb = developed(at, nullptr);
        const double *const row = input_.picture.scene().colour.to_xyz + 3;
        double y = 0.0;
        for (size_t c = 0; c < 3; c++)
            y += row[c] * static_cast<double>(rgb[c]);
        return std::isinf(input_.device.contrast)
                   ? y
                   : (1.0 + y * (input_.device.contrast - 1.0)) / input_.device.contrast;
    }

    double clipped(size_t at) const
    {
        const double t = target(at);
        return t < 0.0 ? -1.0 : t > 1.0 ? 1.0 : 0.0;
    }

    bool left_gamut(size_t at) const
    {
        lcor_row_stats stats = {};
        developed(at, &stats);
        return stats.out_of_gamut > 0;
    }

    std::array<float, 3> developed(size_t at, lcor_row_stats *stats) const
    {
        Picture::Row one;
        one.rgb.assign(&row_.rgb[3 * at], &row_.rgb[3 * at] + 3);
        one.illuminance = {row_.illuminance[at]};
        one.rho = {row_.rho[at]};
        input_.developer.samples(0, one, stats);
        return {one.rgb[0], one.rgb[1], one.rgb[2]};
    }

    const AovInput &input_;
    const Kind &kind_;
    Picture::Row row_;
    std::vector<lcor_place> places_;
};

/* Samples -> pixels. */
void mix_row(const Picture &picture, const Kind &kind, size_t y, const std::vector<float> &samples,
             float *out)
{
    const size_t n = kind.channels;
    size_t count;
    const lcor_span *const spans = lcor_view_row(picture.view(), y, &count);
    std::vector<float> covered(picture.width(), 0.0F);
    const bool none = kind.what == Aov::surface || kind.what == Aov::false_colour;
    std::fill_n(out, n * picture.width(), none ? -1.0F : 0.0F);
    const float *value = samples.data();
    for (size_t i = 0; i < count; i++)
        for (size_t x = spans[i].x0; x < spans[i].x1; x++, value += n) {
            const bool first = covered[x] == 0.0F;
            covered[x] += spans[i].coverage;
            for (size_t c = 0; c < n; c++) {
                float &pixel = out[n * x + c];
                if (kind.mix == Mix::mean)
                    pixel =
                        first ? spans[i].coverage * value[c] : pixel + spans[i].coverage * value[c];
                else if (first) /* pieces come largest first */
                    pixel = value[c];
            }
        }
    for (size_t x = 0; x < picture.width() && kind.mix == Mix::mean && kind.what != Aov::alpha; x++)
        for (size_t c = 0; c < n && covered[x] > 0.0F && covered[x] < 1.0F; c++)
            out[n * x + c] /= covered[x];
}

std::vector<float> values_of(const AovInput &input, const Kind &kind)
{
    const Picture &picture = input.picture;
    Kind plain = kind;
    if (kind.what == Aov::false_colour)
        plain.channels = 1;
    const size_t row = picture.width() * plain.channels;
    std::vector<float> pixels(row * picture.height());
    picture.each_band(0, picture.height(), [&](size_t y0, size_t y1) {
        RowValues values(input, plain);
        std::vector<float> samples;
        for (size_t y = y0; y < y1; y++) {
            values.row(y, samples);
            mix_row(picture, plain, y, samples, &pixels[y * row]);
        }
    });
    return pixels;
}

} // namespace

std::string aov_list()
{
    std::string text;
    for (const Kind &kind : kinds)
        text += format("%-13s %s", kind.name, kind.about) + "\n"; /* format() makes one line */
    return text;
}

std::vector<AovRequest> parse_aovs(const std::vector<std::string> &texts)
{
    std::vector<AovRequest> requests;
    for (const std::string &text : texts) {
        const size_t equals = text.find('=');
        const std::string name = text.substr(0, equals);
        if (equals == std::string::npos || equals + 1 == text.size())
            fail(Exit::usage, "--aov wants NAME=FILE, not '%s'; `--aov list` names what there is",
                 text.c_str());
        const auto kind = std::find_if(std::begin(kinds), std::end(kinds),
                                       [&](const Kind &k) { return name == k.name; });
        if (kind == std::end(kinds))
            fail(Exit::usage, "--aov: there is no '%s'; `--aov list` names what there is",
                 name.c_str());
        const std::string path = text.substr(equals + 1);
        if (kind->range == Range::free && !holds_floats(path))
            fail(Exit::usage, "--aov %s: its values need floats; write .exr or .tif", text.c_str());
        requests.push_back({static_cast<size_t>(kind - std::begin(kinds)), path});
    }
    return requests;
}

void write_aov(const AovRequest &request, const AovInput &input, const Provenance &provenance)
{
    const Kind &kind = kinds[request.kind];
    const Picture &picture = input.picture;
    std::vector<float> pixels = values_of(input, kind);
    if (kind.what == Aov::false_colour) {
        write_false_colour(request.path, pixels, picture.width(), picture.height(), provenance);
        return;
    }
    const bool floats = holds_floats(request.path);
    if (!floats && kind.range == Range::sign)
        for (float &value : pixels)
            value = 0.5F + 0.5F * value;
    OIIO::ImageSpec spec(static_cast<int>(picture.width()), static_cast<int>(picture.height()),
                         static_cast<int>(kind.channels),
                         floats ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
    describe(spec, provenance);
    PictureWriter writer(request.path, spec);
    writer.write(0, picture.height(), OIIO::TypeDesc::FLOAT, pixels.data());
    writer.commit();
}

} // namespace cli
