/* SPDX-License-Identifier: MIT */
/* Pictures of any size, read and written in bands of rows. */
#ifndef LCOR_CLI_STREAM_H
#define LCOR_CLI_STREAM_H

#include "cli.h"
#include "sink.h"

#include <OpenImageIO/imageio.h>

#include <memory>
#include <string>
#include <vector>

namespace cli
{

/* A picture file read from top to bottom; colours are straight (not multiplied by alpha) where the
 * format can have them so. */
class PictureReader
{
  public:
    /* Exit::input when missing, broken, deep or a volume. */
    explicit PictureReader(const std::string &path);
    const OIIO::ImageSpec &spec() const { return spec_; }
    const std::string &path() const { return path_; }
    size_t width() const { return static_cast<size_t>(spec().width); }
    size_t height() const { return static_cast<size_t>(spec().height); }
    size_t channels() const { return static_cast<size_t>(spec().nchannels); }
    std::string format() const { return input_->format_name(); }
    bool float_samples() const { return spec().format.is_floating_point(); }
    /* Samples are colour times alpha. */
    bool premultiplied() const;
    /* Rows that the file's tiles or strips make cheap to read together, about `bytes` of them. */
    size_t band_rows(size_t bytes) const;
    /* Rows y0..y1-1; y0 a multiple of band_rows(), or the rows after those read last. */
    void read(size_t y0, size_t y1, OIIO::TypeDesc type, void *out);

  private:
    std::string path_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
};

/* Fails as a PictureWriter would for a path that cannot be written to or names no format: before
 * the long work. Leaves nothing there. */
void check_picture_path(const std::string &path);

/* A picture file that appears whole or not at all. */
class PictureWriter
{
  public:
    /* `spec` as the picture should be; what the format cannot do is changed: see spec(). */
    PictureWriter(const std::string &path, const OIIO::ImageSpec &spec);
    ~PictureWriter();
    const OIIO::ImageSpec &spec() const { return output_->spec(); }
    bool premultiplied() const { return premultiplied_; }
    /* The next rows. With tiles, all but the last band must hold whole rows of them. */
    void write(size_t y0, size_t y1, OIIO::TypeDesc type, const void *rows);
    void commit();

  private:
    void check(bool good) const;

    OutputFile file_;
    std::unique_ptr<Sink> sink_; /* where the format can have one */
    std::unique_ptr<OIIO::ImageOutput> output_;
    bool premultiplied_ = false, committed_ = false;
};

/* Illuminance on the pixel grid of a picture of another size: bilinear between pixel centres, which
 * are aligned, and constant beyond the outer ones. Read band by band, so maps may be large too. */
class MapReader
{
  public:
    /* Stored integers are linear numbers 0..1; three channels give the Y of the colour's matrix. */
    MapReader(const std::string &path, const lcor_colour &colour, size_t width, size_t height);

    size_t columns() const { return picture_.width(); }
    size_t rows() const { return picture_.height(); }

    /* The map's rows under rows y0..y1-1 of the picture. Bands follow each other downwards; the
     * first row again starts over. Exit::input for values that are negative or not finite. */
    struct Band {
        size_t first = 0; /* map row */
        std::vector<float> values;
    };
    void read(size_t y0, size_t y1, Band &band);
    /* Illuminance of one row of the picture within the band; any thread. */
    void sample(const Band &band, size_t y, float *out) const;

  private:
    double place(size_t y) const; /* of picture row y among the map's rows */
    void fetch(size_t y);

    PictureReader picture_;
    const lcor_colour colour_;
    const size_t width_, height_; /* of the picture */
    std::vector<uint32_t> left_;  /* of the two map columns between which a pixel lies */
    std::vector<float> weight_;   /* of the right one */
    Band windows_[2];             /* rows decoded last, and those before: bands overlap */
};

} // namespace cli

#endif
