/* SPDX-License-Identifier: MIT */
#include "shapes.h"

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

/* A closed room that loses no light has no answer. */
constexpr double fullest = 0.98;

double luminance_of(const lcor_colour &colour, const double rgb[3])
{
    return colour.to_xyz[3] * rgb[0] + colour.to_xyz[4] * rgb[1] + colour.to_xyz[5] * rgb[2];
}

/* Lights of one colour need one channel only (the paper's model); others ask for three. */
class LightColours
{
  public:
    void add(const double rgb[3])
    {
        const double most = std::max({rgb[0], rgb[1], rgb[2]});
        if (!(most > 0.0))
            return;
        for (size_t c = 0; c < 3; c++) {
            const double share = rgb[c] / most;
            differ_ = differ_ || (known_ && std::fabs(share - share_[c]) > 1e-4);
            if (!known_)
                share_[c] = share;
        }
        known_ = true;
    }
    bool differ() const { return differ_; }

  private:
    bool known_ = false, differ_ = false;
    double share_[3] = {0.0, 0.0, 0.0};
};

class Builder
{
  public:
    Builder(Contents &contents, const SceneOptions &options, const std::string &name)
        : contents_(contents), options_(options), name_(name)
    {
        lcor_error error = {};
        check(lcor_colour_init(&out_.colour, static_cast<lcor_primaries>(options.space), nullptr,
                               LCOR_TRANSFER_LINEAR, 1.0, LCOR_LIGHTNESS_CIE, &error),
              error, Exit::usage, "--space");
        lcor_scene *scene = nullptr;
        check(lcor_scene_new(nullptr, &scene, &error), error, Exit::failed, name_);
        out_.scene.reset(scene);
    }

    Scene build(Threads &threads)
    {
        add_given_lights();
        add_surfaces();
        for (const lcor_light &light : contents_.lights)
            add_light(light);
        say_what_is_missing();
        lcor_error error = {};
        const lcor_parallel parallel = threads.parallel();
        check(lcor_scene_commit(out_.scene.get(), &parallel, &error), error, Exit::input,
              "scene '" + name_ + "'");
        out_.materials = std::move(contents_.materials);
        out_.textures = std::move(contents_.textures);
        out_.images = std::move(contents_.images);
        out_.cameras = std::move(contents_.cameras);
        out_.groups = std::move(contents_.groups);
        return std::move(out_);
    }

  private:
    void add_given_lights()
    {
        for (const std::string &text : options_.lights) {
            const std::vector<double> n = parse_numbers(text, 4, "--light");
            if (n[3] < 0.0)
                fail(Exit::usage, "--light %s: the intensity is negative", text.c_str());
            lcor_light light = {};
            std::copy_n(n.begin(), 3, light.position);
            std::fill_n(light.intensity, 3, n[3]);
            contents_.lights.push_back(light);
        }
    }

    struct Look {
        Vec3 drawn, shines; /* mean colour, exitance */
    };

    /* Of millions of triangles there shall not be more copies at a time than needed. */
    void add_surfaces()
    {
        out_.triangles = contents_.triangles.size();
        std::vector<Shape> shapes = make_shapes(contents_, name_, &out_.dropped);
        contents_.triangles = {};
        if (out_.dropped > 0)
            warn("scene '%s': triangles without area are left out: %zu of %zu", name_.c_str(),
                 out_.dropped, out_.triangles);
        if (shapes.empty())
            fail(Exit::input, "scene '%s' has no surface; does its default scene hold a mesh?",
                 name_.c_str());
        const size_t twins = settle_twins(shapes);
        if (twins > 0)
            warn("scene '%s': surfaces that lie exactly on another one are left out: %zu",
                 name_.c_str(), twins);
        const std::vector<Look> looks = measure(shapes);
        out_.surfaces.reserve(shapes.size());
        for (size_t i = 0; i < shapes.size(); i++)
            add_surface(shapes[i], looks[i]);
    }

    /* Means of every surface, and whether the light has colours. */
    std::vector<Look> measure(const std::vector<Shape> &shapes)
    {
        std::vector<Look> looks;
        looks.reserve(shapes.size());
        TextureMeans means(contents_, shapes.size());
        LightColours colours;
        for (const lcor_light &light : contents_.lights)
            colours.add(light.intensity);
        for (const Shape &shape : shapes) {
            const Material &material = contents_.materials[contents_.groups[shape.group].material];
            Vec3 drawn = means.mean(material.texture, shape), shines{0.0, 0.0, 0.0};
            for (size_t c = 0; c < 3; c++)
                drawn[c] *= material.colour[c];
            if (material.emission[0] + material.emission[1] + material.emission[2] > 0.0) {
                Shape plain = shape; /* vertex colours do not tint what is emitted */
                for (Vertex &corner : plain.corner)
                    corner.colour = {1.0, 1.0, 1.0};
                shines = means.mean(material.emission_texture, plain);
                for (size_t c = 0; c < 3; c++)
                    shines[c] *= pi * material.emission[c];
                colours.add(shines.data());
            }
            looks.push_back({drawn, shines});
        }
        coloured_ = options_.channels == 2 || (options_.channels == 0 && colours.differ());
        out_.channels = coloured_ ? 3 : 1;
        out_.channels_reason = options_.channels != 0 ? lcor_reason_text(LCOR_REASON_ASKED)
                               : coloured_            ? "lights differ in colour"
                                                      : "all lights have one colour";
        return looks;
    }

    /* One channel: all three hold the luminance. */
    void to_channels(const double rgb[3], double out[3]) const
    {
        for (size_t c = 0; c < 3; c++)
            out[c] = coloured_ ? rgb[c] : luminance_of(out_.colour, rgb);
    }

    void add_surface(const Shape &shape, const Look &look)
    {
        const Group &group = contents_.groups[shape.group];
        const Material &material = contents_.materials[group.material];
        SurfaceInfo info = {};
        info.material = group.material;
        info.group = shape.group;
        const Vertex *const corner[3] = {&shape.corner[0], &shape.corner[1],
                                         &shape.corner[shape.quad ? 3 : 2]};
        for (size_t k = 0; k < 2; k++)
            for (size_t i = 0; i < 3; i++)
                info.uv[i][k] = corner[i]->uv[k] - (i > 0 ? corner[0]->uv[k] : 0.0);
        for (size_t c = 0; c < 3; c++)
            for (size_t i = 0; i < 3; i++)
                info.colour[i][c] = corner[i]->colour[c] - (i > 0 ? corner[0]->colour[c] : 0.0);
        const Vec3 u = corner[1]->position - corner[0]->position;
        const Vec3 v = corner[2]->position - corner[0]->position;
        info.area = length(cross(u, v)) * (shape.quad ? 1.0 : 0.5);

        const Vec3 &drawn = look.drawn;
        info.texture_reflectance = luminance_of(out_.colour, drawn.data());
        Vec3 reflectance = drawn;
        if (group.reflectance >= 0.0) {
            const double scale =
                info.texture_reflectance > 0.0 ? group.reflectance / info.texture_reflectance : 0.0;
            reflectance = info.texture_reflectance > 0.0
                              ? scale * drawn
                              : Vec3{group.reflectance, group.reflectance, group.reflectance};
        }
        lcor_surface surface = {};
        to_channels(reflectance.data(), surface.reflectance);
        bool full = false;
        for (double &rho : surface.reflectance)
            if (rho >= 1.0 - 1e-9) {
                rho = fullest;
                full = true;
            }
        if (full && full_++ == 0)
            first_full_ = group.name;
        info.reflectance = luminance_of(out_.colour, surface.reflectance);
        to_channels(look.shines.data(), surface.emission);
        out_.emitters += *std::max_element(surface.emission, surface.emission + 3) > 0.0 ? 1 : 0;
        info.back_to_back = shape.back_to_back;
        surface.two_sided = !shape.back_to_back && (!options_.one_sided || material.double_sided);
        for (size_t k = 0; k < 2; k++)
            surface.patches[k] = options_.patches > 0 ? static_cast<size_t>(options_.patches)
                                                      : std::max<size_t>(group.patches[k], 1);
        if (!shape.quad) /* cut into n x n triangles */
            surface.patches[0] = surface.patches[1] =
                std::max(surface.patches[0], surface.patches[1]);
        info.quad = shape.quad;
        info.patches = {surface.patches[0], surface.patches[1]};
        lcor_error error = {};
        const double *const origin = corner[0]->position.data();
        check(shape.quad
                  ? lcor_scene_add_quad(out_.scene.get(), origin, u.data(), v.data(), &surface,
                                        nullptr, &error)
                  : lcor_scene_add_triangle(out_.scene.get(), origin, corner[1]->position.data(),
                                            corner[2]->position.data(), &surface, nullptr, &error),
              error, Exit::input, "scene '" + name_ + "', " + group.name);
        grow_box(shape);
        out_.surfaces.push_back(info);
    }

    void grow_box(const Shape &shape)
    {
        for (size_t i = 0; i < (shape.quad ? 4U : 3U); i++)
            for (size_t k = 0; k < 3; k++) {
                const double x = shape.corner[i].position[k];
                const bool first = out_.surfaces.empty() && i == 0;
                out_.low[k] = first ? x : std::min(out_.low[k], x);
                out_.high[k] = first ? x : std::max(out_.high[k], x);
            }
    }

    void add_light(lcor_light light)
    {
        const Vec3 rgb{light.intensity[0], light.intensity[1], light.intensity[2]};
        to_channels(rgb.data(), light.intensity);
        lcor_error error = {};
        check(lcor_scene_add_light(out_.scene.get(), &light, nullptr, &error), error, Exit::input,
              "scene '" + name_ + "'");
        out_.lights += *std::max_element(light.intensity, light.intensity + 3) > 0.0 ? 1 : 0;
    }

    void say_what_is_missing()
    {
        for (const std::string &feature : contents_.unsupported)
            warn("scene '%s': not supported: %s", name_.c_str(), feature.c_str());
        if (full_ > 0)
            warn("scene '%s': reflectance 1 is taken as %s on %s (first: %s)", name_.c_str(),
                 number_text(fullest).c_str(), counted(full_, "surface").c_str(),
                 first_full_.c_str());
        if (options_.need_light && !out_.lit())
            fail(Exit::input, "scene '%s' has no light; add one with --light x,y,z,I (candela)",
                 name_.c_str());
    }

    Contents &contents_;
    const SceneOptions &options_;
    const std::string &name_;
    Scene out_;
    bool coloured_ = false;
    size_t full_ = 0;
    std::string first_full_;
};

} // namespace

double Scene::luminance(const double *values, int value_channels) const
{
    return value_channels == 3 ? luminance_of(colour, values) : values[0];
}

void SceneOptions::declare(Options &table)
{
    declare_light(table);
    table.count("--patches", "N", patches,
                "N x N patches on every surface, whatever the file says");
}

void SceneOptions::declare_light(Options &table)
{
    table
        .choice("--space", {"ntsc", "srgb"}, space, "whose Y is luminance: eq 1, or sRGB (default)")
        .flag("--one-sided", one_sided, "surfaces reflect as the material's doubleSided flag says")
        .choice("--channels", {"auto", "1", "3"}, channels,
                "1: white interreflection (the paper's); 3: colours bleed")
        .list("--light", "x,y,z,I", lights, "add a point light of I candela; may be repeated");
}

std::string folder_beside(const std::string &path)
{
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? "./" : path.substr(0, slash + 1);
}

void check_triangles(size_t count, const std::string &name)
{
    constexpr double bytes = 1700.0; /* measured; with what a renderer needs besides */
    check_memory(bytes * static_cast<double>(count),
                 format("scene '%s' of %s", name.c_str(), counted(count, "triangle").c_str()),
                 "give its meshes fewer, or place them less often");
}

Scene build_scene(Contents contents, const SceneOptions &options, const std::string &name,
                  Threads &threads)
{
    check_triangles(contents.triangles.size(), name);
    return Builder(contents, options, name).build(threads);
}

Scene load_scene(const std::string &path, const SceneOptions &options, Threads &threads)
{
    return build_scene(named_obj(path) ? load_obj(path, threads) : load_gltf(path, threads),
                       options, path, threads);
}

} // namespace cli
