/* SPDX-License-Identifier: MIT */
/* Triangles of a file -> the parallelograms and triangles of a scene, and how much they reflect. */
#ifndef LCOR_CLI_SHAPES_H
#define LCOR_CLI_SHAPES_H

#include "contents.h"

namespace cli
{

/* Corners counter-clockwise seen from the side it faces: four of a parallelogram, or three. */
struct Shape {
    std::array<Vertex, 4> corner;
    bool quad;
    size_t group;
    bool back_to_back = false; /* another one with the same corners faces the other way */
};

/* Pairs of triangles that lie in one plane, share an edge, texture coordinates and colours, and
 * make a parallelogram become one; the most rectangular pairs first. Triangles without area are
 * left out and counted. Exit::input for coordinates that are no numbers. */
std::vector<Shape> make_shapes(const Contents &contents, const std::string &name, size_t *dropped);

/* Shapes with the same corners are one wall: of those that face the same way the first stays, how
 * many are left out is returned; two that face opposite ways are its sides. */
size_t settle_twins(std::vector<Shape> &shapes);

/* Area means of what is drawn on a surface, linear RGB. */
class TextureMeans
{
  public:
    /* `shapes`: how many surfaces there are, to bound the work. */
    TextureMeans(const Contents &contents, size_t shapes);
    /* Mean over a shape of texture (-1: white) times vertex colour. */
    Vec3 mean(int texture, const Shape &shape);

  private:
    Vec3 whole(size_t image, bool srgb);
    Vec3 texel(const Texture &texture, double u, double v) const;
    double linear(const Image &image, bool srgb, size_t x, size_t y, size_t channel) const;

    const Contents &contents_;
    size_t most_samples_; /* along each edge */
    std::vector<double> linear_u8_, linear_u16_;
    std::vector<Vec3> whole_; /* of each image; negative: not yet known */
};

} // namespace cli

#endif
