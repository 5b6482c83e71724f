/* SPDX-License-Identifier: MIT */
#include "render.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

constexpr size_t largest_side = 65535;
constexpr double default_aspect = 4.0 / 3.0;

/* Looks down at the scene's bounding sphere from the front right, as far away as it takes. */
SceneCamera whole_view(const Scene &scene)
{
    constexpr double angle = 0.7, distance = 1.05;
    const double towards[3] = {-0.45, -0.4, -0.8};
    const double length = std::hypot(towards[0], towards[1], towards[2]);
    const double radius =
        0.5 * std::hypot(scene.high[0] - scene.low[0], scene.high[1] - scene.low[1],
                         scene.high[2] - scene.low[2]);
    SceneCamera camera = {"", {}, default_aspect};
    for (size_t k = 0; k < 3; k++) {
        camera.camera.forward[k] = towards[k];
        camera.camera.position[k] = 0.5 * (scene.low[k] + scene.high[k]) -
                                    towards[k] / length * distance * radius / std::sin(0.5 * angle);
    }
    camera.camera.up[1] = 1.0; /* glTF's */
    camera.camera.fov_y = angle;
    return camera;
}

std::string camera_names(const Scene &scene)
{
    std::string names;
    for (const SceneCamera &camera : scene.cameras)
        names += (names.empty() ? "" : ", ") + (camera.name.empty() ? "(no name)" : camera.name);
    return names;
}

} // namespace

PictureSize PictureSize::parse(const std::string &text)
{
    const std::vector<std::string> parts = split(text, 'x');
    PictureSize size;
    size_t *const sides[2] = {&size.width, &size.height};
    for (size_t i = 0; i < 2; i++) {
        const std::optional<double> n = parts.size() == 2 ? parse_number(parts[i]) : std::nullopt;
        if (!n || !(*n >= 1.0 && *n <= largest_side) || *n != std::floor(*n))
            fail(Exit::usage, "--size wants WIDTHxHEIGHT in pixels, 1 to %zu each, not '%s'",
                 largest_side, text.c_str());
        *sides[i] = static_cast<size_t>(*n);
    }
    return size;
}

SceneCamera choose_camera(const Scene &scene, const std::string &name)
{
    if (name.empty())
        return scene.cameras.empty() ? whole_view(scene) : scene.cameras[0];
    for (const SceneCamera &camera : scene.cameras)
        if (camera.name == name)
            return camera;
    const std::optional<double> number = parse_number(name);
    for (size_t i = 0; number && i < scene.cameras.size(); i++)
        if (*number == static_cast<double>(i))
            return scene.cameras[i];
    if (scene.cameras.empty())
        fail(Exit::usage, "--camera %s: the scene has no camera; without --camera it is seen whole",
             name.c_str());
    fail(Exit::usage, "--camera %s: the scene's cameras are %s", name.c_str(),
         camera_names(scene).c_str());
}

lcor_camera sized_camera(const SceneCamera &camera, const PictureSize &size)
{
    lcor_camera sized = camera.camera;
    const double aspect = camera.aspect > 0.0 ? camera.aspect : default_aspect;
    sized.size_x = size.width;
    sized.size_y =
        size.height > 0
            ? size.height
            : std::clamp<size_t>(
                  static_cast<size_t>(std::lround(static_cast<double>(size.width) / aspect)), 1,
                  largest_side);
    return sized;
}

} // namespace cli
