/* SPDX-License-Identifier: MIT */
/* OBJ geometry: vertices, texture coordinates, polygons, groups. */
#include "obj.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>

namespace cli
{

namespace
{

constexpr uint64_t obj_limit = uint64_t(1) << 30;
constexpr size_t corner_limit = 256; /* of a face: cutting takes the square of it */
constexpr size_t none = static_cast<size_t>(-1);
constexpr double plain_grey = 0.8; /* of faces whose material is not told */

bool is_file(const std::string &path)
{
    std::error_code ignored;
    return std::filesystem::is_regular_file(path, ignored);
}

class ObjReader
{
  public:
    ObjReader(const std::string &name, const std::string &folder) : name_(name), folder_(folder) {}

    Contents read(std::string_view text, Threads &threads)
    {
        for (WordLines line(text); line.next();)
            read_line(line);
        const std::vector<ObjMaterial> used = find_materials();
        add_materials(used, threads);
        return std::move(contents_);
    }

  private:
    [[noreturn]] void bad(const WordLines &line, const std::string &reason) const
    {
        fail(Exit::input, "scene '%s', line %zu: %s", name_.c_str(), line.line(), reason.c_str());
    }

    void read_line(const WordLines &line)
    {
        static const std::set<std::string_view> curved{"vp",   "cstype", "deg",  "bmat", "step",
                                                       "curv", "curv2",  "surf", "parm", "trim",
                                                       "hole", "scrv",   "sp",   "end",  "con"};
        const std::string_view key = line.word(0);
        if (key == "v") {
            add_vertex(line);
        } else if (key == "vt") {
            uvs_.push_back({line.number(1).value_or(0.0), line.number(2).value_or(0.0)});
        } else if (key == "f") {
            add_face(line);
        } else if (key == "g" || key == "o") {
            object_ = line.rest(1);
            group_ = none;
        } else if (key == "usemtl") {
            material_ = material_place(line.rest(1));
            group_ = none;
        } else if (key == "mtllib") {
            libraries_.push_back(line.rest(1));
        } else if (key == "l" || key == "p") {
            contents_.unsupported.insert("points and lines");
        } else if (curved.count(key) > 0) {
            contents_.unsupported.insert("curves and curved surfaces");
        } else if (key != "vn" && key != "s" && !std::exchange(unknown_, true)) {
            contents_.unsupported.insert("lines of another kind, the first at " +
                                         format("%zu", line.line()));
        }
    }

    void add_vertex(const WordLines &line)
    {
        Vec3 at;
        for (size_t k = 0; k < 3; k++) {
            const std::optional<double> number = line.number(1 + k);
            if (!number)
                bad(line, "a vertex wants three numbers");
            at[k] = *number;
        }
        if (line.size() >= 7)
            contents_.unsupported.insert("vertex colours");
        points_.push_back(at);
    }

    /* "7" or "-1", the latter counted from the end; `what` it is an index of. */
    size_t resolve(const WordLines &line, std::string_view text, size_t count,
                   const char *what) const
    {
        long long number = 0;
        const char *const end = text.data() + text.size();
        const auto result = std::from_chars(text.data(), end, number);
        if (result.ec != std::errc() || result.ptr != end)
            bad(line, "'" + std::string(text) + "' is no index");
        const long long size = static_cast<long long>(count);
        if (number == 0 || number > size || number < -size)
            bad(line, format("it names %s %lld of %lld", what, number, size));
        return static_cast<size_t>(number > 0 ? number - 1 : size + number);
    }

    /* "v", "v/vt", "v//vn" or "v/vt/vn". */
    Vertex corner(const WordLines &line, std::string_view word) const
    {
        const size_t slash = std::min(word.find('/'), word.size());
        Vertex vertex{{}, {0.0, 0.0}, {1.0, 1.0, 1.0}};
        vertex.position = points_[resolve(line, word.substr(0, slash), points_.size(), "vertex")];
        const std::string_view after = word.substr(std::min(slash + 1, word.size()));
        const std::string_view uv = after.substr(0, after.find('/'));
        if (!uv.empty())
            vertex.uv = uvs_[resolve(line, uv, uvs_.size(), "texture coordinate")];
        return vertex;
    }

    void add_face(const WordLines &line)
    {
        const size_t count = line.size() - 1;
        if (count < 3)
            bad(line, "a face wants three corners");
        if (count > corner_limit)
            bad(line, format("a face of %zu corners; lcor takes %zu", count, corner_limit));
        if (contents_.triangles.size() + count - 2 > triangle_limit)
            bad(line, format("more than %zu triangles", triangle_limit));
        std::vector<Vertex> corners;
        std::vector<Vec3> places;
        for (size_t i = 1; i <= count; i++) {
            corners.push_back(corner(line, line.word(i)));
            places.push_back(corners.back().position);
        }
        if (group_ == none) {
            group_ = contents_.groups.size();
            contents_.groups.push_back(
                {object_.empty() ? "unnamed object" : "'" + object_ + "'", material_});
        }
        for (const auto &[a, b, c] : triangulate(places))
            contents_.triangles.push_back({{corners[a], corners[b], corners[c]}, group_});
    }

    size_t material_place(const std::string &name)
    {
        const auto [found, fresh] = places_.emplace(name, names_.size());
        if (fresh)
            names_.push_back(name);
        return found->second;
    }

    std::string beside(const std::string &file) const
    {
        return file[0] == '/' ? file : folder_ + file;
    }

    /* What follows mtllib is one name, which may hold spaces, or several. */
    void read_library(const std::string &files, ObjMaterials &materials)
    {
        std::vector<std::string> names{files};
        if (files.find(' ') != std::string::npos && !is_file(beside(files)))
            names = split(files, ' ');
        for (const std::string &name : names) {
            try {
                if (!name.empty())
                    parse_mtl(read_file(beside(name), obj_limit), materials, contents_.unsupported);
            } catch (const Error &error) {
                warn("scene '%s', its materials: %s", name_.c_str(), error.what());
            }
        }
    }

    /* Materials in the order of material_place(), and after them the one of faces without. */
    std::vector<ObjMaterial> find_materials()
    {
        ObjMaterials materials;
        for (const std::string &files : libraries_)
            if (!folder_.empty())
                read_library(files, materials);
        std::vector<ObjMaterial> used;
        std::string lost;
        for (const std::string &name : names_) {
            const auto found = materials.find(name);
            used.push_back(found != materials.end() ? found->second : ObjMaterial());
            if (found == materials.end() && lost.empty())
                lost = name;
        }
        if (!lost.empty())
            warn("scene '%s': its material files do not tell of material '%s'; such surfaces are "
                 "drawn grey",
                 name_.c_str(), lost.c_str());
        used.emplace_back();
        for (ObjMaterial &material : used)
            if (!material.coloured)
                std::fill_n(material.material.colour, 3,
                            material.diffuse.file.empty() ? plain_grey : 1.0);
        for (Group &group : contents_.groups)
            group.material = std::min(group.material, names_.size());
        return used;
    }

    void decode(const std::vector<std::string> &files, Threads &threads)
    {
        contents_.images.resize(files.size());
        std::vector<std::string> problems(files.size());
        threads.run(files.size(), [&](size_t i) {
            try {
                contents_.images[i] = read_image(beside(files[i]));
            } catch (const Error &error) {
                problems[i] = error.what();
            }
        });
        for (const std::string &problem : problems)
            if (!problem.empty())
                warn("scene '%s', a texture: %s; drawn in its material's colour alone",
                     name_.c_str(), problem.c_str());
        for (size_t i = 0; i < files.size(); i++)
            warn_of_others("'" + beside(files[i]) + "'", contents_.images[i].pictures);
    }

    void add_materials(const std::vector<ObjMaterial> &used, Threads &threads)
    {
        std::vector<std::string> files;
        std::map<std::string, size_t> images;
        for (const ObjMaterial &material : used)
            for (const ObjTexture *texture : {&material.diffuse, &material.emitted})
                if (!texture->file.empty() && !folder_.empty() &&
                    images.emplace(texture->file, files.size()).second)
                    files.push_back(texture->file);
        decode(files, threads);
        std::map<std::pair<size_t, bool>, int> textures;
        const auto texture_of = [&](const ObjTexture &from) {
            const auto found = images.find(from.file);
            if (found == images.end() || contents_.images[found->second].bytes.empty())
                return -1;
            const auto [place, fresh] = textures.emplace(std::make_pair(found->second, from.clamp),
                                                         static_cast<int>(textures.size()));
            const Wrap wrap = from.clamp ? Wrap::clamp : Wrap::repeat;
            if (fresh)
                contents_.textures.push_back({found->second, wrap, wrap, false,
                                              contents_.images[found->second].type != LCOR_F32});
            return place->second;
        };
        for (const ObjMaterial &from : used) {
            Material material = from.material;
            material.texture = texture_of(from.diffuse);
            material.emission_texture = texture_of(from.emitted);
            contents_.materials.push_back(material);
        }
        place_textures(used);
    }

    /* OBJ's texture coordinates start in the lower left corner. */
    void place_textures(const std::vector<ObjMaterial> &used)
    {
        for (Triangle &triangle : contents_.triangles) {
            const ObjMaterial &material = used[contents_.groups[triangle.group].material];
            const ObjTexture &t =
                material.diffuse.file.empty() ? material.emitted : material.diffuse;
            for (Vertex &vertex : triangle.corner)
                vertex.uv = {t.scale[0] * vertex.uv[0] + t.offset[0],
                             1.0 - (t.scale[1] * vertex.uv[1] + t.offset[1])};
        }
        for (const ObjMaterial &material : used)
            if (!material.diffuse.file.empty() && !material.emitted.file.empty() &&
                (material.diffuse.scale != material.emitted.scale ||
                 material.diffuse.offset != material.emitted.offset))
                contents_.unsupported.insert("a map_Ke with coordinates of its own");
    }

    const std::string name_, folder_;
    Contents contents_;
    std::vector<Vec3> points_;
    std::vector<std::array<double, 2>> uvs_;
    std::vector<std::string> libraries_, names_; /* mtllib lines; materials used */
    std::map<std::string, size_t> places_;       /* of materials in names_ */
    std::string object_;
    size_t material_ = none, group_ = none; /* of the faces that follow; none: not yet there */
    bool unknown_ = false;
};

} // namespace

Contents parse_obj(std::string_view text, const std::string &name, const std::string &folder,
                   Threads &threads)
{
    return ObjReader(name, folder).read(text, threads);
}

Contents load_obj(const std::string &path, Threads &threads)
{
    return parse_obj(read_file(path, obj_limit), path, folder_beside(path), threads);
}

bool named_obj(const std::string &path)
{
    std::string end = path.substr(path.size() - std::min(path.size(), size_t(4)));
    std::transform(end.begin(), end.end(), end.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return end == ".obj";
}

} // namespace cli
