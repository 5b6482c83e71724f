/* SPDX-License-Identifier: MIT */
#include "image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

using InputPointer = std::unique_ptr<OIIO::ImageInput>;

constexpr uint64_t max_pixels = uint64_t(1) << 28;
/* A header may promise more than its file holds: no coding of real pictures shrinks them further.
 */
constexpr uint64_t largest_ratio = 2048, ratio_floor = uint64_t(1) << 22;

/* OpenImageIO says much on several lines; the first sentence is what people need. */
std::string first_line(const std::string &text)
{
    const std::string line = text.substr(0, text.find('\n'));
    return line.empty() ? "not a picture OpenImageIO can read" : line;
}

Image read_opened(OIIO::ImageInput &input, const std::string &name, uint64_t encoded_size)
{
    const OIIO::ImageSpec &spec = input.spec();
    if (spec.deep || spec.depth > 1)
        fail(Exit::input, "'%s' is a deep or volume picture; lcor takes flat ones", name.c_str());
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0)
        fail(Exit::input, "'%s' has no pixels", name.c_str());
    Image image;
    image.width = static_cast<size_t>(spec.width);
    image.height = static_cast<size_t>(spec.height);
    image.channels = static_cast<size_t>(std::min(spec.nchannels, 4));
    image.format = input.format_name();
    if (spec.image_pixels() > max_pixels)
        fail(Exit::input, "'%s' has %zu x %zu pixels, more than the %llu lcor takes here",
             name.c_str(), image.width, image.height, static_cast<unsigned long long>(max_pixels));
    const OIIO::TypeDesc type = spec.format;
    image.type = type == OIIO::TypeDesc::UINT8    ? LCOR_U8
                 : type == OIIO::TypeDesc::UINT16 ? LCOR_U16
                                                  : LCOR_F32;
    const OIIO::TypeDesc wanted = image.type == LCOR_U8    ? OIIO::TypeDesc::UINT8
                                  : image.type == LCOR_U16 ? OIIO::TypeDesc::UINT16
                                                           : OIIO::TypeDesc::FLOAT;
    const uint64_t size = spec.image_pixels() * image.channels * wanted.size();
    if (encoded_size > 0 && size > ratio_floor && size / largest_ratio > encoded_size)
        fail(Exit::input, "'%s' claims %zu x %zu pixels in %llu bytes; the file is broken",
             name.c_str(), image.width, image.height,
             static_cast<unsigned long long>(encoded_size));
    image.bytes.resize(size);
    if (!input.read_image(0, 0, 0, static_cast<int>(image.channels), wanted, image.bytes.data()))
        fail(Exit::input, "cannot read the pixels of '%s': %s", name.c_str(),
             first_line(input.geterror()).c_str());
    return image;
}

/* Straight colours: what is drawn where, apart from how much of it shows. */
OIIO::ImageSpec open_hints()
{
    OIIO::ImageSpec hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);
    return hints;
}

/* Name whose extension lets OpenImageIO start with the right reader, for the kinds glTF may hold.
 */
const char *hint_name(const uint8_t *bytes, size_t size)
{
    const auto starts = [&](size_t offset, const char *magic, size_t length) {
        return size >= offset + length && std::memcmp(bytes + offset, magic, length) == 0;
    };
    if (starts(0, "\xff\xd8\xff", 3))
        return "x.jpg";
    if (starts(0, "\x89PNG", 4))
        return "x.png";
    return starts(8, "WEBP", 4) ? "x.webp" : nullptr;
}

} // namespace

double Image::sample(size_t x, size_t y, size_t channel) const
{
    const size_t i = (y * width + x) * channels + channel;
    if (type == LCOR_U8)
        return bytes[i] / 255.0;
    if (type == LCOR_U16) {
        uint16_t value;
        std::memcpy(&value, &bytes[i * sizeof value], sizeof value);
        return value / 65535.0;
    }
    float value;
    std::memcpy(&value, &bytes[i * sizeof value], sizeof value);
    return static_cast<double>(value);
}

Image read_image(const std::string &path)
{
    read_start(path, 1); /* says why a file cannot be opened, which OpenImageIO does not */
    const OIIO::ImageSpec hints = open_hints();
    const InputPointer input = OIIO::ImageInput::open(path, &hints);
    if (!input)
        fail(Exit::input, "cannot read '%s': %s", path.c_str(),
             first_line(OIIO::geterror()).c_str());
    return read_opened(*input, path, 0);
}

Image decode_image(const uint8_t *bytes, size_t size, const std::string &name)
{
    const char *const hint = hint_name(bytes, size);
    if (!hint)
        fail(Exit::input, "'%s' is neither JPEG, PNG nor WebP (%zu bytes)", name.c_str(), size);
    OIIO::Filesystem::IOMemReader reader(bytes, size);
    /* Some readers look for the bytes among the hints only. */
    OIIO::Filesystem::IOProxy *proxy = &reader;
    OIIO::ImageSpec hints = open_hints();
    hints.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const InputPointer input = OIIO::ImageInput::open(hint, &hints, &reader);
    if (!input)
        fail(Exit::input, "cannot decode '%s': %s", name.c_str(),
             first_line(OIIO::geterror()).c_str());
    return read_opened(*input, name, size);
}

} // namespace cli
