/* SPDX-License-Identifier: MIT */
/* `lcor correct`: a picture of any size in two streaming passes, the mean and the correction. */
#include "picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

enum { CHUNK_ROWS = 8, CURVE_STEPS = 65536 };
constexpr size_t band_bytes = size_t(3) << 20;

struct PlanDeleter {
    void operator()(lcor_plan *plan) const { lcor_plan_free(plan); }
};
using PlanPointer = std::unique_ptr<lcor_plan, PlanDeleter>;

struct Job {
    std::string texture, map, output;
    std::optional<double> rho, measured;
    int depth = 0; /* index into depths */
    DeviceOptions device_options;
    CorrectionOptions correction;
};

const std::vector<std::string> depths{"same", "8", "16", "half", "float"};

/* What samples are while lcor works on them: no coarser than either file. */
struct Samples {
    lcor_sample kind;
    OIIO::TypeDesc type;
};

Samples working_samples(OIIO::TypeDesc in, OIIO::TypeDesc out, bool premultiplied)
{
    const auto is = [&](OIIO::TypeDesc::BASETYPE type) { return in.basetype == type || out.basetype == type; };
    const auto coarse = [](OIIO::TypeDesc type, bool words) {
        return type == OIIO::TypeDesc::UINT8 || (words && type == OIIO::TypeDesc::UINT16);
    };
    if (is(OIIO::TypeDesc::DOUBLE))
        return {LCOR_F64, OIIO::TypeDesc::DOUBLE};
    if (!premultiplied && coarse(in, false) && coarse(out, false))
        return {LCOR_U8, OIIO::TypeDesc::UINT8};
    if (!premultiplied && coarse(in, true) && coarse(out, true))
        return {LCOR_U16, OIIO::TypeDesc::UINT16};
    return {LCOR_F32, OIIO::TypeDesc::FLOAT};
}

/* A few rows on their way through the stages. */
struct Band {
    size_t y0 = 0, y1 = 0;
    std::vector<uint8_t> pixels;
    MapReader::Band map;
};

/* What one chunk of rows adds to the first pass. Sums are joined in order, so that they do not
 * depend on the threads; the rest has the same bits in any order. */
struct Totals {
    double luminance = 0.0, weight = 0.0;
};

class Corrector
{
  public:
    Corrector(const Job &job, Threads &threads)
        : job_(job), threads_(threads), device_(job.device_options.load()), reader_(job.texture),
          colour_(job.correction.colour(reader_.float_samples())),
          map_(job.map, colour_, reader_.width(), reader_.height()), progress_("correcting")
    {
        if (reader_.channels() > 64)
            fail(Exit::input, "'%s' has %zu channels; lcor takes up to 64", job.texture.c_str(),
                 reader_.channels());
        colours_ = reader_.channels() >= 3 ? 3 : 1;
        alpha_ = reader_.spec().alpha_channel;
        look_at_profile();
    }

    Json run()
    {
        writer_ = std::make_unique<PictureWriter>(job_.output, output_spec());
        samples_ = working_samples(reader_.spec().format, writer_->spec().format,
                                   reader_.premultiplied() || writer_->premultiplied());
        band_rows_ = reader_.band_rows(band_bytes);
        bands_ = (reader_.height() + band_rows_ - 1) / band_rows_;
        stride_ = reader_.width() * reader_.channels() * samples_.type.size();
        make_curve();
        if (job_.correction.conventional)
            r_mean_ = 1.0;
        else
            find_means();
        correct();
        writer_->commit();
        return report();
    }

  private:
    void look_at_profile() const
    {
        const std::string icc = reader_.spec().get_string_attribute("ICCProfile:profile_description");
        if (!icc.empty() && icc.find("sRGB") == std::string::npos && job_.correction.space == LCOR_PRIMARIES_SRGB)
            warn("'%s' has the ICC profile '%s'; lcor reads its colours as sRGB and carries the profile over",
                 job_.texture.c_str(), icc.c_str());
    }

    OIIO::ImageSpec output_spec() const
    {
        OIIO::ImageSpec spec = reader_.spec();
        const OIIO::TypeDesc types[] = {spec.format, OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16,
                                        OIIO::TypeDesc::HALF, OIIO::TypeDesc::FLOAT};
        spec.set_format(types[job_.depth]);
        spec.channelformats.clear();
        spec.erase_attribute("oiio:BitsPerSample");
        if (!device_.tone_curve.empty() && !spec.format.is_floating_point() &&
            spec.find_attribute("ICCProfile")) {
            warn("the device's tone curve replaces the ICC profile of '%s'", job_.texture.c_str());
            spec.erase_attribute("ICCProfile");
        }
        spec.attribute("Software", std::string("lcor ") + lcor_version());
        return spec;
    }

    /* The output may store samples another way than the input; the curve takes linear RGB there. */
    void make_curve()
    {
        const bool to_float = writer_->spec().format.is_floating_point();
        if (!device_.tone_curve.empty() && !to_float) {
            curve_ = device_.tone_curve;
            return;
        }
        const lcor_colour out = job_.correction.colour(to_float);
        if (out.transfer == colour_.transfer)
            return;
        curve_.resize(out.transfer == LCOR_TRANSFER_LINEAR ? 2 : CURVE_STEPS);
        for (size_t i = 0; i < curve_.size(); i++)
            curve_[i] = static_cast<float>(lcor_transfer_from_linear(
                &out, static_cast<double>(i) / static_cast<double>(curve_.size() - 1)));
    }

    PlanPointer make_plan(double r_mean) const
    {
        lcor_plan_options options = job_.correction.plan(device_, colour_);
        options.r_mean = r_mean;
        options.rho = rho_;
        options.rho_ratio = ratio_;
        options.in_type = options.out_type = samples_.kind;
        const size_t step = colours_ == 3 ? reader_.channels() : 3;
        options.in_layout = options.out_layout = {step, 1};
        options.tone_curve = curve_.empty() ? nullptr : curve_.data();
        options.tone_size = curve_.size();
        lcor_plan *plan = nullptr;
        lcor_error error = {};
        check(lcor_plan_new(&options, &plan, &error), error, Exit::usage, "correction");
        return PlanPointer(plan);
    }

    /* Reading, working and writing of three neighbouring bands at once. */
    void stream(bool write, double from, double to,
                const std::function<void(Band &, size_t y0, size_t y1, size_t chunk)> &work)
    {
        std::array<Band, 3> bands;
        const size_t stages = bands_ + (write ? 2 : 1);
        for (size_t k = 0; k < stages; k++) {
            Band &reading = bands[k % 3], &working = bands[(k + 2) % 3], &writing = bands[(k + 1) % 3];
            const bool reads = k < bands_, works = k >= 1 && k - 1 < bands_, writes = write && k >= 2;
            const size_t chunks = works ? (working.y1 - working.y0 + CHUNK_ROWS - 1) / CHUNK_ROWS : 0;
            threads_.run(chunks + 2, [&](size_t task) {
                if (task == 0 && writes) {
                    writer_->write(writing.y0, writing.y1, samples_.type, writing.pixels.data());
                } else if (task == 1 && reads) {
                    read(reading, k);
                } else if (task >= 2) {
                    const size_t y0 = working.y0 + (task - 2) * CHUNK_ROWS;
                    work(working, y0, std::min(y0 + CHUNK_ROWS, working.y1), y0 / CHUNK_ROWS);
                }
            });
            progress_.report(from + (to - from) * static_cast<double>(k + 1) / static_cast<double>(stages));
        }
    }

    void read(Band &band, size_t index)
    {
        band.y0 = index * band_rows_;
        band.y1 = std::min(band.y0 + band_rows_, reader_.height());
        band.pixels.resize((band.y1 - band.y0) * stride_);
        reader_.read(band.y0, band.y1, samples_.type, band.pixels.data());
        map_.read(band.y0, band.y1, band.map);
    }

    /* Colour times alpha -> colour, in place; and back. Premultiplied samples are floats. */
    template <class T> void scale_by_alpha(uint8_t *row, bool divide) const
    {
        const size_t n = reader_.channels(), alpha = static_cast<size_t>(alpha_);
        for (size_t x = 0; x < reader_.width(); x++, row += n * sizeof(T)) {
            T pixel[64];
            std::memcpy(pixel, row, n * sizeof(T));
            const T a = pixel[alpha];
            for (size_t c = 0; c < static_cast<size_t>(colours_) && a > T(0); c++)
                pixel[c] = divide ? pixel[c] / a : pixel[c] * a;
            std::memcpy(row, pixel, n * sizeof(T));
        }
    }

    void convert_alpha(uint8_t *row, bool divide) const
    {
        if (samples_.kind == LCOR_F64)
            scale_by_alpha<double>(row, divide);
        else
            scale_by_alpha<float>(row, divide);
    }

    double sample(const uint8_t *row, size_t index) const
    {
        switch (samples_.kind) {
        case LCOR_U8: return row[index] / 255.0;
        case LCOR_U16: {
            uint16_t value;
            std::memcpy(&value, row + 2 * index, sizeof value);
            return value / 65535.0;
        }
        case LCOR_F32: {
            float value;
            std::memcpy(&value, row + 4 * index, sizeof value);
            return static_cast<double>(value);
        }
        case LCOR_F64: break;
        }
        double value;
        std::memcpy(&value, row + 8 * index, sizeof value);
        return value;
    }

    /* A grey row as three equal channels, and back. */
    void spread_grey(const uint8_t *row, std::vector<uint8_t> &rgb) const
    {
        const size_t size = samples_.type.size(), step = reader_.channels() * size;
        rgb.resize(3 * size * reader_.width());
        for (size_t x = 0; x < reader_.width(); x++)
            for (size_t c = 0; c < 3; c++)
                std::memcpy(&rgb[(3 * x + c) * size], row + x * step, size);
    }

    void gather_grey(const std::vector<uint8_t> &rgb, uint8_t *row) const
    {
        const size_t size = samples_.type.size(), step = reader_.channels() * size;
        for (size_t x = 0; x < reader_.width(); x++)
            std::memcpy(row + x * step, &rgb[(3 * x + 1) * size], size);
    }

    /* Weight of a pixel in the means: what alpha lets show. */
    void weights(const uint8_t *row, std::vector<double> &out) const
    {
        out.resize(reader_.width());
        for (size_t x = 0; x < out.size(); x++) {
            const double a = sample(row, x * reader_.channels() + static_cast<size_t>(alpha_));
            out[x] = std::isfinite(a) ? std::clamp(a, 0.0, 1.0) : 0.0;
        }
    }

    void find_means();
    Totals row_luminance(const uint8_t *row, const std::vector<double> &linear) const;
    void correct();
    Json report() const;

    const Job &job_;
    Threads &threads_;
    Device device_;
    PictureReader reader_;
    lcor_colour colour_;
    MapReader map_;
    Progress progress_;
    std::unique_ptr<PictureWriter> writer_;
    Samples samples_{};
    int colours_, alpha_;
    size_t band_rows_ = 0, bands_ = 0, stride_ = 0;
    std::vector<float> curve_;
    double texture_mean_ = 0.0, rho_ = 0.5, ratio_ = 1.0, r_mean_ = 0.0;
    uint64_t left_out_ = 0;
    lcor_row_stats stats_{};
};

/* Y of the pixels, weighted by alpha: the texture's own reflectance (section 5.2). */
Totals Corrector::row_luminance(const uint8_t *row, const std::vector<double> &linear) const
{
    const size_t n = reader_.channels();
    Totals totals;
    for (size_t x = 0; x < reader_.width(); x++) {
        double y = 0.0;
        for (size_t c = 0; c < 3; c++) {
            const size_t index = x * n + (colours_ == 3 ? c : 0);
            double value;
            if (samples_.kind == LCOR_U8)
                value = linear[row[index]];
            else
                value = lcor_transfer_to_linear(&colour_, sample(row, index));
            y += colour_.to_xyz[3 + c] * value;
        }
        const double a = alpha_ < 0 ? 1.0 : sample(row, x * n + static_cast<size_t>(alpha_));
        if (!std::isfinite(y) || !(a >= 0.0 && a <= 1.0))
            continue;
        totals.luminance += a * std::clamp(y, 0.0, 1.0);
        totals.weight += a;
    }
    return totals;
}

/* First pass: the texture's mean reflectance unless given, and the mean of r. With the patch's
 * reading r = E rho, and rho is a common factor. */
void Corrector::find_means()
{
    const bool texel = job_.correction.reading == LCOR_READING_TEXEL;
    const bool needs_mean = !job_.correction.given_mean();
    const bool needs_texture = !texel && (!job_.rho || job_.measured);
    const lcor_mean_method method = job_.correction.mean_method();
    rho_ = 1.0;
    const PlanPointer plan = make_plan(1.0);
    std::vector<double> linear(256);
    for (size_t i = 0; i < 256; i++)
        linear[i] = lcor_transfer_to_linear(&colour_, static_cast<double>(i) / 255.0);

    std::vector<Totals> totals((reader_.height() + CHUNK_ROWS - 1) / CHUNK_ROWS + bands_);
    std::mutex mutex;
    lcor_mean mean;
    lcor_mean_init(&mean);
    if (!needs_mean && !needs_texture)
        bands_to_skip();
    stream(false, 0.0, 0.4, [&](Band &band, size_t y0, size_t y1, size_t chunk) {
        std::vector<float> illuminance(reader_.width());
        std::vector<double> r(reader_.width()), weight;
        std::vector<uint8_t> rgb;
        lcor_mean part;
        lcor_mean_init(&part);
        for (size_t y = y0; y < y1; y++) {
            uint8_t *const row = &band.pixels[(y - band.y0) * stride_];
            if (reader_.premultiplied())
                convert_alpha(row, true);
            if (needs_texture) {
                const Totals add = row_luminance(row, linear);
                totals[chunk].luminance += add.luminance;
                totals[chunk].weight += add.weight;
            }
            if (!needs_mean)
                continue;
            map_.sample(band.map, y, illuminance.data());
            if (texel && colours_ == 1)
                spread_grey(row, rgb);
            lcor_plan_reflectance_row(plan.get(), r.size(), rgb.empty() ? row : rgb.data(),
                                      illuminance.data(), nullptr, r.data());
            if (alpha_ >= 0)
                weights(row, weight);
            lcor_mean_add(&part, r.size(), r.data(), alpha_ >= 0 ? weight.data() : nullptr);
        }
        const std::lock_guard<std::mutex> lock(mutex);
        lcor_error error = {};
        check(lcor_mean_merge(&mean, &part, &error), error, Exit::failed, "mean");
    });
}

} // namespace
} // namespace cli
