/* SPDX-License-Identifier: MIT */
#include "glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cli
{

namespace
{

using Vec = std::array<double, 3>;

enum {
    FLOAT = 5126,
    UNSIGNED_SHORT = 5123,
    LINEAR = 9729,
    LINEAR_MIPMAP_LINEAR = 9987,
    REPEAT = 10497
};

Vec minus(const Vec &a, const Vec &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Vec crossed(const Vec &a, const Vec &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec unit(const Vec &a)
{
    const double size = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    return {a[0] / size, a[1] / size, a[2] / size};
}

void append_u32(std::string &out, size_t value)
{
    for (int i = 0; i < 4; i++)
        out.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}

} // namespace

GlbWriter::GlbWriter(std::string generator)
{
    document_ = {{"asset", {{"version", "2.0"}, {"generator", std::move(generator)}}},
                 {"extensionsUsed", {"KHR_lights_punctual"}},
                 {"scene", 0},
                 {"scenes", {{{"nodes", Json::array()}}}}};
}

int GlbWriter::add_view(const void *bytes, size_t size)
{
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    document_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", size}});
    buffer_.append(static_cast<const char *>(bytes), size);
    return static_cast<int>(document_["bufferViews"].size()) - 1;
}

int GlbWriter::add_floats(const std::vector<float> &values, int components, bool bounds)
{
    const size_t n = static_cast<size_t>(components);
    Json accessor = {{"bufferView", add_view(values.data(), values.size() * sizeof(float))},
                     {"componentType", static_cast<int>(FLOAT)},
                     {"count", values.size() / n},
                     {"type", components == 3 ? "VEC3" : "VEC2"}};
    for (size_t c = 0; bounds && c < n; c++) {
        float low = values[c], high = values[c];
        for (size_t i = c; i < values.size(); i += n) {
            low = std::min(low, values[i]);
            high = std::max(high, values[i]);
        }
        accessor["min"].push_back(low);
        accessor["max"].push_back(high);
    }
    document_["accessors"].push_back(std::move(accessor));
    return static_cast<int>(document_["accessors"].size()) - 1;
}

int GlbWriter::add_node(Json node)
{
    document_["nodes"].push_back(std::move(node));
    const int index = static_cast<int>(document_["nodes"].size()) - 1;
    document_["scenes"][0]["nodes"].push_back(index);
    return index;
}

int GlbWriter::add_texture(const std::string &name, const std::string &bytes, const char *mime)
{
    document_["images"].push_back(
        {{"name", name}, {"mimeType", mime}, {"bufferView", add_view(bytes.data(), bytes.size())}});
    if (!document_.contains("samplers"))
        document_["samplers"].push_back({{"magFilter", static_cast<int>(LINEAR)},
                                         {"minFilter", static_cast<int>(LINEAR_MIPMAP_LINEAR)},
                                         {"wrapS", static_cast<int>(REPEAT)},
                                         {"wrapT", static_cast<int>(REPEAT)}});
    document_["textures"].push_back({{"sampler", 0}, {"source", document_["images"].size() - 1}});
    return static_cast<int>(document_["textures"].size()) - 1;
}

int GlbWriter::add_material(const std::string &name, double rho, int texture)
{
    Json surface = {{"metallicFactor", 0.0}};
    if (texture >= 0)
        surface["baseColorTexture"] = {{"index", texture}};
    else
        surface["baseColorFactor"] = {rho, rho, rho, 1.0};
    document_["materials"].push_back(
        {{"name", name}, {"pbrMetallicRoughness", std::move(surface)}});
    return static_cast<int>(document_["materials"].size()) - 1;
}

void GlbWriter::add_quad(const GlbQuad &quad)
{
    if (indices_ < 0) {
        const uint16_t corners[] = {0, 1, 2, 0, 2, 3};
        document_["accessors"].push_back({{"bufferView", add_view(corners, sizeof corners)},
                                          {"componentType", static_cast<int>(UNSIGNED_SHORT)},
                                          {"count", 6},
                                          {"type", "SCALAR"}});
        indices_ = static_cast<int>(document_["accessors"].size()) - 1;
    }
    const Vec normal = unit(crossed(quad.edge_u, quad.edge_v));
    std::vector<float> positions, normals, uvs;
    for (size_t i = 0; i < 4; i++) {
        const double s = i == 1 || i == 2 ? 1.0 : 0.0, t = i >= 2 ? 1.0 : 0.0;
        for (size_t k = 0; k < 3; k++) {
            positions.push_back(
                static_cast<float>(quad.origin[k] + s * quad.edge_u[k] + t * quad.edge_v[k]));
            normals.push_back(static_cast<float>(normal[k]));
        }
        uvs.push_back(static_cast<float>(quad.uv[i][0]));
        uvs.push_back(static_cast<float>(quad.uv[i][1]));
    }
    Json extras = {{"lcor_patches", {quad.patches[0], quad.patches[1]}}};
    if (quad.reflectance >= 0.0)
        extras["lcor_reflectance"] = quad.reflectance;
    const Json attributes = {{"POSITION", add_floats(positions, 3, true)},
                             {"NORMAL", add_floats(normals, 3, false)},
                             {"TEXCOORD_0", add_floats(uvs, 2, false)}};
    document_["meshes"].push_back({{"name", quad.name},
                                   {"primitives",
                                    {{{"attributes", attributes},
                                      {"indices", indices_},
                                      {"material", quad.material},
                                      {"extras", std::move(extras)}}}}});
    add_node({{"name", quad.name}, {"mesh", document_["meshes"].size() - 1}});
}

void GlbWriter::add_point_light(const std::string &name, const std::array<double, 3> &position,
                                double intensity)
{
    Json &lights = document_["extensions"]["KHR_lights_punctual"]["lights"];
    lights.push_back({{"type", "point"}, {"name", name}, {"intensity", intensity}});
    add_node({{"name", name},
              {"translation", position},
              {"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}}});
}

void GlbWriter::add_camera(const std::string &name, const std::array<double, 3> &eye,
                           const std::array<double, 3> &target, const std::array<double, 3> &up,
                           double fov_y, double aspect)
{
    const Vec back = unit(minus(eye, target)), right = unit(crossed(up, back));
    const Vec top = crossed(back, right);
    document_["cameras"].push_back(
        {{"name", name},
         {"type", "perspective"},
         {"perspective", {{"yfov", fov_y}, {"aspectRatio", aspect}, {"znear", 0.001}}}});
    add_node({{"name", name},
              {"camera", document_["cameras"].size() - 1},
              {"matrix",
               {right[0], right[1], right[2], 0.0, top[0], top[1], top[2], 0.0, back[0], back[1],
                back[2], 0.0, eye[0], eye[1], eye[2], 1.0}}});
}

std::string GlbWriter::finish()
{
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    document_["buffers"] = {{{"byteLength", buffer_.size()}}};
    std::string json = document_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string out = "glTF";
    append_u32(out, 2);
    append_u32(out, 12 + 8 + json.size() + 8 + buffer_.size());
    append_u32(out, json.size());
    out += "JSON" + json;
    append_u32(out, buffer_.size());
    out.append("BIN\0", 4);
    return out + buffer_;
}

} // namespace cli
