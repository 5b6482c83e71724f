/* SPDX-License-Identifier: MIT */
/* glTF text or binary -> tinygltf's model, with its pictures still encoded. */
#include "gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <sys/stat.h>

namespace cli
{

namespace
{

/* tinygltf walks "extras" by recursion; honest files nest a dozen levels deep. */
constexpr int nesting_limit = 200;
constexpr uint64_t file_limit = (uint64_t(1) << 31) - 64;

struct Reader {
    ModelFile *file;
    std::string folder;
};

bool file_exists(const std::string &path, void *user)
{
    struct stat info = {};
    return !static_cast<Reader *>(user)->folder.empty() && stat(path.c_str(), &info) == 0 &&
           S_ISREG(info.st_mode);
}

/* Names are taken as they stand: no shell words, no home folders. */
std::string keep_path(const std::string &path, void *) { return path; }

bool read_whole(std::vector<unsigned char> *out, std::string *error, const std::string &path,
                void *)
{
    try {
        const std::string bytes = read_file(path, file_limit);
        out->assign(bytes.begin(), bytes.end());
        return true;
    } catch (const Error &problem) {
        *error = problem.what();
        return false;
    }
}

/* Called with the bytes of a picture that is a file or stands in a data URI. For one in a buffer
 * view the pointer was not checked against the buffer: those are fetched later. */
bool keep_image(tinygltf::Image *image, const int index, std::string *, std::string *, int, int,
                const unsigned char *bytes, int size, void *user)
{
    std::vector<EncodedImage> &images = static_cast<Reader *>(user)->file->images;
    if (index < 0)
        return false;
    if (images.size() <= static_cast<size_t>(index))
        images.resize(static_cast<size_t>(index) + 1);
    if (image->bufferView < 0 && size > 0)
        images[static_cast<size_t>(index)].bytes.assign(bytes, bytes + size);
    return true;
}

bool nested_too_deep(const char *text, size_t size)
{
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < size; i++) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\')
                i++;
            else if (c == '"')
                quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            if (++depth > nesting_limit)
                return true;
        } else if (c == '}' || c == ']') {
            depth--;
        }
    }
    return false;
}

std::string first_sentence(std::string text)
{
    while (!text.empty() && (text[0] == '\n' || text[0] == ' '))
        text.erase(0, 1);
    text = text.substr(0, std::min(text.find('\n'), size_t(200)));
    return text.empty() ? "not glTF 2.0" : text;
}

/* A file that requires an extension says that it is wrong without it. This comes before tinygltf's
 * own complaint, which is of what the extension would have explained. */
void check_required(const ModelFile &file)
{
    for (const std::string &name : file.model->extensionsRequired)
        if (!understood_extension(name))
            fail(Exit::input,
                 "scene '%s' requires the extension %s, which lcor does not read; "
                 "export it without",
                 file.name.c_str(), name.c_str());
}

void fetch_images(ModelFile &file)
{
    const tinygltf::Model &model = *file.model;
    file.images.resize(model.images.size());
    for (size_t i = 0; i < model.images.size(); i++) {
        const int view_index = model.images[i].bufferView;
        EncodedImage &image = file.images[i];
        if (view_index >= 0 && static_cast<size_t>(view_index) < model.bufferViews.size()) {
            const tinygltf::BufferView &view = model.bufferViews[static_cast<size_t>(view_index)];
            const bool known =
                view.buffer >= 0 && static_cast<size_t>(view.buffer) < model.buffers.size();
            const std::vector<unsigned char> *const data =
                known ? &model.buffers[static_cast<size_t>(view.buffer)].data : nullptr;
            if (data && view.byteOffset <= data->size() &&
                view.byteLength <= data->size() - view.byteOffset)
                image.bytes.assign(data->begin() + static_cast<long>(view.byteOffset),
                                   data->begin() +
                                       static_cast<long>(view.byteOffset + view.byteLength));
            else
                image.problem = "its buffer view lies outside the buffer";
        } else if (image.bytes.empty()) {
            image.problem = "no such file '" + model.images[i].uri + "'";
        }
    }
}

} // namespace

bool understood_extension(const std::string &name)
{
    static const std::set<std::string> names{
        "KHR_lights_punctual",   "KHR_materials_emissive_strength",
        "KHR_texture_transform", "KHR_mesh_quantization",
        "EXT_texture_webp",      "KHR_xmp_json_ld"};
    return names.count(name) > 0;
}

ModelFile::ModelFile() : model(std::make_unique<tinygltf::Model>()), decoder(decode_image), bytes(0)
{
}
ModelFile::~ModelFile() = default;

void read_model(const std::string &bytes, const std::string &folder, ModelFile &file)
{
    const bool binary = bytes.compare(0, 4, "glTF") == 0;
    const size_t first = bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    if (!binary && (first == std::string::npos || bytes[first] != '{'))
        fail(Exit::input, "'%s' is no scene lcor reads: glTF (.gltf, .glb) or Wavefront OBJ (.obj)",
             file.name.c_str());
    uint32_t json_size = static_cast<uint32_t>(bytes.size());
    const size_t json_start = binary ? 20 : 0;
    if (binary && bytes.size() >= json_start)
        std::memcpy(&json_size, bytes.data() + 12, sizeof json_size);
    if (bytes.size() < json_start || json_size > bytes.size() - json_start)
        fail(Exit::input, "'%s' is cut short: %zu bytes", file.name.c_str(), bytes.size());
    if (nested_too_deep(bytes.data() + json_start, json_size))
        fail(Exit::input, "'%s' nests more than %d levels deep", file.name.c_str(), nesting_limit);

    Reader reader{&file, folder};
    tinygltf::TinyGLTF loader;
    loader.SetFsCallbacks({file_exists, keep_path, read_whole, nullptr, &reader});
    loader.SetImageLoader(keep_image, &reader);
    std::string error, warning;
    /* tinygltf lets the last chunk end 8 bytes late; it may read that far. */
    std::string padded = bytes;
    padded.append(16, '\0');
    bool good = false;
    try {
        if (binary)
            good =
                loader.LoadBinaryFromMemory(file.model.get(), &error, &warning,
                                            reinterpret_cast<const unsigned char *>(padded.data()),
                                            static_cast<unsigned>(bytes.size()), folder);
        else
            good = loader.LoadASCIIFromString(file.model.get(), &error, &warning, padded.data(),
                                              static_cast<unsigned>(bytes.size()), folder);
    } catch (const Error &) {
        throw;
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const std::exception &problem) {
        error = problem.what();
    }
    check_required(file);
    if (!good)
        fail(Exit::input, "cannot read scene '%s': %s", file.name.c_str(),
             first_sentence(error).c_str());
    if (file.model->asset.version.compare(0, 2, "2.") != 0)
        fail(Exit::input, "'%s' is glTF %s; lcor reads 2.0", file.name.c_str(),
             file.model->asset.version.c_str());
    for (const tinygltf::Buffer &buffer : file.model->buffers)
        file.bytes += buffer.data.size();
    fetch_images(file);
}

Contents load_gltf(const std::string &path, Threads &threads)
{
    return parse_gltf(read_file(path, file_limit), path, folder_beside(path), threads);
}

} // namespace cli
