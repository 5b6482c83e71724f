/* SPDX-License-Identifier: MIT */
/* Writing small glTF scenes: parallelograms, pictures, lights and cameras into one .glb or .gltf.
 */
#ifndef LCOR_CLI_GLB_H
#define LCOR_CLI_GLB_H

#include "cli.h"

#include <array>
#include <string>

namespace cli
{

struct GlbQuad {
    std::string name;
    std::array<double, 3> origin, edge_u, edge_v; /* faces edge_u x edge_v */
    std::array<std::array<double, 2>, 4> uv;      /* of origin, +u, +u+v, +v */
    int material;
    std::array<int, 2> patches;
    double reflectance; /* measured; < 0: not known */
};

class GlbWriter
{
  public:
    explicit GlbWriter(std::string generator);
    /* `bytes` of a JPEG or PNG file; returns the texture's number. */
    int add_texture(const std::string &name, const std::string &bytes, const char *mime);
    /* Grey of linear reflectance rho, or a texture (>= 0). Seen from its front only. */
    int add_material(const std::string &name, double rho, int texture);
    void add_quad(const GlbQuad &quad);
    void add_point_light(const std::string &name, const std::array<double, 3> &position,
                         double intensity);
    /* Looks from `eye` to `target` with `up` upwards in the picture; the angle is vertical. */
    void add_camera(const std::string &name, const std::array<double, 3> &eye,
                    const std::array<double, 3> &target, const std::array<double, 3> &up,
                    double fov_y, double aspect);
    std::string finish();

  private:
    int add_view(const void *bytes, size_t size);
    int add_floats(const std::vector<float> &values, int components, bool bounds);
    int add_node(Json node);

    Json document_;
    std::string buffer_;
    int indices_ = -1; /* accessor shared by all quads */
};

/* The room of Table 3 with its default light and reflectances, as .glb bytes. */
std::string paper_room(int patches);

} // namespace cli

#endif
