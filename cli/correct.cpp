/* SPDX-License-Identifier: MIT */
/* `lcor correct`: a picture of any size in two streaming passes, the mean and the correction. */
#include "pixels.h"
#include "stream.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <mutex>

namespace cli
{

namespace
{

enum { CURVE_STEPS = 65536 };
constexpr size_t depth_bytes[] = {0, 1, 2, 2, 4}; /* of Job::depth */
constexpr size_t band_bytes = size_t(3) << 20;
/* Of one task: threads wait for each other at the end of a band, so tasks are short. */
constexpr size_t task_pixels = 32768;
/* A doubt about the mean that no device shows. */
constexpr double mean_doubt = 1e-4;

struct Job {
    std::string texture, map, output;
    std::optional<double> rho, measured;
    int depth = 0; /* same as the texture, 8, 16, half, float */
    DeviceOptions device;
    CorrectionOptions correction;
};

/* A few rows on their way through the stages. */
struct Band {
    size_t y0 = 0, y1 = 0;
    std::vector<uint8_t> pixels;
    MapReader::Band map;
};

/* CMYK and the like, which OpenImageIO hands over as three channels. */
bool foreign_colours(const OIIO::ImageSpec &spec)
{
    const std::string profile = spec.get_string_attribute("ICCProfile:color_space", "RGB");
    return spec.get_string_attribute("tiff:ColorSpace") == "CMYK" ||
           spec.get_string_attribute("jpeg:ColorSpace") == "CMYK" ||
           spec.get_string_attribute("jpeg:ColorSpace") == "YCbCrK" ||
           (spec.nchannels >= 3 && profile != "RGB");
}

OIIO::ImageSpec output_spec(const PictureReader &reader, const Job &job, const Device &device)
{
    OIIO::ImageSpec spec = reader.spec();
    const OIIO::TypeDesc types[] = {spec.format, OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16,
                                    OIIO::TypeDesc::HALF, OIIO::TypeDesc::FLOAT};
    spec.set_format(types[job.depth]);
    spec.channelformats.clear();
    spec.erase_attribute("oiio:BitsPerSample");
    const bool to_device = !device.tone_curve.empty() && !spec.format.is_floating_point();
    const std::string icc = spec.get_string_attribute("ICCProfile:profile_description");
    if (to_device && spec.find_attribute("ICCProfile")) {
        warn("the device's tone curve takes the place of the ICC profile of '%s'",
             job.texture.c_str());
        spec.erase_attribute("ICCProfile");
    } else if (foreign_colours(spec)) {
        warn("'%s' is not RGB: its colours are those of a plain conversion and the picture written "
             "is RGB without its ICC profile; for exact ones convert it to sRGB first",
             job.texture.c_str());
        for (const char *name : {"ICCProfile", "tiff:ColorSpace", "tiff:PhotometricInterpretation"})
            spec.erase_attribute(name);
    } else if (!icc.empty() && icc.find("sRGB") == std::string::npos) {
        warn("'%s' has the ICC profile '%s'; it is carried over, colours are read as --space says",
             job.texture.c_str(), icc.c_str());
    }
    spec.attribute("Software", std::string("lcor ") + lcor_version());
    return spec;
}

class Corrector
{
  public:
    Corrector(const Job &job, Threads &threads)
        : job_(job), threads_(threads), device_(job.device.load(!job.correction.conventional)),
          reader_(job.texture), colour_(job.correction.colour(reader_.float_samples())),
          map_(job.map, colour_, reader_.width(), reader_.height()),
          writer_(job.output, output_spec(reader_, job, device_)),
          rows_(reader_.spec().format, writer_.spec().format,
                reader_.premultiplied() || writer_.premultiplied(), reader_.width(),
                reader_.channels(), reader_.spec().alpha_channel),
          band_rows_(reader_.band_rows(band_bytes)),
          task_rows_(std::max<size_t>(task_pixels / reader_.width(), 1)), progress_("correcting")
    {
        if (writer_.spec().format.size() < depth_bytes[job.depth])
            fail(Exit::usage, "'%s' holds %s samples at most; write .tif or .exr for --depth",
                 job.output.c_str(), writer_.spec().format.c_str());
        make_curve();
    }

    Json run()
    {
        find_means();
        correct();
        writer_.commit();
        return report();
    }

  private:
    using Work = std::function<void(Band &band, size_t y0, size_t y1)>;

    /* The output may store samples another way than the input: the curve starts at linear RGB. */
    void make_curve()
    {
        const bool to_float = writer_.spec().format.is_floating_point();
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

    PlanPointer make_plan(double r_mean, double rho, double ratio) const
    {
        lcor_plan_options options = job_.correction.plan(device_, colour_);
        options.r_mean = r_mean;
        options.rho = rho;
        options.rho_ratio = ratio;
        options.in_type = options.out_type = rows_.kind();
        options.in_layout = options.out_layout = rows_.layout();
        options.tone_curve = curve_.empty() ? nullptr : curve_.data();
        options.tone_size = curve_.size();
        lcor_plan *plan = nullptr;
        lcor_error error = {};
        check(lcor_plan_new(&options, &plan, &error), error, Exit::usage, "correction");
        return PlanPointer(plan);
    }

    /* Reading, working on and writing of three neighbouring bands at once. */
    void stream(bool write, double from, double to, const Work &work)
    {
        std::array<Band, 3> bands;
        const size_t count = (reader_.height() + band_rows_ - 1) / band_rows_;
        const size_t steps = count + (write ? 2 : 1);
        for (size_t k = 0; k < steps; k++) {
            Band &reading = bands[k % 3], &working = bands[(k + 2) % 3],
                 &writing = bands[(k + 1) % 3];
            const bool works = k >= 1 && k <= count;
            const size_t rows = works ? working.y1 - working.y0 : 0;
            threads_.run(2 + (rows + task_rows_ - 1) / task_rows_, [&](size_t task) {
                if (task == 0 && write && k >= 2) {
                    writer_.write(writing.y0, writing.y1, rows_.type(), writing.pixels.data());
                } else if (task == 1 && k < count) {
                    read(reading, k);
                } else if (task >= 2) {
                    const size_t y0 = working.y0 + (task - 2) * task_rows_;
                    work(working, y0, std::min(y0 + task_rows_, working.y1));
                }
            });
            progress_.report(from +
                             (to - from) * static_cast<double>(k + 1) / static_cast<double>(steps));
        }
    }

    void read(Band &band, size_t index)
    {
        band.y0 = index * band_rows_;
        band.y1 = std::min(band.y0 + band_rows_, reader_.height());
        band.pixels.resize((band.y1 - band.y0) * rows_.bytes());
        reader_.read(band.y0, band.y1, rows_.type(), band.pixels.data());
        map_.read(band.y0, band.y1, band.map);
        for (size_t y = band.y0; y < band.y1 && reader_.premultiplied(); y++)
            rows_.divide_by_alpha(row_of(band, y));
    }

    uint8_t *row_of(Band &band, size_t y) const
    {
        return &band.pixels[(y - band.y0) * rows_.bytes()];
    }

    void find_means();
    size_t stride(size_t pixels, size_t map_pixels) const;
    void add_rows(const lcor_plan *plan, Band &band, size_t y0, size_t y1, lcor_mean &mean) const;
    void correct();
    void correct_rows(const lcor_plan *plan, Band &band, size_t y0, size_t y1,
                      lcor_row_stats &stats) const;
    Json report() const;

    const Job &job_;
    Threads &threads_;
    const Device device_;
    PictureReader reader_;
    const lcor_colour colour_;
    MapReader map_;
    PictureWriter writer_;
    const PixelRows rows_;
    const size_t band_rows_, task_rows_;
    Progress progress_;
    std::vector<float> curve_;
    std::mutex mutex_;
    double rho_ = 0.5, ratio_ = 1.0, r_mean_ = 1.0;
    lcor_row_stats stats_ = {};
};

/* Every how many pixels r is looked at. With the patch's reading it is the map's alone, and a map
 * of far fewer pixels is smooth between them: twice its resolution tells its mean. */
size_t Corrector::stride(size_t pixels, size_t map_pixels) const
{
    if (job_.correction.reading == LCOR_READING_TEXEL || rows_.has_alpha())
        return 1;
    return std::max<size_t>(pixels / (2 * map_pixels), 1);
}

/* r of rows, for the mean of section 4.3. */
void Corrector::add_rows(const lcor_plan *plan, Band &band, size_t y0, size_t y1,
                         lcor_mean &mean) const
{
    const size_t step_x = stride(reader_.width(), map_.columns());
    const size_t step_y = stride(reader_.height(), map_.rows());
    const size_t n = rows_.width();
    std::vector<float> illuminance(n);
    std::vector<double> r(n), alpha;
    std::vector<uint8_t> rgb;
    for (size_t y = y0; y < y1; y++) {
        if (y % step_y != step_y / 2)
            continue;
        const uint8_t *const row = row_of(band, y);
        map_.sample(band.map, y, illuminance.data());
        if (rows_.grey())
            rows_.spread_grey(row, rgb);
        size_t count = n;
        if (step_x > 1) {
            count = 0;
            for (size_t x = step_x / 2; x < n; x += step_x)
                illuminance[count++] = illuminance[x];
        }
        lcor_plan_reflectance_row(plan, count, rows_.grey() ? rgb.data() : row, illuminance.data(),
                                  nullptr, r.data());
        if (rows_.has_alpha())
            rows_.coverage(row, alpha);
        lcor_mean_add(&mean, count, r.data(), rows_.has_alpha() ? alpha.data() : nullptr);
    }
}

/* First pass: the texture's own reflectance and the mean of r, each unless given. With the patch's
 * reading r = E rho, so rho is a factor of the mean and can be learnt in the same pass. */
void Corrector::find_means()
{
    const bool texel =
        job_.correction.reading == LCOR_READING_TEXEL && !job_.correction.conventional;
    const bool wants_mean = !job_.correction.given_mean() && !job_.correction.conventional;
    const bool wants_rho = !texel && (!job_.rho || job_.measured);
    const lcor_mean_method method = job_.correction.mean_method();
    const PlanPointer plan = make_plan(1.0, 1.0, 1.0);
    LuminanceSum luminance(colour_, rows_, reader_.height());
    lcor_mean mean;
    lcor_mean_init(&mean);
    lcor_error error = {};
    bool first = true;
    for (double done = 0.0; (first && (wants_mean || wants_rho)) ||
                            (!first && wants_mean && lcor_mean_error(&mean, method) > mean_doubt);
         first = false) {
        if (!first)
            lcor_mean_refine(&mean, method);
        const lcor_mean start = mean;
        const double next = done + 0.5 * (0.6 - done);
        bool fresh = true; /* the first chunk's mean takes over what came before */
        stream(false, done, next, [&](Band &band, size_t y0, size_t y1) {
            for (size_t y = y0; y < y1 && first && wants_rho; y++)
                luminance.add(y, row_of(band, y));
            if (!wants_mean)
                return;
            lcor_mean part = start;
            add_rows(plan.get(), band, y0, y1, part);
            const std::lock_guard<std::mutex> lock(mutex_);
            if (fresh)
                mean = part;
            else
                check(lcor_mean_merge(&mean, &part, &error), error, Exit::failed, "mean of r");
            fresh = false;
        });
        done = next;
    }
    const double drawn = luminance.mean();
    if (job_.measured) {
        rho_ = *job_.measured;
        ratio_ = drawn > 0.0 ? rho_ / drawn : 1.0;
    } else {
        rho_ = job_.rho ? *job_.rho : texel ? 1.0 : drawn;
    }
    if (job_.correction.given_mean()) {
        r_mean_ = *job_.correction.given_mean();
    } else if (wants_mean) {
        check(lcor_mean_get(&mean, method, &r_mean_, &error), error, Exit::input,
              "'" + job_.map + "': mean of r");
        r_mean_ *= texel ? 1.0 : rho_;
        if (!(r_mean_ > 0.0))
            warn("nothing is lit or everything is black: the picture comes out black");
    }
}

void Corrector::correct_rows(const lcor_plan *plan, Band &band, size_t y0, size_t y1,
                             lcor_row_stats &stats) const
{
    const size_t n = rows_.width();
    std::vector<float> illuminance(n);
    std::vector<uint8_t> rgb;
    for (size_t y = y0; y < y1; y++) {
        uint8_t *const row = row_of(band, y);
        map_.sample(band.map, y, illuminance.data());
        if (rows_.grey())
            rows_.spread_grey(row, rgb);
        void *const texels = rows_.grey() ? rgb.data() : row;
        (job_.correction.conventional ? lcor_conventional_row : lcor_correct_row)(
            plan, y, n, texels, illuminance.data(), nullptr, texels, &stats);
        if (rows_.grey())
            rows_.gather_grey(rgb, row);
        if (writer_.premultiplied())
            rows_.multiply_by_alpha(row);
    }
}

/* Second pass. */
void Corrector::correct()
{
    const PlanPointer plan = make_plan(r_mean_, rho_, ratio_);
    stream(true, 0.6, 1.0, [&](Band &band, size_t y0, size_t y1) {
        lcor_row_stats stats = {};
        correct_rows(plan.get(), band, y0, y1, stats);
        const std::lock_guard<std::mutex> lock(mutex_);
        const bool earlier = stats.non_finite > 0 &&
                             (stats_.non_finite == 0 || stats.first_bad_row < stats_.first_bad_row);
        if (earlier) {
            stats_.first_bad_row = stats.first_bad_row;
            stats_.first_bad_pixel = stats.first_bad_pixel;
        }
        stats_.pixels += stats.pixels;
        stats_.clipped_low += stats.clipped_low;
        stats_.clipped_high += stats.clipped_high;
        stats_.out_of_gamut += stats.out_of_gamut;
        stats_.non_finite += stats.non_finite;
    });
    if (stats_.non_finite > 0)
        warn("'%s': pixels that are negative or no numbers come out black: %llu, the first at row "
             "%llu, column %llu",
             job_.texture.c_str(), static_cast<unsigned long long>(stats_.non_finite),
             static_cast<unsigned long long>(stats_.first_bad_row),
             static_cast<unsigned long long>(stats_.first_bad_pixel));
}

Json Corrector::report() const
{
    return {{"output", job_.output},
            {"width", reader_.width()},
            {"height", reader_.height()},
            {"method", job_.correction.conventional ? "conventional" : "corrected"},
            {"contrast", device_.contrast},
            {"rho", rho_},
            {"rho_ratio", ratio_},
            {"r_mean", r_mean_},
            {"pixels", stats_.pixels},
            {"clipped_low", stats_.clipped_low},
            {"clipped_high", stats_.clipped_high},
            {"out_of_gamut", stats_.out_of_gamut},
            {"non_finite", stats_.non_finite}};
}

void check_reflectance(const std::optional<double> &rho, const char *name)
{
    if (rho && !(*rho > 0.0 && *rho <= 1.0))
        fail(Exit::usage, "%s must be greater than 0 and at most 1, not %s", name,
             number_text(*rho).c_str());
}

} // namespace

Exit run_correct(const Arguments &arguments)
{
    Job job;
    int thread_count = 0;
    Options options(
        "lcor correct TEXTURE --illuminance MAP -o OUT (--profile F | --contrast C) [options]",
        "Correct the lightness of a picture that lies under an illuminance map, for a device\n"
        "of limited contrast. The map is a picture of any size, linear, in any unit.");
    options
        .text("--illuminance", "MAP", job.map,
              "illuminance as a picture (float, or linear integers)")
        .text("-o", "OUT", job.output, "picture to write; its extension gives the format");
    job.device.declare(options);
    options
        .number("--rho", "R", job.rho, "reflectance of the surface, default the picture's mean Y")
        .number("--measured", "R", job.measured,
                "as --rho, and scale the picture from its mean Y to R (section 5.2)");
    job.correction.declare(options);
    options
        .choice("--depth", {"same", "8", "16", "half", "float"}, job.depth, "samples of the output")
        .count("--threads", "N", thread_count, "default: as many as the machine has");
    if (!options.parse(arguments))
        return Exit::ok;
    job.texture = options.operand("a picture");
    if (job.map.empty())
        fail(Exit::usage, "which light? give --illuminance MAP");
    if (job.output.empty())
        fail(Exit::usage, "where to? give -o OUT.tif, .png, .jpg or .exr");
    check_reflectance(job.rho, "--rho");
    check_reflectance(job.measured, "--measured");
    if (job.rho && job.measured)
        fail(Exit::usage, "--rho and --measured exclude each other");
    job.correction.mean_method(); /* says at once what is wrong with --mean */
    Threads threads(thread_count);
    OIIO::attribute("threads", threads.count());
    const Json report = Corrector(job, threads).run();
    if (job.correction.conventional)
        say("%s: conventional method", job.output.c_str());
    else
        say("%s: corrected, mean of r %s", job.output.c_str(),
            number_text(report["r_mean"]).c_str());
    print_json(report);
    return Exit::ok;
}

} // namespace cli
