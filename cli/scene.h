/* SPDX-License-Identifier: MIT */
/* A scene file as liblcor wants it, and what a renderer needs besides: which texture lies where on
 * which surface, and the cameras. */
#ifndef LCOR_CLI_SCENE_H
#define LCOR_CLI_SCENE_H

#include "cli.h"
#include "image.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace cli
{

struct SceneDeleter {
    void operator()(lcor_scene *scene) const { lcor_scene_free(scene); }
};
using ScenePointer = std::unique_ptr<lcor_scene, SceneDeleter>;

struct SolutionDeleter {
    void operator()(lcor_solution *solution) const { lcor_solution_free(solution); }
};
using SolutionPointer = std::unique_ptr<lcor_solution, SolutionDeleter>;

enum class Wrap { repeat, clamp, mirror };

struct Texture {
    size_t image; /* index into Scene::images */
    Wrap wrap_u, wrap_v;
    bool nearest; /* the file asks for no filtering when magnified */
    bool srgb;    /* samples are sRGB-encoded (integers); linear otherwise (floats) */
};

struct Material {
    std::string name;
    double colour[4] = {1.0, 1.0, 1.0, 1.0}; /* linear base colour factor and alpha */
    int texture = -1;                        /* index into Scene::textures, -1: none */
    double emission[3] = {0.0, 0.0, 0.0};    /* linear luminance [cd/m2] with strength */
    int emission_texture = -1;
    bool double_sided = false;
};

/* Triangles of one object and material share this. */
struct Group {
    std::string name; /* for messages */
    size_t material;
    std::array<size_t, 2> patches{0, 0}; /* lcor_patches, 0: not said */
    double reflectance = -1.0;           /* lcor_reflectance, < 0: not said */
};

/* What lies on surface i of the lcor_scene. At lcor_hit (u, v) the texture coordinate is
 * uv[0] + u uv[1] + v uv[2], (0, 0) the upper left corner of the picture; the vertex colour
 * (linear, multiplies the base colour) likewise. */
struct SurfaceInfo {
    size_t material;
    double uv[3][2];
    double colour[3][3];
    double reflectance; /* rho [1] as solved: luminance */
    double
        texture_reflectance; /* area mean of what is drawn: 5.2's factor is the ratio of the two */
    double area;
    bool quad;                     /* else a triangle */
    std::array<size_t, 2> patches; /* grid; a triangle's two are equal */
    size_t group;                  /* index into Scene::groups */
    bool back_to_back;             /* one side of a wall whose other side is another surface */
};

struct SceneCamera {
    std::string name;
    lcor_camera camera; /* size_x and size_y are 0 */
    double aspect;      /* width / height as the file asks, 0: not said */
};

struct Scene {
    ScenePointer scene;                /* committed */
    std::vector<SurfaceInfo> surfaces; /* one for each surface of `scene` */
    std::vector<Group> groups;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Image> images;
    std::vector<SceneCamera> cameras;
    int channels = 0; /* for lcor_radiosity_options.channels */
    std::string channels_reason;
    lcor_colour colour;     /* linear, of --space: whose Y row luminance means */
    double low[3], high[3]; /* bounding box */
    size_t triangles = 0, dropped = 0, lights = 0, emitters = 0;

    bool lit() const { return lights > 0 || emitters > 0; }
    /* Luminance of the `channels` values a solution gives (1 or 3). */
    double luminance(const double *values, int value_channels) const;
};

struct SceneOptions {
    int space = LCOR_PRIMARIES_SRGB;
    int patches = 0; /* grid of surfaces that name none, 0: 1 x 1 */
    bool one_sided = false;
    int channels = 0;                /* index into {"auto", "1", "3"} */
    std::vector<std::string> lights; /* --light x,y,z,I */
    bool need_light = true;

    void declare(Options &table);       /* with --patches N */
    void declare_light(Options &table); /* all but --patches */
};

/* Load, merge, judge, commit. Warnings are said once each. Exit::input names file, node and reason;
 * a scene without any light is an error naming --light when need_light is set. */
Scene load_scene(const std::string &path, const SceneOptions &options, Threads &threads);

struct SolveOptions {
    double tolerance = 0.01;
    int norm = -1;  /* lcor_norm; -1: rms, and for pictures by links both */
    int engine = 0; /* lcor_engine */
    double max_seconds = 0.0;
    uint64_t points = 0; /* places that will be asked for; 0: many */

    void declare(Options &options);
};

/* Solve with progress; warns when the tolerance was not reached. */
SolutionPointer solve(const Scene &scene, const SolveOptions &options, Threads &threads);
/* The same, by engine links to that tolerance at the worst place too unless a norm was named: eyes
 * see the seam of two elements that a root mean square does not tell. */
SolutionPointer solve_for_picture(const Scene &scene, const SolveOptions &options,
                                  Threads &threads);
/* The solution's report for --json and --report. */
Json report_json(const Scene &scene, const lcor_solution *solution);
/* Which engine solved it and what it was estimated to take, for people. */
void say_engine(const lcor_solution *solution);

} // namespace cli

#endif
