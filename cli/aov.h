/* SPDX-License-Identifier: MIT */
/* Auxiliary pictures of a view: what stands behind its pixels. */
#ifndef LCOR_CLI_AOV_H
#define LCOR_CLI_AOV_H

#include "render.h"

namespace cli
{

/* `NAME=FILE` of --aov. */
struct AovRequest {
    size_t kind; /* index into the table of names */
    std::string path;
};

/* Exit::usage for a name or file format that cannot be. */
std::vector<AovRequest> parse_aovs(const std::vector<std::string> &texts);
/* The names with a line each, for `--aov list`. */
std::string aov_list();

struct AovInput {
    const Picture &picture;
    const Developer &developer;
    const CorrectionOptions &correction;
    const Device &device;
    double r_mean;
};

void write_aov(const AovRequest &request, const AovInput &input, const Provenance &provenance);

/* falsecolour.cpp: illuminance by a scale of colours, with the scale beside it. `lux` has one value
 * a pixel, negative where no surface is seen. */
void write_false_colour(const std::string &path, const std::vector<float> &lux, size_t width,
                        size_t height, const Provenance &provenance);

} // namespace cli

#endif
