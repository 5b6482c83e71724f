/* SPDX-License-Identifier: MIT */
/* `lcor info`: what a profile, scene or picture holds. */
#include "contents.h"
#include "pixels.h"
#include "stream.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

enum class Kind { scene, profile, picture };

Kind kind_of(const std::string &path, const std::string &start)
{
    for (const char *extension : {".gltf", ".glb"})
        if (path.size() > 5 && path.find(extension, path.size() - 5) != std::string::npos)
            return Kind::scene;
    if (named_obj(path))
        return Kind::scene;
    const size_t first = start.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    if (start.compare(0, 4, "glTF") == 0 || (first != std::string::npos && start[first] == '{'))
        return Kind::scene;
    /* Portable anymaps and Radiance pictures begin with text. */
    const bool anymap = start.size() > 2 && start[0] == 'P' &&
                        std::strchr("1234567fFzZ", start[1]) && std::strchr(" \t\r\n#", start[2]);
    const bool binary =
        std::any_of(start.begin(), start.end(),
                    [](char c) {
                        return static_cast<unsigned char>(c) < ' ' && !std::strchr("\t\r\n\f", c);
                    }) ||
        start.find('\0') != std::string::npos;
    return binary || anymap || start.compare(0, 2, "#?") == 0 ? Kind::picture : Kind::profile;
}

Json profile_info(const std::string &path)
{
    const std::string text = read_file(path, uint64_t(64) << 20);
    lcor_error error = {};
    lcor_profile *parsed = nullptr;
    check(lcor_profile_parse(text.data(), text.size(), nullptr, &parsed, &error), error,
          Exit::bad_profile, "'" + path + "' as a profile");
    const std::unique_ptr<lcor_profile, ProfileDeleter> owner(parsed);
    lcor_profile_result result = {};
    check(lcor_profile_evaluate(parsed, &result, &error), error, Exit::bad_profile,
          "'" + path + "' as a profile");
    Json keywords = Json::object();
    for (size_t i = 0; i < lcor_profile_keyword_count(parsed); i++) {
        const char *const name = lcor_profile_keyword_name(parsed, i);
        keywords[name] = lcor_profile_keyword(parsed, name);
    }
    return {{"kind", "profile"},
            {"contrast", result.contrast},
            {"contrast_u95", result.contrast_u95},
            {"d_min", result.d_min},
            {"d_max", result.d_max},
            {"readings", lcor_profile_count(parsed)},
            {"readings_of_white", result.n_min},
            {"readings_of_black", result.n_max},
            {"grey_levels", lcor_profile_grey_levels(parsed)},
            {"keywords", std::move(keywords)}};
}

Json scene_info(const std::string &path)
{
    Threads threads(0);
    SceneOptions options;
    options.need_light = false;
    const Scene scene = load_scene(path, options, threads);
    Json cameras = Json::array(), surfaces = Json::array();
    for (const SceneCamera &camera : scene.cameras)
        cameras.push_back(camera.name);
    double area = 0.0, reflected = 0.0;
    size_t quads = 0, patches = 0;
    for (size_t i = 0; i < scene.surfaces.size(); i++) {
        const SurfaceInfo &surface = scene.surfaces[i];
        size_t n = 0;
        lcor_error error = {};
        check(lcor_scene_patch_count(scene.scene.get(), i, &n, &error), error, Exit::failed,
              "patches");
        patches += n;
        area += surface.area;
        reflected += surface.area * surface.reflectance;
        quads += surface.quad ? 1 : 0;
    }
    return {{"kind", "scene"},
            {"triangles", scene.triangles},
            {"triangles_without_area", scene.dropped},
            {"surfaces", scene.surfaces.size()},
            {"parallelograms", quads},
            {"patches", patches},
            {"area", area},
            {"mean_reflectance", area > 0.0 ? reflected / area : 0.0},
            {"low", {scene.low[0], scene.low[1], scene.low[2]}},
            {"high", {scene.high[0], scene.high[1], scene.high[2]}},
            {"lights", scene.lights},
            {"emitters", scene.emitters},
            {"channels", scene.channels},
            {"materials", scene.materials.size() - 1},
            {"textures", scene.textures.size()},
            {"cameras", std::move(cameras)}};
}

Json picture_info(const std::string &path)
{
    PictureReader picture(path);
    const OIIO::ImageSpec &spec = picture.spec();
    CorrectionOptions defaults;
    const lcor_colour colour = defaults.colour(picture.float_samples());
    const PixelRows rows(spec.format, spec.format, picture.premultiplied(), picture.width(),
                         picture.channels(), spec.alpha_channel);
    LuminanceSum luminance(colour, rows, picture.height());
    const size_t step = picture.band_rows(size_t(4) << 20);
    std::vector<uint8_t> band(step * rows.bytes());
    for (size_t y0 = 0; y0 < picture.height(); y0 += step) {
        const size_t y1 = std::min(y0 + step, picture.height());
        picture.read(y0, y1, rows.type(), band.data());
        for (size_t y = y0; y < y1; y++) {
            uint8_t *const row = &band[(y - y0) * rows.bytes()];
            if (picture.premultiplied())
                rows.divide_by_alpha(row);
            luminance.add(y, row);
        }
    }
    return {{"kind", "picture"},
            {"format", picture.format()},
            {"width", picture.width()},
            {"height", picture.height()},
            {"channels", picture.channels()},
            {"samples", spec.format.c_str()},
            {"alpha", spec.alpha_channel < 0    ? "none"
                      : picture.premultiplied() ? "premultiplied"
                                                : "straight"},
            {"icc_profile", spec.get_string_attribute("ICCProfile:profile_description")},
            {"reflectance", luminance.mean()}};
}

void print_people(const Json &info)
{
    for (const auto &[key, value] : info.items()) {
        std::string name = key;
        std::replace(name.begin(), name.end(), '_', ' ');
        if (value.is_object()) {
            for (const auto &[inner, text] : value.items())
                std::printf("%-24s %s\n", inner.c_str(), text.get<std::string>().c_str());
        } else if (value.is_string()) {
            std::printf("%-24s %s\n", name.c_str(), value.get<std::string>().c_str());
        } else if (value.is_number_float()) {
            std::printf("%-24s %s\n", name.c_str(), number_text(value.get<double>()).c_str());
        } else {
            std::printf("%-24s %s\n", name.c_str(), value.dump().c_str());
        }
    }
}

} // namespace

Exit run_info(const Arguments &arguments)
{
    Options options("lcor info FILE", "What a device profile, a scene or a picture holds.");
    if (!options.parse(arguments))
        return Exit::ok;
    const std::string path = options.operand("a file");
    Json info{{"file", path}};
    switch (kind_of(path, read_start(path, 4096))) {
    case Kind::scene: info.update(scene_info(path)); break;
    case Kind::profile: info.update(profile_info(path)); break;
    case Kind::picture: info.update(picture_info(path)); break;
    }
    if (!json_wanted())
        print_people(info);
    print_json(info);
    return Exit::ok;
}

} // namespace cli
