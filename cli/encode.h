/* SPDX-License-Identifier: MIT */
/* Linear rows as a picture file stores them. */
#ifndef LCOR_CLI_ENCODE_H
#define LCOR_CLI_ENCODE_H

#include "cli.h"

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string>
#include <vector>

namespace cli
{

/* "png", "jpg", ... of a path, in small letters. */
std::string extension_of(const std::string &path);
bool holds_alpha(const std::string &path);
bool holds_floats(const std::string &path);

/* Linear RGB and coverage -> stored samples, through the device's tone curve or the transfer
 * function. Floats stay linear. Without alpha, pixels lie before black. */
class Encoder
{
  public:
    Encoder(OIIO::TypeDesc type, bool alpha, const lcor_colour &stored,
            const std::vector<float> &tone);
    size_t channels() const { return alpha_ ? 4 : 3; }
    size_t row_bytes(size_t width) const { return width * channels() * type_.size(); }
    void row(const float *rgba, size_t width, uint8_t *out) const;

  private:
    float stored(float linear) const;
    OIIO::TypeDesc type_;
    bool alpha_;
    std::vector<float> curve_; /* stored value at equal steps of linear 0..1 */
};

} // namespace cli

#endif
