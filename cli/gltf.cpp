/* SPDX-License-Identifier: MIT */
/* The node tree: transforms, primitives -> triangles, lights, cameras. */
#include "gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace cli
{

Transform Transform::operator*(const Transform &right) const
{
    Transform out;
    for (size_t column = 0; column < 4; column++)
        for (size_t row = 0; row < 4; row++) {
            double sum = 0.0;
            for (size_t k = 0; k < 4; k++)
                sum += m[4 * k + row] * right.m[4 * column + k];
            out.m[4 * column + row] = sum;
        }
    return out;
}

Vec3 Transform::vector(const Vec3 &v) const
{
    return {m[0] * v[0] + m[4] * v[1] + m[8] * v[2], m[1] * v[0] + m[5] * v[1] + m[9] * v[2],
            m[2] * v[0] + m[6] * v[1] + m[10] * v[2]};
}

Vec3 Transform::point(const Vec3 &p) const { return vector(p) + Vec3{m[12], m[13], m[14]}; }

double Transform::determinant() const
{
    return dot(cross({m[0], m[1], m[2]}, {m[4], m[5], m[6]}), {m[8], m[9], m[10]});
}

namespace
{

constexpr size_t vertex_limit = 32000000; /* read, and read again for every instance */

class Walker
{
  public:
    Walker(const ModelFile &file, Contents &contents)
        : file_(file), model_(*file.model), contents_(contents), seen_(model_.nodes.size(), false)
    {
    }

    void walk()
    {
        for (const int root : roots())
            visit(root, Transform());
        count_surfaces();
        for (const auto &[index, world] : placed_)
            convert_node(model_.nodes[static_cast<size_t>(index)], node_name(index), world);
    }

  private:
    std::vector<int> roots() const
    {
        if (!model_.scenes.empty()) {
            const size_t wanted =
                model_.defaultScene > 0 ? static_cast<size_t>(model_.defaultScene) : 0;
            if (wanted >= model_.scenes.size())
                fail(Exit::input, "scene '%s': it names scene %zu, which is not there",
                     file_.name.c_str(), wanted);
            return model_.scenes[wanted].nodes;
        }
        std::vector<bool> child(model_.nodes.size(), false);
        for (const tinygltf::Node &node : model_.nodes)
            for (const int index : node.children)
                if (index >= 0 && static_cast<size_t>(index) < child.size())
                    child[static_cast<size_t>(index)] = true;
        std::vector<int> out;
        for (size_t i = 0; i < child.size(); i++)
            if (!child[i])
                out.push_back(static_cast<int>(i));
        return out;
    }

    std::string node_name(int index) const
    {
        const std::string &name = model_.nodes[static_cast<size_t>(index)].name;
        return name.empty() ? format("node %d", index) : "node '" + name + "'";
    }

    Transform local(int index) const
    {
        const tinygltf::Node &node = model_.nodes[static_cast<size_t>(index)];
        Transform out;
        if (node.matrix.size() == 16) {
            std::copy(node.matrix.begin(), node.matrix.end(), out.m.begin());
        } else {
            const double *const q = node.rotation.data();
            if (node.rotation.size() == 4) {
                const double x = q[0], y = q[1], z = q[2], w = q[3];
                /* The formula for unit quaternions as every reader uses it: rounded ones are not
                 * made unit again, so that numbers agree with theirs. Broken ones are. */
                const double norm = x * x + y * y + z * z + w * w;
                const double s = std::fabs(norm - 1.0) < 1e-3 ? 2.0 : 2.0 / std::max(norm, 1e-300);
                out.m = {1 - s * (y * y + z * z),
                         s * (x * y + z * w),
                         s * (x * z - y * w),
                         0,
                         s * (x * y - z * w),
                         1 - s * (x * x + z * z),
                         s * (y * z + x * w),
                         0,
                         s * (x * z + y * w),
                         s * (y * z - x * w),
                         1 - s * (x * x + y * y),
                         0,
                         0,
                         0,
                         0,
                         1};
            }
            for (size_t c = 0; node.scale.size() == 3 && c < 3; c++)
                for (size_t r = 0; r < 3; r++)
                    out.m[4 * c + r] *= node.scale[c];
            for (size_t r = 0; node.translation.size() == 3 && r < 3; r++)
                out.m[12 + r] = node.translation[r];
        }
        for (const double value : out.m)
            if (!std::isfinite(value))
                fail(Exit::input, "scene '%s', %s: its transform is not finite", file_.name.c_str(),
                     node_name(index).c_str());
        return out;
    }

    /* Every node once: the tree is walked with a stack, so depth is no matter. */
    void visit(int root, const Transform &start)
    {
        std::vector<std::pair<int, Transform>> stack{{root, start}};
        while (!stack.empty()) {
            const auto [index, parent] = stack.back();
            stack.pop_back();
            if (index < 0 || static_cast<size_t>(index) >= model_.nodes.size())
                fail(Exit::input, "scene '%s': no node %d", file_.name.c_str(), index);
            if (seen_[static_cast<size_t>(index)])
                fail(Exit::input, "scene '%s', %s: it has two parents or is its own ancestor",
                     file_.name.c_str(), node_name(index).c_str());
            seen_[static_cast<size_t>(index)] = true;
            const Transform world = parent * local(index);
            placed_.emplace_back(index, world);
            const tinygltf::Node &node = model_.nodes[static_cast<size_t>(index)];
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
                stack.emplace_back(*child, world);
        }
    }

    /* A small file may place a mesh many times: too many are refused before any is read. */
    void count_surfaces() const
    {
        size_t triangles = 0, vertices = 0;
        for (const auto &[index, world] : placed_) {
            const int mesh = model_.nodes[static_cast<size_t>(index)].mesh;
            if (mesh < 0 || static_cast<size_t>(mesh) >= model_.meshes.size())
                continue;
            for (const tinygltf::Primitive &primitive :
                 model_.meshes[static_cast<size_t>(mesh)].primitives) {
                const size_t read = elements(attribute(primitive, "POSITION"));
                const size_t drawn = primitive.indices >= 0 ? elements(primitive.indices) : read;
                triangles += primitive.mode == TINYGLTF_MODE_TRIANGLES ? drawn / 3 : drawn;
                vertices += read + 64; /* reading starts anew for each primitive */
                if (triangles > triangle_limit || vertices > vertex_limit)
                    fail(Exit::input, "scene '%s': more than %zu triangles or %zu vertices",
                         file_.name.c_str(), triangle_limit, vertex_limit);
            }
        }
        check_triangles(triangles, file_.name);
    }

    /* Of an accessor; 0 for one that reading will refuse. */
    size_t elements(int accessor) const
    {
        if (accessor < 0 || static_cast<size_t>(accessor) >= model_.accessors.size())
            return 0;
        const size_t count = model_.accessors[static_cast<size_t>(accessor)].count;
        return count <= file_.bytes ? count : 0;
    }

    static int attribute(const tinygltf::Primitive &primitive, const std::string &key)
    {
        const auto found = primitive.attributes.find(key);
        return found == primitive.attributes.end() ? -1 : found->second;
    }

    void convert_node(const tinygltf::Node &node, const std::string &name, const Transform &world)
    {
        if (node.skin >= 0)
            contents_.unsupported.insert("skins (drawn in the rest pose)");
        if (node.extensions.count("EXT_mesh_gpu_instancing") > 0)
            contents_.unsupported.insert("EXT_mesh_gpu_instancing (drawn once)");
        if (node.camera >= 0)
            convert_camera(file_, node.camera, world, name, contents_);
        const auto punctual = node.extensions.find("KHR_lights_punctual");
        if (punctual != node.extensions.end()) {
            const double index = extras_number(punctual->second, "light");
            if (!(index >= 0.0 && index < static_cast<double>(model_.lights.size())))
                fail(Exit::input, "scene '%s', %s: it names a light that is not there",
                     file_.name.c_str(), name.c_str());
            convert_light(file_, model_.lights[static_cast<size_t>(index)], world, name, contents_);
        }
        if (node.mesh < 0)
            return;
        if (static_cast<size_t>(node.mesh) >= model_.meshes.size())
            fail(Exit::input, "scene '%s', %s: no mesh %d", file_.name.c_str(), name.c_str(),
                 node.mesh);
        const tinygltf::Mesh &mesh = model_.meshes[static_cast<size_t>(node.mesh)];
        for (size_t i = 0; i < mesh.primitives.size(); i++)
            convert_primitive(
                mesh.primitives[i], mesh, node,
                mesh.primitives.size() > 1 ? name + format(", primitive %zu", i) : name, world);
    }

    /* "lcor_patches": [nu, nv] or n; "lcor_reflectance": rho. The primitive's own, else the mesh's,
     * else the node's, since few programs let people put extras on primitives. */
    void read_extras(const tinygltf::Value &extras, Group &group) const
    {
        if (!extras.IsObject())
            return;
        if (group.patches[0] == 0 && extras.Has("lcor_patches")) {
            const tinygltf::Value &value = extras.Get("lcor_patches");
            for (int i = 0; i < 2; i++) {
                const tinygltf::Value &part = value.ArrayLen() == 2 ? value.Get(i) : value;
                const double n = part.IsNumber() ? part.GetNumberAsDouble() : 0.0;
                if (!(n >= 1.0 && n <= 4096.0 && n == std::floor(n)))
                    fail(Exit::input,
                         "scene '%s', %s: lcor_patches must be [nu, nv], each 1 to 4096",
                         file_.name.c_str(), group.name.c_str());
                group.patches[static_cast<size_t>(i)] = static_cast<size_t>(n);
            }
        }
        if (group.reflectance < 0.0 && extras.Has("lcor_reflectance")) {
            group.reflectance = extras_number(extras, "lcor_reflectance");
            if (!(group.reflectance >= 0.0 && group.reflectance <= 1.0))
                fail(Exit::input, "scene '%s', %s: lcor_reflectance must lie in 0..1",
                     file_.name.c_str(), group.name.c_str());
        }
    }

    void convert_primitive(const tinygltf::Primitive &primitive, const tinygltf::Mesh &mesh,
                           const tinygltf::Node &node, const std::string &name,
                           const Transform &world)
    {
        const bool draws = primitive.mode == TINYGLTF_MODE_TRIANGLES ||
                           primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
                           primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
        if (!draws) {
            contents_.unsupported.insert("points and lines");
            return;
        }
        if (!primitive.targets.empty())
            contents_.unsupported.insert("morph targets (drawn in the rest pose)");
        for (const char *packed : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"})
            if (primitive.extensions.count(packed) > 0)
                fail(Exit::input, "scene '%s', %s: compressed with %s; export it uncompressed",
                     file_.name.c_str(), name.c_str(), packed);
        Group group;
        group.name = name;
        const bool has_material = primitive.material >= 0;
        if (has_material && static_cast<size_t>(primitive.material) >= model_.materials.size())
            fail(Exit::input, "scene '%s', %s: no material %d", file_.name.c_str(), name.c_str(),
                 primitive.material);
        group.material =
            has_material ? static_cast<size_t>(primitive.material) : model_.materials.size();
        for (const tinygltf::Value *extras : {&primitive.extras, &mesh.extras, &node.extras})
            read_extras(*extras, group);
        if (group.reflectance < 0.0)
            group.reflectance = contents_.measured[group.material];
        add_triangles(primitive, read_vertices(primitive, world), group, world.determinant() < 0.0);
    }

    std::vector<Vertex> read_vertices(const tinygltf::Primitive &primitive, const Transform &world)
    {
        const int position_index = attribute(primitive, "POSITION");
        if (position_index < 0)
            return {};
        const Accessor positions = read_accessor(file_, position_index, 3);
        std::vector<Vertex> vertices(positions.count, {{}, {0.0, 0.0}, {1.0, 1.0, 1.0}});
        for (size_t i = 0; i < positions.count; i++)
            vertices[i].position =
                world.point({positions.values[3 * i], positions.values[3 * i + 1],
                             positions.values[3 * i + 2]});
        const UvSource source = uv_source(file_, primitive.material);
        const int uv_index = attribute(primitive, format("TEXCOORD_%d", source.set));
        if (uv_index >= 0) {
            const Accessor uvs = read_accessor(file_, uv_index, 2);
            const std::array<double, 6> &t = source.transform;
            for (size_t i = 0; i < std::min(uvs.count, vertices.size()); i++) {
                const double u = uvs.values[2 * i], v = uvs.values[2 * i + 1];
                if (!std::isfinite(u) || !std::isfinite(v))
                    continue;
                vertices[i].uv = {t[0] * u + t[1] * v + t[2], t[3] * u + t[4] * v + t[5]};
            }
        }
        const int colour_index = attribute(primitive, "COLOR_0");
        if (colour_index >= 0) {
            const Accessor colours = read_accessor(file_, colour_index, 0);
            for (size_t i = 0;
                 colours.components >= 3 && i < std::min(colours.count, vertices.size()); i++)
                for (size_t c = 0; c < 3; c++) {
                    const double value = colours.values[i * colours.components + c];
                    vertices[i].colour[c] =
                        std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.0;
                }
        }
        if (attribute(primitive, "COLOR_1") >= 0)
            contents_.unsupported.insert("a second set of vertex colours");
        return vertices;
    }

    void add_triangles(const tinygltf::Primitive &primitive, const std::vector<Vertex> &vertices,
                       const Group &group, bool mirrored)
    {
        std::vector<uint32_t> indices;
        if (primitive.indices >= 0) {
            indices = read_indices(file_, primitive.indices);
        } else {
            indices.resize(vertices.size());
            for (size_t i = 0; i < indices.size(); i++)
                indices[i] = static_cast<uint32_t>(i);
        }
        for (const uint32_t index : indices)
            if (index >= vertices.size())
                fail(Exit::input, "scene '%s', %s: vertex %u of %zu", file_.name.c_str(),
                     group.name.c_str(), index, vertices.size());
        const bool list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
        const bool fan = primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
        const size_t count = list                 ? indices.size() / 3
                             : indices.size() < 3 ? 0
                                                  : indices.size() - 2;
        contents_.groups.push_back(group);
        for (size_t i = 0; i < count; i++) {
            size_t a = list ? 3 * i : fan ? 0 : i;
            size_t b = list ? 3 * i + 1 : i + 1, c = list ? 3 * i + 2 : i + 2;
            /* Every other triangle of a strip turns the other way. */
            if ((!list && !fan && i % 2 == 1) != mirrored)
                std::swap(b, c);
            contents_.triangles.push_back(
                {{vertices[indices[a]], vertices[indices[b]], vertices[indices[c]]},
                 contents_.groups.size() - 1});
        }
    }

    const ModelFile &file_;
    const tinygltf::Model &model_;
    Contents &contents_;
    std::vector<bool> seen_;
    std::vector<std::pair<int, Transform>> placed_; /* nodes in world coordinates */
};

/* What a file uses and lcor does not draw. */
void name_extensions(const tinygltf::Model &model, Contents &contents)
{
    for (const std::string &name : model.extensionsUsed)
        if (!understood_extension(name))
            contents.unsupported.insert("extension " + name);
    if (!model.animations.empty())
        contents.unsupported.insert("animations (drawn at rest)");
}

} // namespace

Contents parse_gltf(const std::string &bytes, const std::string &name, const std::string &folder,
                    Threads &threads, ImageDecoder decoder)
{
    ModelFile file;
    file.name = name;
    file.decoder = decoder;
    read_model(bytes, folder, file);
    Contents contents;
    name_extensions(*file.model, contents);
    convert_materials(file, contents, threads);
    Walker(file, contents).walk();
    return contents;
}

} // namespace cli
