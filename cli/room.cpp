/* SPDX-License-Identifier: MIT */
/* `lcor room`: the room of the paper's Table 3 as a glTF scene. */
#include "glb.h"
#include "image.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace cli
{

namespace
{

using Vec = std::array<double, 3>;

/* One face of an axis-aligned box: where it starts, which axis (and sign) its edges run along, and
 * the texture coordinates of its corners, so that pictures stand upright seen from inside. */
struct Face {
    const char *name;
    int origin[3]; /* 0 or 1 along each axis */
    int u, v;      /* axes */
    int uv[4][2];
};

/* z is up. The order and the letters are those of the reference solution; every face looks inwards
 * (edge_u x edge_v). The lower edge of a wall's picture lies on the floor; floor and ceiling are
 * seen by someone who looks along +y. */
const Face faces[6] = {
    {"floor", {0, 0, 0}, 0, 1, {{0, 1}, {1, 1}, {1, 0}, {0, 0}}},
    {"ceiling", {0, 0, 1}, 1, 0, {{0, 0}, {0, 1}, {1, 1}, {1, 0}}},
    {"x0", {0, 0, 0}, 1, 2, {{0, 1}, {1, 1}, {1, 0}, {0, 0}}},
    {"x1", {1, 0, 0}, 2, 1, {{1, 1}, {1, 0}, {0, 0}, {0, 1}}},
    {"y0", {0, 0, 0}, 2, 0, {{1, 1}, {1, 0}, {0, 0}, {0, 1}}},
    {"y1", {0, 1, 0}, 0, 2, {{0, 1}, {1, 1}, {1, 0}, {0, 0}}},
};

struct RoomOptions {
    std::string output, light = "0.3,0.4,0.7,1", reflectance = "0.3,0.8,0.5,0.5,0.5,0.5";
    bool measured = false; /* --reflectance was given: textured faces have it too (section 5.2) */
    std::vector<std::string> textures, boxes, cameras;
    int patches = 50;
};

const char *mime_of(const std::string &bytes)
{
    if (bytes.compare(0, 3, "\xff\xd8\xff") == 0)
        return "image/jpeg";
    if (bytes.compare(0, 4, "\x89PNG") == 0)
        return "image/png";
    return nullptr;
}

size_t face_index(const std::string &name)
{
    for (size_t i = 0; i < 6; i++)
        if (name == faces[i].name)
            return i;
    fail(Exit::usage, "--texture: no face '%s'; there are floor, ceiling, x0, x1, y0, y1",
         name.c_str());
}

/* FACE=FILE; one file on several faces is stored once. */
std::array<int, 6> add_textures(const RoomOptions &options, GlbWriter &glb)
{
    std::array<int, 6> textures;
    textures.fill(-1);
    std::map<std::string, int> known;
    for (const std::string &text : options.textures) {
        const size_t equals = text.find('=');
        if (equals == std::string::npos)
            fail(Exit::usage, "--texture wants FACE=FILE, not '%s'", text.c_str());
        const size_t face = face_index(text.substr(0, equals));
        const std::string path = text.substr(equals + 1);
        if (known.count(path) == 0) {
            const std::string bytes = read_file(path, uint64_t(1) << 30);
            const char *const mime = mime_of(bytes);
            if (!mime)
                fail(Exit::input,
                     "'%s' is neither JPEG nor PNG, and glTF holds no other pictures; convert it",
                     path.c_str());
            decode_image(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), path);
            const std::string name = path.substr(path.rfind('/') + 1);
            known[path] = glb.add_texture(name, bytes, mime);
        }
        textures[face] = known[path];
    }
    return textures;
}

double reflectance_of(double rho, const char *what)
{
    if (!(rho >= 0.0 && rho < 1.0))
        fail(Exit::usage, "%s: reflectance %s must lie in 0..1, below 1", what,
             number_text(rho).c_str());
    return rho;
}

/* The six faces of low..high; `outwards` turns them to look out of it. */
void add_faces(GlbWriter &glb, const Vec &low, const Vec &high, const std::string &prefix,
               bool outwards, int patches, const std::array<int, 6> &materials,
               const std::array<double, 6> &measured)
{
    for (size_t i = 0; i < 6; i++) {
        const Face &face = faces[i];
        GlbQuad quad;
        quad.name = prefix + face.name;
        quad.material = materials[i];
        quad.patches = {patches, patches};
        quad.reflectance = measured[i];
        for (size_t k = 0; k < 3; k++)
            quad.origin[k] = face.origin[k] ? high[k] : low[k];
        const auto edge = [&](int axis) {
            Vec out{0.0, 0.0, 0.0};
            const size_t k = static_cast<size_t>(axis);
            out[k] = high[k] - low[k];
            return out;
        };
        quad.edge_u = edge(outwards ? face.v : face.u);
        quad.edge_v = edge(outwards ? face.u : face.v);
        for (size_t k = 0; k < 4; k++)
            for (size_t c = 0; c < 2; c++)
                quad.uv[k][c] = face.uv[k][c];
        glb.add_quad(quad);
    }
}

void add_boxes(const RoomOptions &options, GlbWriter &glb)
{
    for (size_t i = 0; i < options.boxes.size(); i++) {
        const std::vector<double> n = parse_numbers(options.boxes[i], 7, "--box");
        const Vec low{n[0], n[2], n[4]}, high{n[1], n[3], n[5]};
        for (size_t k = 0; k < 3; k++)
            if (!(low[k] >= 0.0 && low[k] < high[k] && high[k] <= 1.0))
                fail(Exit::usage, "--box %s: want 0 <= x0 < x1 <= 1, and so for y and z",
                     options.boxes[i].c_str());
        const std::string name = format("box%zu", i + 1);
        std::array<int, 6> materials;
        materials.fill(glb.add_material(name, reflectance_of(n[6], "--box"), -1));
        std::array<double, 6> measured;
        measured.fill(-1.0);
        add_faces(glb, low, high, name + "-", true, std::max(options.patches / 5, 1), materials,
                  measured);
    }
}

/* The two views of Figure 4. Faces are drawn from their front only, so both look in from outside;
 * their angle makes the open side as wide as the picture. */
void add_cameras(const RoomOptions &options, GlbWriter &glb)
{
    constexpr double angle = 0.58, aspect = 4.0 / 3.0;
    glb.add_camera("side", {0.5, -1.25, 0.5}, {0.5, 0.5, 0.5}, {0.0, 0.0, 1.0}, angle, aspect);
    glb.add_camera("above", {0.5, 0.5, 2.25}, {0.5, 0.5, 0.5}, {0.0, 1.0, 0.0}, angle, aspect);
    for (size_t i = 0; i < options.cameras.size(); i++) {
        const size_t equals = options.cameras[i].find('=');
        const std::string name = equals == std::string::npos ? format("camera%zu", i + 1)
                                                             : options.cameras[i].substr(0, equals);
        const std::vector<double> n = parse_numbers(
            options.cameras[i].substr(equals == std::string::npos ? 0 : equals + 1), 7, "--camera");
        const Vec eye{n[0], n[1], n[2]}, target{n[3], n[4], n[5]};
        const Vec sight{target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]};
        const double level = std::hypot(sight[0], sight[1]), far = std::hypot(level, sight[2]);
        if (!(far > 0.0) || !(n[6] > 0.0 && n[6] < 180.0))
            fail(Exit::usage,
                 "--camera %s: eye and target must differ, the angle lie in 0..180 degrees",
                 options.cameras[i].c_str());
        /* Straight up or down, +y is at the top. */
        const Vec up = level > 1e-6 * far ? Vec{0.0, 0.0, 1.0} : Vec{0.0, 1.0, 0.0};
        glb.add_camera(name, eye, target, up, n[6] * 3.14159265358979323846 / 180.0, aspect);
    }
}

std::string make_room(const RoomOptions &options)
{
    const std::vector<double> rho = parse_numbers(options.reflectance, 6, "--reflectance");
    const std::vector<double> light = parse_numbers(options.light, 4, "--light");
    for (size_t k = 0; k < 3; k++)
        if (!(light[k] > 0.0 && light[k] < 1.0))
            fail(Exit::usage, "--light %s: the light must be inside the unit cube",
                 options.light.c_str());
    if (!(light[3] > 0.0))
        fail(Exit::usage, "--light %s: the intensity must be greater than 0",
             options.light.c_str());
    GlbWriter glb(std::string("lcor ") + lcor_version());
    const std::array<int, 6> textures = add_textures(options, glb);
    std::array<int, 6> materials;
    std::array<double, 6> measured;
    for (size_t i = 0; i < 6; i++) {
        reflectance_of(rho[i], "--reflectance");
        materials[i] = glb.add_material(faces[i].name, rho[i], textures[i]);
        measured[i] = options.measured && textures[i] >= 0 ? rho[i] : -1.0;
    }
    add_faces(glb, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, "", false, options.patches, materials,
              measured);
    add_boxes(options, glb);
    glb.add_point_light("light", {light[0], light[1], light[2]}, light[3]);
    add_cameras(options, glb);
    return glb.finish();
}

} // namespace

std::string paper_room(int patches)
{
    RoomOptions room;
    room.patches = patches;
    return make_room(room);
}

Exit run_room(const Arguments &arguments)
{
    RoomOptions room;
    Options options(
        "lcor room -o ROOM.glb [options]",
        "Write the room of the paper's Table 3 as a glTF scene: the unit cube seen from\n"
        "inside, z up, faces floor, ceiling, x0, x1, y0, y1, one point light, and the two\n"
        "cameras of Figure 4, `side` and `above`.");
    options.text("-o", "FILE", room.output, "the scene to write (.glb)")
        .text("--light", "x,y,z,I", room.light, "position and candela, default 0.3,0.4,0.7,1")
        .text("--reflectance", "f,c,x0,x1,y0,y1", room.reflectance,
              "of the faces, default 0.3,0.8,0.5,0.5,0.5,0.5 or the mean of their textures")
        .list("--texture", "FACE=FILE", room.textures,
              "put a JPEG or PNG on a face; may be repeated")
        .count("--patches", "N", room.patches, "N x N patches on each face, default 50")
        .list("--box", "x0,x1,y0,y1,z0,z1,rho", room.boxes,
              "put a box into the room; may be repeated")
        .list("--camera", "[NAME=]x,y,z,tx,ty,tz,deg", room.cameras,
              "one more camera: eye, target, vertical angle; may be repeated");
    if (!options.parse(arguments))
        return Exit::ok;
    if (!options.operands().empty())
        fail(Exit::usage, "'%s' is left over; lcor room takes options only",
             options.operands()[0].c_str());
    if (room.output.empty())
        fail(Exit::usage, "where to? give -o ROOM.glb");
    const std::string text_form = ".gltf";
    if (room.output.size() > text_form.size() &&
        room.output.compare(room.output.size() - text_form.size(), text_form.npos, text_form) == 0)
        fail(Exit::usage, "'%s': the scene is written in glTF's binary form; call it .glb",
             room.output.c_str());
    room.measured = options.given("--reflectance");
    const std::string bytes = make_room(room);
    write_file(room.output, bytes);
    say("%s: the paper's room, %d x %d patches a face, %s", room.output.c_str(), room.patches,
        room.patches, counted(room.textures.size(), "texture").c_str());
    print_json({{"output", room.output}, {"bytes", bytes.size()}, {"patches", room.patches}});
    return Exit::ok;
}

} // namespace cli
