/* SPDX-License-Identifier: MIT */
#include "open_picture.h"

#include <OpenImageIO/filesystem.h>

#include <filesystem>

namespace cli
{

namespace
{

using InputPointer = std::unique_ptr<OIIO::ImageInput>;

/* Straight colours: what is drawn where, apart from how much of it shows. */
OIIO::ImageSpec open_hints()
{
    OIIO::ImageSpec hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);
    return hints;
}

/* OpenImageIO takes a bilevel TIFF that leaves out how many bits a sample has for one of 8 bits,
 * and makes up what the file does not hold. */
void check_bits(const OIIO::ImageInput &input, const std::string &path)
{
    const OIIO::ImageSpec &spec = input.spec();
    std::error_code unknown;
    if (std::string(input.format_name()) == "tiff" && spec.nchannels == 1 &&
        spec.get_int_attribute("tiff:Compression") == 1 &&
        spec.get_int_attribute("oiio:BitsPerSample", 8) == 8 &&
        std::filesystem::file_size(path, unknown) < spec.image_pixels())
        fail(Exit::input,
             "'%s' is shorter than its pixels; it is cut, or of 1 bit a sample without saying so",
             path.c_str());
}

InputPointer accepted(InputPointer input, const std::string &name)
{
    if (!input)
        fail(Exit::input, "cannot read '%s': %s", name.c_str(),
             first_line(OIIO::geterror()).c_str());
    const OIIO::ImageSpec &spec = input->spec();
    if (spec.deep || spec.depth > 1)
        fail(Exit::input, "'%s' is a deep or volume picture; lcor takes flat ones", name.c_str());
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0)
        fail(Exit::input, "'%s' has no pixels", name.c_str());
    return input;
}

} // namespace

std::string first_line(const std::string &text)
{
    const std::string line = text.substr(0, text.find('\n'));
    return line.empty() ? "not a picture OpenImageIO can read" : line;
}

InputPointer open_picture(const std::string &path)
{
    read_start(path, 1); /* says why a file cannot be opened, which OpenImageIO does not */
    const OIIO::ImageSpec hints = open_hints();
    InputPointer input = accepted(OIIO::ImageInput::open(path, &hints), path);
    check_bits(*input, path);
    return input;
}

InputPointer open_picture(OIIO::Filesystem::IOProxy &reader, const char *hint,
                          const std::string &name)
{
    /* Some readers look for the bytes among the hints only. */
    OIIO::Filesystem::IOProxy *proxy = &reader;
    OIIO::ImageSpec hints = open_hints();
    hints.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    return accepted(OIIO::ImageInput::open(hint, &hints, &reader), name);
}

int count_pictures(OIIO::ImageInput &input, const std::string &name)
{
    if (std::string(input.format_name()) == "psd")
        return 1;
    int count = 1;
    while (input.seek_subimage(count, 0))
        count++;
    static_cast<void>(input.geterror()); /* that there are no more is no error */
    if (count > 1 && !input.seek_subimage(0, 0))
        fail(Exit::input, "cannot read '%s': %s", name.c_str(),
             first_line(input.geterror()).c_str());
    return count;
}

} // namespace cli
