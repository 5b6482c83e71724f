/* SPDX-License-Identifier: MIT */
#include "cli.h"

#include <limits>

namespace cli
{

namespace
{

enum { TONE_STEPS = 4096, PROFILE_LIMIT = 64 << 20 };

} // namespace

void DeviceOptions::declare(Options &options)
{
    options.text("--profile", "FILE", profile, "device profile that lccal measured (CGATS)")
        .number("--contrast", "C", contrast, "contrast of the device instead of a profile, > 1");
}

Device DeviceOptions::load(bool needed) const
{
    Device device;
    if (!needed && !given()) {
        device.contrast = std::numeric_limits<double>::infinity();
        return device;
    }
    if (profile.empty() == !contrast)
        fail(Exit::usage,
             profile.empty()
                 ? "which device? give --profile FILE (measured by lccal) or --contrast C"
                 : "--profile and --contrast exclude each other");
    if (contrast) {
        if (!(*contrast > 1.0))
            fail(Exit::usage, "--contrast must be greater than 1, not %s",
                 number_text(*contrast).c_str());
        device.contrast = *contrast;
    } else {
        const std::string text = read_file(profile, PROFILE_LIMIT, Exit::bad_profile);
        lcor_error error = {};
        lcor_profile *parsed = nullptr;
        const lcor_status status =
            lcor_profile_parse(text.data(), text.size(), nullptr, &parsed, &error);
        check(status, error, Exit::bad_profile, "profile '" + profile + "'");
        const std::unique_ptr<lcor_profile, ProfileDeleter> owner(parsed);
        device.profile = profile;
        device.contrast = lcor_profile_contrast(parsed);
        device.contrast_u95 = lcor_profile_contrast_u95(parsed);
        if (lcor_profile_grey_levels(parsed) > 0) {
            device.tone_curve.resize(TONE_STEPS);
            check(lcor_profile_tone_curve(parsed, TONE_STEPS, device.tone_curve.data(), &error),
                  error, Exit::bad_profile, "profile '" + profile + "'");
        }
    }
    if (device.contrast < 1.1)
        warn("a contrast of %s shows next to nothing; are the device's densities right?",
             number_text(device.contrast).c_str());
    return device;
}

CorrectionOptions::CorrectionOptions() : space(LCOR_PRIMARIES_SRGB), transfer("auto") {}

void CorrectionOptions::declare(Options &options, bool with_space)
{
    if (with_space)
        options.choice("--space", {"ntsc", "srgb"}, space, "primaries: eq 1, or sRGB (default)");
    options
        .choice("--reading", {"patch", "texel"}, reading,
                "what rho of r = alpha rho is: the surface's mean, or each texel's own")
        .text("--mean", "adaptive|literal|NUMBER", mean, "how r is averaged, or its mean")
        .number("--exponent", "T", exponent, "t of eq 8, default 1")
        .text("--transfer", "linear|srgb|gamma=G", transfer,
              "how samples are stored; default srgb, linear for floats")
        .choice("--lightness", {"cie", "paper"}, lightness,
                "f of eqs 2-4: CIE 1976, or the plain cube root")
        .choice("--gamut", {"keep-hue", "clip"}, gamut, "what colours outside RGB become")
        .flag("--conventional", conventional,
              "the conventional method for comparison (eq 19); needs no device");
}

lcor_mean_method CorrectionOptions::mean_method() const
{
    if (mean == "literal")
        return LCOR_MEAN_LITERAL;
    if (mean != "adaptive" && !given_mean())
        fail(Exit::usage, "--mean is adaptive, literal or a number, not '%s'", mean.c_str());
    return LCOR_MEAN_ADAPTIVE;
}

std::optional<double> CorrectionOptions::given_mean() const
{
    const std::optional<double> value = parse_number(mean);
    if (value && !(*value > 0.0))
        fail(Exit::usage, "--mean must be greater than 0, not %s", mean.c_str());
    return value;
}

lcor_colour CorrectionOptions::colour(bool float_samples) const
{
    lcor_transfer kind = float_samples ? LCOR_TRANSFER_LINEAR : LCOR_TRANSFER_SRGB;
    double gamma = 1.0;
    if (transfer == "linear") {
        kind = LCOR_TRANSFER_LINEAR;
    } else if (transfer == "srgb") {
        kind = LCOR_TRANSFER_SRGB;
    } else if (transfer.rfind("gamma=", 0) == 0 && parse_number(transfer.substr(6))) {
        kind = LCOR_TRANSFER_GAMMA;
        gamma = *parse_number(transfer.substr(6));
    } else if (transfer != "auto") {
        fail(Exit::usage, "--transfer is linear, srgb or gamma=2.2, not '%s'", transfer.c_str());
    }
    lcor_colour colour;
    lcor_error error = {};
    check(lcor_colour_init(&colour, static_cast<lcor_primaries>(space), nullptr, kind, gamma,
                           static_cast<lcor_lightness>(lightness), &error),
          error, Exit::usage, "--transfer");
    return colour;
}

lcor_plan_options CorrectionOptions::plan(const Device &device, const lcor_colour &colour) const
{
    if (!(exponent > 0.0))
        fail(Exit::usage, "--exponent must be greater than 0, not %s",
             number_text(exponent).c_str());
    lcor_plan_options options = {};
    options.struct_size = sizeof options;
    options.contrast = device.contrast;
    options.exponent = exponent;
    options.reading = static_cast<lcor_reading>(reading);
    options.gamut = static_cast<lcor_gamut>(gamut);
    options.colour = &colour;
    options.map_type = LCOR_F32;
    if (!device.tone_curve.empty()) {
        options.tone_curve = device.tone_curve.data();
        options.tone_size = device.tone_curve.size();
    }
    return options;
}

} // namespace cli
