/* SPDX-License-Identifier: MIT */
/* How every picture file is opened, and what is said of one that holds more than lcor takes. */
#ifndef LCOR_CLI_OPEN_PICTURE_H
#define LCOR_CLI_OPEN_PICTURE_H

#include "cli.h"

#include <OpenImageIO/imageio.h>

#include <memory>
#include <string>

namespace cli
{

/* OpenImageIO says much on several lines; the first sentence is what people need. */
std::string first_line(const std::string &text);

/* Of a file, or of bytes that `reader` gives for a file called `hint`; colours are straight where
 * the format can have them so. `name` is for messages. Exit::input when missing, broken, deep, a
 * volume or empty. */
std::unique_ptr<OIIO::ImageInput> open_picture(const std::string &path);
std::unique_ptr<OIIO::ImageInput> open_picture(OIIO::Filesystem::IOProxy &reader, const char *hint,
                                               const std::string &name);

/* Parts of an EXR file, pages of a TIFF, frames of an animation; 1 for PSD, whose layers are all in
 * its first picture. The first one is current again. */
int count_pictures(OIIO::ImageInput &input, const std::string &name);

} // namespace cli

#endif
