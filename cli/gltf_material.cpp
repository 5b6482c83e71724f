/* SPDX-License-Identifier: MIT */
/* glTF materials, textures and pictures. */
#include "gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace cli
{

namespace
{

double clamped(double value, double low, double high)
{
    return std::isfinite(value) ? std::clamp(value, low, high) : low;
}

void read_factor(const std::vector<double> &from, size_t count, double high, double *out)
{
    for (size_t i = 0; i < std::min(count, from.size()); i++)
        out[i] = clamped(from[i], 0.0, high);
}

double extension_number(const tinygltf::ExtensionMap &extensions, const char *name, const char *key,
                        double otherwise)
{
    const auto found = extensions.find(name);
    if (found == extensions.end() || !found->second.Has(key))
        return otherwise;
    const tinygltf::Value &value = found->second.Get(key);
    return value.IsNumber() && std::isfinite(value.GetNumberAsDouble()) ? value.GetNumberAsDouble()
                                                                        : otherwise;
}

/* Texture index as it stands, or -1 when it names nothing that can be drawn. */
int usable(const ModelFile &file, int index)
{
    const std::vector<tinygltf::Texture> &textures = file.model->textures;
    if (index < 0)
        return -1;
    if (static_cast<size_t>(index) >= textures.size())
        fail(Exit::input, "scene '%s': no texture %d", file.name.c_str(), index);
    return index;
}

void name_unsupported(const tinygltf::Material &from, Contents &contents)
{
    std::set<std::string> &names = contents.unsupported;
    const auto metallic = from.values.find("metallicFactor");
    if ((metallic != from.values.end() && metallic->second.number_value > 0.0) ||
        from.pbrMetallicRoughness.metallicRoughnessTexture.index >= 0)
        names.insert("metallic surfaces (taken as diffuse)");
    if (from.normalTexture.index >= 0)
        names.insert("normal maps");
    if (from.occlusionTexture.index >= 0)
        names.insert("occlusion maps (lcor computes the light itself)");
    if (from.alphaMode != "OPAQUE")
        names.insert("transparency (alphaMode " + from.alphaMode + " is drawn opaque)");
    if (from.emissiveTexture.index >= 0 && from.pbrMetallicRoughness.baseColorTexture.index >= 0 &&
        from.emissiveTexture.texCoord != from.pbrMetallicRoughness.baseColorTexture.texCoord)
        names.insert("an emissive texture with coordinates of its own");
}

Material convert(const ModelFile &file, const tinygltf::Material &from)
{
    Material material;
    material.name = from.name;
    read_factor(from.pbrMetallicRoughness.baseColorFactor, 4, 1.0, material.colour);
    material.texture = usable(file, from.pbrMetallicRoughness.baseColorTexture.index);
    read_factor(from.emissiveFactor, 3, 1e9, material.emission);
    const double strength =
        clamped(extension_number(from.extensions, "KHR_materials_emissive_strength",
                                 "emissiveStrength", 1.0),
                0.0, 1e9);
    for (double &channel : material.emission)
        channel *= strength;
    material.emission_texture = usable(file, from.emissiveTexture.index);
    material.double_sided = from.doubleSided;
    return material;
}

Wrap convert_wrap(int wrap)
{
    return wrap == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::clamp
           : wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror
                                                           : Wrap::repeat;
}

/* -1 when its picture is of a kind glTF does not know or is missing. */
int image_of(const ModelFile &file, const tinygltf::Texture &texture)
{
    int source = static_cast<int>(std::clamp(
        extension_number(texture.extensions, "EXT_texture_webp", "source", texture.source), -1.0,
        1e9));
    return source >= 0 && static_cast<size_t>(source) < file.model->images.size() ? source : -1;
}

Texture convert(const ModelFile &file, const tinygltf::Texture &from, size_t image)
{
    Texture texture{image, Wrap::repeat, Wrap::repeat, false, true};
    if (from.sampler >= 0 && static_cast<size_t>(from.sampler) < file.model->samplers.size()) {
        const tinygltf::Sampler &sampler = file.model->samplers[static_cast<size_t>(from.sampler)];
        texture.wrap_u = convert_wrap(sampler.wrapS);
        texture.wrap_v = convert_wrap(sampler.wrapT);
        texture.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    return texture;
}

/* Decode pictures that are drawn, several at a time. `problems` gets what went wrong, if anything.
 */
void decode(const ModelFile &file, const std::vector<int> &wanted, Contents &contents,
            Threads &threads, std::vector<std::string> &problems)
{
    contents.images.resize(wanted.size());
    problems.resize(wanted.size());
    threads.run(wanted.size(), [&](size_t i) {
        const size_t source = static_cast<size_t>(wanted[i]);
        const EncodedImage &encoded = file.images[source];
        const tinygltf::Image &image = file.model->images[source];
        std::string name = !image.name.empty() ? image.name : image.uri;
        if (name.empty() || name.compare(0, 5, "data:") == 0)
            name = format("image %zu", source);
        problems[i] = encoded.problem;
        if (!problems[i].empty())
            return;
        try {
            contents.images[i] = file.decoder(encoded.bytes.data(), encoded.bytes.size(), name);
        } catch (const Error &error) {
            problems[i] = error.what();
        }
    });
}

} // namespace

double extras_number(const tinygltf::Value &extras, const char *key)
{
    if (!extras.IsObject() || !extras.Has(key) || !extras.Get(key).IsNumber())
        return -1.0;
    return extras.Get(key).GetNumberAsDouble();
}

void convert_materials(const ModelFile &file, Contents &contents, Threads &threads)
{
    const tinygltf::Model &model = *file.model;
    for (const tinygltf::Material &from : model.materials) {
        name_unsupported(from, contents);
        contents.materials.push_back(convert(file, from));
        contents.measured.push_back(extras_number(from.extras, "lcor_reflectance"));
    }
    contents.materials.emplace_back();
    contents.materials.back().name = "glTF's default";
    contents.measured.push_back(-1.0);

    /* Only textures that are drawn, each picture once. */
    std::vector<int> wanted, image_at(model.images.size(), -1),
        texture_at(model.textures.size(), -1);
    const auto place = [&](int texture) {
        const int source =
            texture < 0 ? -1 : image_of(file, model.textures[static_cast<size_t>(texture)]);
        if (source < 0 || image_at[static_cast<size_t>(source)] >= 0)
            return;
        image_at[static_cast<size_t>(source)] = static_cast<int>(wanted.size());
        wanted.push_back(source);
    };
    for (const Material &material : contents.materials) {
        place(material.texture);
        place(material.emission_texture);
    }
    std::vector<std::string> problems;
    decode(file, wanted, contents, threads, problems);
    for (size_t i = 0; i < problems.size(); i++) {
        const std::string where =
            format("scene '%s', texture picture %d", file.name.c_str(), wanted[i]);
        if (!problems[i].empty())
            warn("%s: %s; drawn in its factor's colour alone", where.c_str(), problems[i].c_str());
        warn_of_others(where, contents.images[i].pictures);
    }

    const auto link = [&](int &texture) {
        if (texture < 0)
            return;
        const size_t index = static_cast<size_t>(texture);
        const int source = image_of(file, model.textures[index]);
        const int image = source < 0 ? -1 : image_at[static_cast<size_t>(source)];
        if (source < 0)
            contents.unsupported.insert("a texture without a picture lcor can decode");
        if (image < 0 || !problems[static_cast<size_t>(image)].empty()) {
            texture = -1;
            return;
        }
        if (texture_at[index] < 0) {
            texture_at[index] = static_cast<int>(contents.textures.size());
            contents.textures.push_back(
                convert(file, model.textures[index], static_cast<size_t>(image)));
            contents.textures.back().srgb =
                contents.images[static_cast<size_t>(image)].type != LCOR_F32;
        }
        texture = texture_at[index];
    };
    for (Material &material : contents.materials) {
        link(material.texture);
        link(material.emission_texture);
    }
}

UvSource uv_source(const ModelFile &file, int material)
{
    UvSource source;
    if (material < 0 || static_cast<size_t>(material) >= file.model->materials.size())
        return source;
    const tinygltf::Material &from = file.model->materials[static_cast<size_t>(material)];
    const tinygltf::TextureInfo &info = from.pbrMetallicRoughness.baseColorTexture.index >= 0
                                            ? from.pbrMetallicRoughness.baseColorTexture
                                            : from.emissiveTexture;
    source.set = info.texCoord;
    const auto found = info.extensions.find("KHR_texture_transform");
    if (found == info.extensions.end())
        return source;
    const auto pair = [&](const char *key, double otherwise, double out[2]) {
        out[0] = out[1] = otherwise;
        if (!found->second.Has(key))
            return;
        const tinygltf::Value &value = found->second.Get(key);
        for (int i = 0; i < 2 && value.ArrayLen() == 2; i++)
            if (value.Get(i).IsNumber() && std::isfinite(value.Get(i).GetNumberAsDouble()))
                out[i] = value.Get(i).GetNumberAsDouble();
    };
    double offset[2], scale[2];
    pair("offset", 0.0, offset);
    pair("scale", 1.0, scale);
    const double angle =
        extension_number(info.extensions, "KHR_texture_transform", "rotation", 0.0);
    const double set =
        extension_number(info.extensions, "KHR_texture_transform", "texCoord", source.set);
    source.set = static_cast<int>(std::clamp(set, 0.0, 1e6));
    const double c = std::cos(angle), s = std::sin(angle);
    /* The extension's translation * rotation * scale. */
    source.transform = {c * scale[0],  s * scale[1], offset[0],
                        -s * scale[0], c * scale[1], offset[1]};
    return source;
}

} // namespace cli
