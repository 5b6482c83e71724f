/* SPDX-License-Identifier: MIT */
/* Pictures in memory, decoded by OpenImageIO. */
#ifndef LCOR_CLI_IMAGE_H
#define LCOR_CLI_IMAGE_H

#include "cli.h"

#include <cstdint>
#include <string>
#include <vector>

namespace cli
{

/* Rows from the top, interleaved, 1 (grey), 2 (grey, alpha), 3 or 4 (with alpha) channels. 8- and
 * 16-bit samples stay what they are; everything else is float. */
struct Image {
    size_t width = 0, height = 0, channels = 0;
    lcor_sample type = LCOR_U8; /* LCOR_U8, LCOR_U16 or LCOR_F32 */
    std::vector<uint8_t> bytes;
    std::string format; /* "jpeg", "png", ... */
    int pictures = 1;   /* in the file: this one is the first */

    /* One stored sample, 0..1 for integers. */
    double sample(size_t x, size_t y, size_t channel) const;
};

/* Decode a picture file, or bytes of one (its kind is found from the bytes). `name` is for
 * messages. Exit::input when missing, broken, or of more than 2^28 pixels. */
Image read_image(const std::string &path);
Image decode_image(const uint8_t *bytes, size_t size, const std::string &name);
/* Says what is left of a file that holds more than one picture. */
void warn_of_others(const std::string &where, int pictures);

} // namespace cli

#endif
