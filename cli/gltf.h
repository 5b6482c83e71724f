/* SPDX-License-Identifier: MIT */
/* Reading glTF 2.0: file -> model (gltf_file), model -> triangles, materials, lights and cameras in
 * world coordinates (gltf, gltf_accessor, gltf_material, gltf_light). */
#ifndef LCOR_CLI_GLTF_H
#define LCOR_CLI_GLTF_H

#include "contents.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tinygltf
{
class Model;
class Value;
struct Light;
struct Material;
struct Primitive;
} // namespace tinygltf

namespace cli
{

/* Column-major 4 x 4, as glTF stores it; the last row is 0 0 0 1. */
struct Transform {
    std::array<double, 16> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    Transform operator*(const Transform &right) const;
    Vec3 point(const Vec3 &p) const;
    Vec3 vector(const Vec3 &v) const;
    double determinant() const; /* of the upper 3 x 3 */
};

using ImageDecoder = Image (*)(const uint8_t *bytes, size_t size, const std::string &name);

/* A .gltf or .glb from memory; what lies beside it is looked for in `folder`, nowhere if empty. */
Contents parse_gltf(const std::string &bytes, const std::string &name, const std::string &folder,
                    Threads &threads, ImageDecoder decoder = decode_image);

/* ---- between the files of the reader ---- */

/* Raw bytes of the model's images, as found: decoding comes later. */
struct EncodedImage {
    std::vector<uint8_t> bytes;
    std::string problem; /* not found or not readable */
};

struct ModelFile {
    std::string name;
    std::unique_ptr<tinygltf::Model> model;
    std::vector<EncodedImage> images;
    ImageDecoder decoder;
    uint64_t bytes; /* in all buffers: no honest accessor holds more elements */
    ModelFile();
    ~ModelFile();
};

void read_model(const std::string &bytes, const std::string &folder, ModelFile &file);
/* Read, or without effect on what lcor computes. */
bool understood_extension(const std::string &name);
/* count x components numbers, normalised integers as 0..1 or -1..1, sparse ones filled in.
 * `components` 0 takes what is there. Exit::input names accessor and reason. */
struct Accessor {
    size_t count = 0, components = 0;
    std::vector<double> values;
};
Accessor read_accessor(const ModelFile &file, int index, size_t components);
std::vector<uint32_t> read_indices(const ModelFile &file, int index);

void convert_materials(const ModelFile &file, Contents &contents, Threads &threads);
/* Texture coordinates of a material: which TEXCOORD set, and KHR_texture_transform (row-major 2x3).
 */
struct UvSource {
    int set = 0;
    std::array<double, 6> transform{1, 0, 0, 0, 1, 0};
};
UvSource uv_source(const ModelFile &file, int material);
void convert_light(const ModelFile &file, const tinygltf::Light &from, const Transform &world,
                   const std::string &node, Contents &contents);
void convert_camera(const ModelFile &file, int index, const Transform &world,
                    const std::string &node, Contents &contents);

double extras_number(const tinygltf::Value &extras, const char *key); /* -1: not there */

} // namespace cli

#endif
