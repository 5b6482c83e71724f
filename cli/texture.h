/* SPDX-License-Identifier: MIT */
/* Textures as a view samples them: linear light, filtered over the pixel's footprint. */
#ifndef LCOR_CLI_TEXTURE_H
#define LCOR_CLI_TEXTURE_H

#include "scene.h"

#include <array>
#include <cstdint>
#include <vector>

namespace cli
{

/* A picture with smaller and smaller copies of itself, each half as large, made by area averages of
 * linear light. */
class MipTexture
{
  public:
    MipTexture(const Image &image, const Texture &texture, const lcor_colour &transfer);

    /* Mean linear RGB over the parallelogram around (u, v) that one pixel sees: `across` and `down`
     * are the changes of (u, v) per pixel along x and y. (0, 0) is the picture's upper left corner.
     * Any thread. */
    std::array<float, 3> sample(const double place[2], const double across[2],
                                const double down[2]) const;

  private:
    enum { STRIDE = 4 }; /* samples a texel, so that one lies in one machine word */
    struct Level {
        size_t width, height;
        std::vector<uint16_t> texels; /* linear 0..1 as 0..65535 */
    };
    struct Footprint;

    Level halved(const Level &from) const;
    void add_bilinear(const Level &level, double u, double v, float weight, float *sum) const;
    void add_probe(double u, double v, const Footprint &footprint, float weight, float *sum) const;
    size_t wrapped(double texel, size_t size, Wrap wrap) const;

    std::vector<Level> levels_;
    Wrap wrap_u_, wrap_v_;
    bool nearest_;
};

} // namespace cli

#endif
