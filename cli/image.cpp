/* SPDX-License-Identifier: MIT */
#include "image.h"

#include "open_picture.h"

#include <OpenImageIO/filesystem.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

constexpr uint64_t max_pixels = uint64_t(1) << 28;
/* A header may promise more than its file holds: no coding of real pictures shrinks them further.
 */
constexpr uint64_t largest_ratio = 2048, ratio_floor = uint64_t(1) << 22;

Image read_opened(OIIO::ImageInput &input, const std::string &name, uint64_t encoded_size)
{
    const OIIO::ImageSpec &spec = input.spec();
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
    image.pictures = count_pictures(input, name);
    image.bytes.resize(size);
    if (!input.read_image(0, 0, 0, static_cast<int>(image.channels), wanted, image.bytes.data()))
        fail(Exit::input, "cannot read the pixels of '%s': %s", name.c_str(),
             first_line(input.geterror()).c_str());
    return image;
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

Image read_image(const std::string &path) { return read_opened(*open_picture(path), path, 0); }

Image decode_image(const uint8_t *bytes, size_t size, const std::string &name)
{
    const char *const hint = hint_name(bytes, size);
    if (!hint)
        fail(Exit::input, "'%s' is neither JPEG, PNG nor WebP (%zu bytes)", name.c_str(), size);
    OIIO::Filesystem::IOMemReader reader(bytes, size);
    return read_opened(*open_picture(reader, hint, name), name, size);
}

void warn_of_others(const std::string &where, int pictures)
{
    if (pictures > 1)
        warn("%s holds %d pictures; the first is taken", where.c_str(), pictures);
}

} // namespace cli
