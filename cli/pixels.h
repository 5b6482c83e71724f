/* SPDX-License-Identifier: MIT */
/* Rows of pixels as `lcor correct` works on them, whatever their samples and channels are. */
#ifndef LCOR_CLI_PIXELS_H
#define LCOR_CLI_PIXELS_H

#include "cli.h"

#include <OpenImageIO/typedesc.h>

#include <cstdint>
#include <vector>

namespace cli
{

class PixelRows
{
  public:
    PixelRows() = default;
    /* Samples no coarser than those of either file; alpha -1: none. Pictures with less than three
     * channels are grey. `premultiplied`: colour times alpha at one end, so division is needed. */
    PixelRows(OIIO::TypeDesc in, OIIO::TypeDesc out, bool premultiplied, size_t width,
              size_t channels, int alpha);

    lcor_sample kind() const { return kind_; }
    OIIO::TypeDesc type() const { return type_; }
    size_t bytes() const { return width_ * channels_ * type_.size(); } /* of a row */
    size_t width() const { return width_; }
    bool grey() const { return channels_ < 3; }
    bool has_alpha() const { return alpha_ >= 0; }
    /* Of a colour row: the picture's own, or the one spread_grey() makes. */
    lcor_layout layout() const { return {grey() ? size_t(3) : channels_, 1}; }

    double sample(const uint8_t *row, size_t index) const;
    /* Colour times alpha -> colour in place, and back. */
    void divide_by_alpha(uint8_t *row) const { scale(row, true); }
    void multiply_by_alpha(uint8_t *row) const { scale(row, false); }
    /* A grey row as one of three equal channels, and back. */
    void spread_grey(const uint8_t *row, std::vector<uint8_t> &rgb) const;
    void gather_grey(const std::vector<uint8_t> &rgb, uint8_t *row) const;
    /* How much of each pixel shows, 0..1. */
    void coverage(const uint8_t *row, std::vector<double> &out) const;

  private:
    void scale(uint8_t *row, bool divide) const;

    lcor_sample kind_ = LCOR_U8;
    OIIO::TypeDesc type_;
    size_t width_ = 0, channels_ = 0;
    int alpha_ = -1;
};

/* Sums Y of rows, weighted by alpha: the reflectance of a texture (section 5.2). */
class LuminanceSum
{
  public:
    LuminanceSum(const lcor_colour &colour, const PixelRows &rows, size_t height);
    /* Any thread, each row once. */
    void add(size_t y, const uint8_t *row);
    double mean() const; /* 0 for a picture nothing of which shows */

  private:
    template <typename Sample> double sum_opaque(const uint8_t *row, size_t step) const;
    double linear(const uint8_t *row, size_t index) const;
    double luminance(const uint8_t *row, size_t index) const; /* Y of the pixel */

    const lcor_colour &colour_;
    const PixelRows &rows_;
    std::vector<double> linear_;             /* of integer samples */
    std::vector<double> luminance_, weight_; /* per row, so that threads change no bit */
};

} // namespace cli

#endif
