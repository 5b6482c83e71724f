/* SPDX-License-Identifier: MIT */
/* What `lcor render` and `lcor paper` share. */
#ifndef LCOR_CLI_RENDER_H
#define LCOR_CLI_RENDER_H

#include "develop.h"
#include "encode.h"

namespace cli
{

/* Width and height; height 0: whatever the camera's shape makes of the width. */
struct PictureSize {
    size_t width = 1280, height = 0;
    /* "1920x1080", or Exit::usage. */
    static PictureSize parse(const std::string &text);
};

/* The scene's camera of that name or number from 0; its first one for an empty name; one that sees
 * the whole scene if it has none. */
SceneCamera choose_camera(const Scene &scene, const std::string &name);
lcor_camera sized_camera(const SceneCamera &camera, const PictureSize &size);

/* What a picture was made from, for its metadata and the report. */
struct Provenance { // NOLINT(bugprone-exception-escape): moving Json asserts, and does not throw
    std::string command;             /* "lcor render ..." */
    std::vector<std::string> inputs; /* paths: hashed */
    Json details;                    /* contrast, r_mean, tolerance reached, ... */
    Json json() const;
};

/* How a corrected picture is stored. */
struct PictureFormat {
    int bits = 0; /* index into {"auto", "8", "16", "32"} */
    void declare(Options &options);
    OIIO::TypeDesc type(const std::string &path) const; /* Exit::usage if the format cannot */
};

/* Develops the picture and writes it. */
lcor_row_stats write_picture(const std::string &path, const Picture &picture,
                             const Developer &developer, const PictureFormat &format,
                             const CorrectionOptions &correction, const Device &device,
                             const Provenance &provenance);

/* Puts the provenance into a file's metadata. */
void describe(OIIO::ImageSpec &spec, const Provenance &provenance);

/* "lcor NAME ARGUMENTS", quoted as a shell would want it, without what cannot change the picture:
 * the output's name, threads, messages. */
std::string command_line(const std::string &name, const Arguments &arguments);

} // namespace cli

#endif
