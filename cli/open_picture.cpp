/* SPDX-License-Identifier: MIT */
#include "open_picture.h"

#include <OpenImageIO/filesystem.h>

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
    return accepted(OIIO::ImageInput::open(path, &hints), path);
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
