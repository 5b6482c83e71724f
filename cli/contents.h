/* SPDX-License-Identifier: MIT */
/* What a scene file holds, whatever its format: readers fill it, build_scene() makes a scene of it.
 */
#ifndef LCOR_CLI_CONTENTS_H
#define LCOR_CLI_CONTENTS_H

#include "scene.h"

#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace cli
{

using Vec3 = std::array<double, 3>;

inline Vec3 operator+(const Vec3 &a, const Vec3 &b)
{
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 operator-(const Vec3 &a, const Vec3 &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator*(double s, const Vec3 &a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vec3 &a, const Vec3 &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vec3 &a) { return std::sqrt(dot(a, a)); }
inline Vec3 cross(const Vec3 &a, const Vec3 &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Vertex {
    Vec3 position;
    std::array<double, 2> uv;
    Vec3 colour;
};

struct Triangle {
    std::array<Vertex, 3> corner;
    size_t group;
};

struct Contents {
    std::vector<Triangle> triangles;
    std::vector<Group> groups;
    std::vector<Material> materials; /* the last one is for surfaces that name none */
    std::vector<Texture> textures;
    std::vector<Image> images;
    std::vector<lcor_light> lights;
    std::vector<SceneCamera> cameras;
    std::vector<double> measured;      /* lcor_reflectance of each glTF material, < 0: not said */
    std::set<std::string> unsupported; /* each said once */
};

/* A small file must not become a huge scene. */
constexpr size_t triangle_limit = 4000000;

/* Exit::input if the machine has not the memory for so many. */
void check_triangles(size_t count, const std::string &name);

/* Read and convert a file. Exit::input names file, place and reason. */
Contents load_gltf(const std::string &path, Threads &threads);
Contents load_obj(const std::string &path, Threads &threads);
bool named_obj(const std::string &path);

/* The folder part of a path with its slash, "./" if there is none. */
std::string folder_beside(const std::string &path);

/* Merge, judge and commit what a file holds. */
Scene build_scene(Contents contents, const SceneOptions &options, const std::string &name,
                  Threads &threads);

} // namespace cli

#endif
