/* SPDX-License-Identifier: MIT */
#include "encode.h"

#include <algorithm>
#include <cctype>
#include <cstring>

namespace cli
{

namespace
{

/* Steps of the curve: straight lines between them are within 2e-6 of sRGB's curve. */
constexpr size_t curve_steps = 16384;

template <typename T> void store(uint8_t *out, size_t i, float value, float scale)
{
    const T stored = static_cast<T>(value * scale + 0.5F);
    std::memcpy(out + i * sizeof stored, &stored, sizeof stored);
}

} // namespace

std::string extension_of(const std::string &path)
{
    const size_t dot = path.rfind('.'), slash = path.rfind('/');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash))
        return "";
    std::string extension = path.substr(dot + 1);
    for (char &c : extension)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

bool holds_alpha(const std::string &path)
{
    const std::string extension = extension_of(path);
    return extension != "jpg" && extension != "jpeg" && extension != "ppm" && extension != "hdr";
}

bool holds_floats(const std::string &path)
{
    const std::string extension = extension_of(path);
    return extension == "exr" || extension == "tif" || extension == "tiff" || extension == "hdr";
}

Encoder::Encoder(OIIO::TypeDesc type, bool alpha, const lcor_colour &stored,
                 const std::vector<float> &tone)
    : type_(type), alpha_(alpha), curve_(curve_steps + 2)
{
    for (size_t i = 0; i < curve_.size(); i++) {
        const double linear = std::min(static_cast<double>(i) / curve_steps, 1.0);
        if (tone.empty()) {
            curve_[i] = static_cast<float>(lcor_transfer_from_linear(&stored, linear));
        } else {
            const double at = linear * static_cast<double>(tone.size() - 1);
            const size_t left = std::min(static_cast<size_t>(at), tone.size() - 2);
            curve_[i] = tone[left] + static_cast<float>(at - static_cast<double>(left)) *
                                         (tone[left + 1] - tone[left]);
        }
    }
}

float Encoder::stored(float linear) const
{
    const float at = std::clamp(linear, 0.0F, 1.0F) * static_cast<float>(curve_steps);
    const size_t left = static_cast<size_t>(at);
    return curve_[left] + (at - static_cast<float>(left)) * (curve_[left + 1] - curve_[left]);
}

void Encoder::row(const float *rgba, size_t width, uint8_t *out) const
{
    const size_t n = channels();
    for (size_t x = 0; x < width; x++) {
        const float *const pixel = rgba + 4 * x;
        for (size_t c = 0; c < n; c++) {
            const size_t i = x * n + c;
            const float linear = c < 3 && !alpha_ ? pixel[c] * pixel[3] : pixel[c];
            if (type_ == OIIO::TypeDesc::UINT8)
                store<uint8_t>(out, i, c < 3 ? stored(linear) : linear, 255.0F);
            else if (type_ == OIIO::TypeDesc::UINT16)
                store<uint16_t>(out, i, c < 3 ? stored(linear) : linear, 65535.0F);
            else
                std::memcpy(out + i * sizeof linear, &linear, sizeof linear);
        }
    }
}

} // namespace cli
