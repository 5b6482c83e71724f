/* SPDX-License-Identifier: MIT */
#include "render.h"
#include "stream.h"

#include <algorithm>
#include <mutex>
#include <sha2.h>

namespace cli
{

namespace
{

/* Rows developed before they are written: bounded memory, and work for all threads. */
constexpr size_t write_rows = 256;

/* What sha256sum prints for the file. */
std::string sha256(const std::string &path)
{
    char digits[SHA256_DIGEST_STRING_LENGTH];
    if (SHA256File(path.c_str(), digits) == nullptr)
        fail(Exit::input, "'%s' can no longer be read: it was there when lcor began", path.c_str());
    return digits;
}

} // namespace

std::string command_line(const std::string &name, const Arguments &arguments)
{
    std::string line = "lcor " + name;
    for (size_t i = 0; i < arguments.size(); i++) {
        const std::string &argument = arguments[i];
        if (argument == "-o" || argument == "--threads")
            i++;
        if (argument == "-o" || argument.rfind("--threads", 0) == 0 || argument == "--quiet" ||
            argument == "--json")
            continue;
        const bool plain =
            !argument.empty() &&
            argument.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                       "0123456789-_=+,./:@%") == std::string::npos;
        line += " ";
        if (plain) {
            line += argument;
            continue;
        }
        line += "'";
        for (const char c : argument)
            line += c == '\'' ? std::string("'\\''") : std::string(1, c);
        line += "'";
    }
    return line;
}

Json Provenance::json() const
{
    Json document = {{"software", std::string("lcor ") + lcor_version()}, {"command", command}};
    for (const std::string &path : inputs)
        document["inputs"][path] = "sha256:" + sha256(path);
    document.update(details);
    return document;
}

void describe(OIIO::ImageSpec &spec, const Provenance &provenance)
{
    spec.attribute("Software", std::string("lcor ") + lcor_version());
    spec.attribute("ImageDescription", provenance.json().dump());
}

void PictureFormat::declare(Options &options)
{
    options.choice("--bits", {"auto", "8", "16", "32"}, bits,
                   "a sample: 8, 16, or 32 (linear floats); default 8, for .exr and .hdr 32");
}

OIIO::TypeDesc PictureFormat::type(const std::string &path) const
{
    const std::string extension = extension_of(path);
    const bool always_float = extension == "exr" || extension == "hdr";
    if (bits == 3 && !holds_floats(path))
        fail(Exit::usage, "'%s' cannot hold floats; write .exr or .tif", path.c_str());
    if (bits == 3 || (bits == 0 && always_float))
        return OIIO::TypeDesc::FLOAT;
    if (always_float)
        fail(Exit::usage, "'%s' holds floats only; leave out --bits, or write .tif or .png",
             path.c_str());
    if (bits == 2 && extension != "png" && extension != "tif" && extension != "tiff")
        fail(Exit::usage, "'%s' cannot hold 16 bits; write .png or .tif", path.c_str());
    return bits == 2 ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8;
}

lcor_row_stats write_picture(const std::string &path, const Picture &picture,
                             const Developer &developer, const PictureFormat &format,
                             const CorrectionOptions &correction, const Device &device,
                             const Provenance &provenance)
{
    const OIIO::TypeDesc type = format.type(path);
    const bool floats = type == OIIO::TypeDesc::FLOAT;
    const lcor_colour stored = correction.colour(floats);
    const Encoder encoder(type, holds_alpha(path) && !picture.opaque(), stored, device.tone_curve);
    const size_t width = picture.width(), row_bytes = encoder.row_bytes(width);
    OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(picture.height()),
                         static_cast<int>(encoder.channels()), type);
    if (encoder.channels() == 4) {
        spec.alpha_channel = 3;
        spec.attribute("oiio:UnassociatedAlpha", 1);
    }
    describe(spec, provenance);
    PictureWriter writer(path, spec);
    lcor_row_stats stats = {};
    Progress progress("picture");
    std::mutex mutex;
    std::vector<uint8_t> block(std::min(write_rows, picture.height()) * row_bytes);
    for (size_t y0 = 0; y0 < picture.height(); y0 += write_rows) {
        const size_t y1 = std::min(y0 + write_rows, picture.height());
        picture.each_band(y0, y1, [&](size_t from, size_t to) {
            lcor_row_stats part = {};
            std::vector<float> rgba(4 * width);
            for (size_t y = from; y < to; y++) {
                developer.row(y, rgba.data(), part);
                for (size_t x = 0; x < width && writer.premultiplied(); x++)
                    for (size_t c = 0; c < 3; c++)
                        rgba[4 * x + c] *= rgba[4 * x + 3];
                encoder.row(rgba.data(), width, &block[(y - y0) * row_bytes]);
            }
            const std::lock_guard<std::mutex> lock(mutex);
            Developer::add(stats, part);
        });
        writer.write(y0, y1, type, block.data());
        progress.report(static_cast<double>(y1) / static_cast<double>(picture.height()));
    }
    writer.commit();
    return stats;
}

} // namespace cli
