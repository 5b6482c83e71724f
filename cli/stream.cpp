/* SPDX-License-Identifier: MIT */
#include "stream.h"

#include "image.h"
#include "open_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace cli
{

namespace
{

/* libjpeg ends the program beyond this, and OpenImageIO lets a little more pass. */
constexpr int largest_jpeg = 65500;

} // namespace

PictureReader::PictureReader(const std::string &path)
    : path_(path), input_(open_picture(path)), spec_(input_->spec())
{
    warn_of_others("'" + path + "'", count_pictures(*input_, path));
    if (spec_.alpha_channel >= spec_.nchannels)
        spec_.alpha_channel = spec_.nchannels - 1; /* OpenImageIO counts those of GIF from 1 */
}

bool PictureReader::premultiplied() const
{
    return spec().alpha_channel >= 0 && spec().get_int_attribute("oiio:UnassociatedAlpha") == 0;
}

size_t PictureReader::band_rows(size_t bytes) const
{
    const size_t unit =
        spec().tile_width > 0
            ? static_cast<size_t>(spec().tile_height)
            : static_cast<size_t>(std::max(spec().get_int_attribute("tiff:RowsPerStrip", 1), 1));
    const size_t rows = std::max(bytes / std::max<size_t>(spec().scanline_bytes(), 1), size_t(1));
    return std::min(std::max(rows / std::min(unit, height()) * unit, unit), height());
}

void PictureReader::read(size_t y0, size_t y1, OIIO::TypeDesc type, void *out)
{
    const OIIO::ImageSpec &s = spec();
    const int first = s.y + static_cast<int>(y0), last = s.y + static_cast<int>(y1);
    bool good;
    if (s.tile_width > 0)
        good = input_->read_tiles(0, 0, s.x, s.x + s.width, first, last, s.z, s.z + 1, 0,
                                  s.nchannels, type, out);
    else if (type == s.format && s.channelformats.empty())
        /* Straight to where they are wanted, not by way of a buffer. */
        good = input_->read_native_scanlines(0, 0, first, last, s.z, out);
    else
        good = input_->read_scanlines(0, 0, first, last, s.z, 0, s.nchannels, type, out);
    if (!good)
        fail(Exit::input, "cannot read the pixels of '%s': %s", path_.c_str(),
             first_line(input_->geterror()).c_str());
}

static std::unique_ptr<OIIO::ImageOutput> output_for(const std::string &path)
{
    std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path);
    if (!output)
        fail(Exit::usage,
             "'%s': no picture format has this extension; try .tif, .png, .jpg or .exr",
             path.c_str());
    return output;
}

void check_picture_path(const std::string &path)
{
    output_for(path);
    check_output(path);
}

PictureWriter::PictureWriter(const std::string &path, const OIIO::ImageSpec &spec) : file_(path)
{
    output_ = output_for(path);
    OIIO::ImageSpec wanted = spec;
    const std::string format = output_->format_name();
    if (format == "jpeg" && std::max(spec.width, spec.height) > largest_jpeg)
        fail(Exit::usage,
             "'%s': JPEG holds at most %d pixels a side and the picture is %d x %d; write .png, "
             ".tif or .exr",
             path.c_str(), largest_jpeg, spec.width, spec.height);
    if (wanted.alpha_channel >= 0 && !output_->supports("alpha"))
        fail(Exit::usage, "'%s': %s cannot hold the picture's alpha; write .png, .tif or .exr",
             path.c_str(), format.c_str());
    if (!output_->supports("tiles"))
        wanted.tile_width = wanted.tile_height = wanted.tile_depth = 0;
    premultiplied_ = wanted.alpha_channel >= 0 &&
                     (format == "openexr" ||
                      (format == "tiff" && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0));
    if (wanted.alpha_channel >= 0)
        wanted.attribute("oiio:UnassociatedAlpha", premultiplied_ ? 0 : 1);
    /* OpenImageIO's TIFF writer loses the directory of files written through a proxy. */
    if (output_->supports("ioproxy") && format != "tiff") {
        sink_ = std::make_unique<Sink>(file_.temporary(), path);
        output_->set_ioproxy(sink_.get());
    }
    check(output_->open(file_.temporary(), wanted));
}

PictureWriter::~PictureWriter()
{
    /* Closing an unfinished picture makes some libraries complain on stderr; the program is about
     * to end with an error of its own and the file is removed, so it is let go as it is. */
    if (!committed_)
        static_cast<void>(output_.release());
}

void PictureWriter::write(size_t y0, size_t y1, OIIO::TypeDesc type, const void *rows)
{
    const OIIO::ImageSpec &s = spec();
    const int first = s.y + static_cast<int>(y0), last = s.y + static_cast<int>(y1);
    check(s.tile_width > 0
              ? output_->write_tiles(s.x, s.x + s.width, first, last, s.z, s.z + 1, type, rows)
              : output_->write_scanlines(first, last, s.z, type, rows));
}

/* What the system refused says more than what the library makes of it. */
void PictureWriter::check(bool good) const
{
    if (sink_)
        sink_->check();
    if (!good)
        fail(Exit::failed, "cannot write '%s': %s", file_.path().c_str(),
             first_line(output_->geterror()).c_str());
}

void PictureWriter::commit()
{
    check(output_->close());
    std::error_code ignored;
    if (!sink_ && std::filesystem::is_regular_file(file_.temporary(), ignored) &&
        !OIIO::ImageInput::open(file_.temporary()))
        fail(Exit::failed, "'%s' came out broken; is the disk full?", file_.path().c_str());
    committed_ = true;
    file_.commit();
}

MapReader::MapReader(const std::string &path, const lcor_colour &colour, size_t width,
                     size_t height)
    : picture_(path), colour_(colour), width_(width), height_(height), left_(width), weight_(width)
{
    const size_t columns = picture_.width();
    const double ratio = static_cast<double>(columns) / static_cast<double>(width);
    for (size_t x = 0; x < width; x++) {
        const double at = std::clamp((static_cast<double>(x) + 0.5) * ratio - 0.5, 0.0,
                                     static_cast<double>(columns - 1));
        /* The last column is reached from its left neighbour with weight 1. */
        left_[x] = static_cast<uint32_t>(
            std::min(static_cast<size_t>(at), columns > 1 ? columns - 2 : size_t(0)));
        weight_[x] = static_cast<float>(at - left_[x]);
    }
}

double MapReader::place(size_t y) const
{
    const size_t rows = picture_.height();
    return std::clamp((static_cast<double>(y) + 0.5) * static_cast<double>(rows) /
                              static_cast<double>(height_) -
                          0.5,
                      0.0, static_cast<double>(rows - 1));
}

/* Decode the rows around map row `y` and check them. */
void MapReader::fetch(size_t y)
{
    const size_t columns = picture_.width(), channels = picture_.channels();
    const size_t step = picture_.band_rows(size_t(4) << 20), first = y / step * step;
    const size_t last = std::min(first + step, picture_.height());
    std::swap(windows_[0], windows_[1]);
    Band &window = windows_[0];
    window.first = first;
    window.values.resize((last - first) * columns);
    std::vector<float> rows(window.values.size() * channels);
    picture_.read(first, last, OIIO::TypeDesc::FLOAT, rows.data());
    for (size_t i = 0; i < window.values.size(); i++) {
        const float *const sample = &rows[i * channels];
        double value = static_cast<double>(sample[0]);
        if (channels >= 3)
            value = colour_.to_xyz[3] * static_cast<double>(sample[0]) +
                    colour_.to_xyz[4] * static_cast<double>(sample[1]) +
                    colour_.to_xyz[5] * static_cast<double>(sample[2]);
        if (!(value >= 0.0) || !std::isfinite(value))
            fail(Exit::input,
                 "illuminance map '%s' is %s at pixel (%zu, %zu); it must be 0 or more",
                 picture_.path().c_str(), number_text(value).c_str(), i % columns,
                 first + i / columns);
        window.values[i] = static_cast<float>(value);
    }
}

void MapReader::read(size_t y0, size_t y1, Band &band)
{
    const size_t columns = picture_.width(), rows = picture_.height();
    const size_t first = static_cast<size_t>(place(y0));
    const size_t last = std::min(static_cast<size_t>(place(y1 - 1)) + 2, rows);
    const auto holds = [&](const Band &window, size_t y) {
        return y >= window.first && y - window.first < window.values.size() / columns;
    };
    band.first = first;
    band.values.clear();
    for (size_t y = first; y < last;) {
        if (!holds(windows_[0], y) && !holds(windows_[1], y))
            fetch(y);
        const Band &window = holds(windows_[0], y) ? windows_[0] : windows_[1];
        const size_t end = std::min(last, window.first + window.values.size() / columns);
        const auto start = window.values.begin() + static_cast<long>((y - window.first) * columns);
        band.values.insert(band.values.end(), start,
                           start + static_cast<long>((end - y) * columns));
        y = end;
    }
}

void MapReader::sample(const Band &band, size_t y, float *out) const
{
    const size_t columns = picture_.width(), rows = picture_.height();
    const double at = place(y);
    const size_t above = static_cast<size_t>(at), below = std::min(above + 1, rows - 1);
    const float *const a = &band.values[(above - band.first) * columns];
    const float *const b = &band.values[(below - band.first) * columns];
    if (columns == width_ && rows == height_) {
        std::copy_n(a, width_, out);
        return;
    }
    /* Down the columns first: most maps are much smaller than the picture. */
    const float t = static_cast<float>(at - static_cast<double>(above));
    struct Column {
        float value, step; /* to the next column */
    };
    std::vector<Column> row(columns);
    for (size_t i = 0; i < columns; i++)
        row[i] = {a[i] + t * (b[i] - a[i]), 0.0F};
    for (size_t i = 0; i + 1 < columns; i++)
        row[i].step = row[i + 1].value - row[i].value;
    for (size_t x = 0; x < width_; x++) {
        const Column &column = row[left_[x]];
        out[x] = column.value + weight_[x] * column.step;
    }
}

} // namespace cli
