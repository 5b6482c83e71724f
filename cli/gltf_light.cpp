/* SPDX-License-Identifier: MIT */
/* KHR_lights_punctual lights and cameras in world coordinates. Both look along their node's -z. */
#include "gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

constexpr double half_pi = 1.57079632679489661923;

void copy(const Vec3 &from, double to[3]) { std::copy(from.begin(), from.end(), to); }

Vec3 axis(const Transform &world, const Vec3 &local, const ModelFile &file, const std::string &node)
{
    const Vec3 v = world.vector(local);
    const double size = length(v);
    if (!(size > 0.0) || !std::isfinite(size))
        fail(Exit::input, "scene '%s', %s: its scale leaves a light or camera no direction",
             file.name.c_str(), node.c_str());
    return 1.0 / size * v;
}

} // namespace

void convert_light(const ModelFile &file, const tinygltf::Light &from, const Transform &world,
                   const std::string &node, Contents &contents)
{
    lcor_light light = {};
    const bool spot = from.type == "spot", directional = from.type == "directional";
    if (!spot && !directional && from.type != "point") {
        contents.unsupported.insert("lights of type '" + from.type + "'");
        return;
    }
    light.kind = spot ? LCOR_LIGHT_SPOT : directional ? LCOR_LIGHT_DIRECTIONAL : LCOR_LIGHT_POINT;
    if (!(from.intensity >= 0.0))
        warn("scene '%s', %s: a light's intensity must be 0 or more; taken as 0", file.name.c_str(),
             node.c_str());
    const double intensity = std::isfinite(from.intensity) ? std::max(from.intensity, 0.0) : 0.0;
    for (size_t c = 0; c < 3; c++) {
        const double colour = from.color.size() == 3 ? from.color[c] : 1.0;
        light.intensity[c] = intensity * (std::isfinite(colour) ? std::max(colour, 0.0) : 0.0);
    }
    copy(world.point({0.0, 0.0, 0.0}), light.position);
    if (spot || directional)
        copy(axis(world, {0.0, 0.0, -1.0}, file, node), light.direction);
    if (spot) {
        light.inner_cone = std::clamp(from.spot.innerConeAngle, 0.0, half_pi);
        light.outer_cone = std::clamp(from.spot.outerConeAngle, 0.0, half_pi);
        if (!(light.inner_cone < light.outer_cone)) {
            warn("scene '%s', %s: a spot light's inner cone must be smaller than its outer one",
                 file.name.c_str(), node.c_str());
            light.inner_cone = 0.999 * light.outer_cone;
        }
        if (!(light.outer_cone > 0.0))
            return;
    }
    if (!directional && std::isfinite(from.range) && from.range > 0.0)
        light.range = from.range;
    contents.lights.push_back(light);
}

void convert_camera(const ModelFile &file, int index, const Transform &world,
                    const std::string &node, Contents &contents)
{
    const tinygltf::Model &model = *file.model;
    if (static_cast<size_t>(index) >= model.cameras.size())
        fail(Exit::input, "scene '%s', %s: no camera %d", file.name.c_str(), node.c_str(), index);
    const tinygltf::Camera &from = model.cameras[static_cast<size_t>(index)];
    SceneCamera out;
    out.name = !from.name.empty() ? from.name : node;
    out.camera = {};
    copy(world.point({0.0, 0.0, 0.0}), out.camera.position);
    copy(axis(world, {0.0, 0.0, -1.0}, file, node), out.camera.forward);
    copy(axis(world, {0.0, 1.0, 0.0}, file, node), out.camera.up);
    const bool orthographic = from.type == "orthographic";
    if (orthographic) {
        out.camera.height = 2.0 * std::fabs(from.orthographic.ymag);
        out.aspect = from.orthographic.ymag != 0.0
                         ? std::fabs(from.orthographic.xmag / from.orthographic.ymag)
                         : 0.0;
        out.camera.z_near = from.orthographic.znear;
        out.camera.z_far = from.orthographic.zfar;
    } else {
        out.camera.fov_y = from.perspective.yfov;
        out.aspect = from.perspective.aspectRatio;
        out.camera.z_near = from.perspective.znear;
        out.camera.z_far = from.perspective.zfar;
    }
    const auto sound = [](double value) { return std::isfinite(value) && value > 0.0; };
    if (!sound(orthographic ? out.camera.height : out.camera.fov_y) ||
        out.camera.fov_y >= 2.0 * half_pi) {
        warn("scene '%s': camera '%s' has no usable angle or size; left out", file.name.c_str(),
             out.name.c_str());
        return;
    }
    if (!sound(out.aspect))
        out.aspect = 0.0;
    if (!sound(out.camera.z_near))
        out.camera.z_near = 0.0;
    if (!sound(out.camera.z_far))
        out.camera.z_far = 0.0;
    contents.cameras.push_back(out);
}

} // namespace cli
