/* SPDX-License-Identifier: MIT */
/* A view of a lit scene before any mapping to a device: for every visible piece of every pixel its
 * illuminance, its reflectance and its colour. */
#ifndef LCOR_CLI_PICTURE_H
#define LCOR_CLI_PICTURE_H

#include "scene.h"
#include "texture.h"

#include <lcor/view.h>

namespace cli
{

struct ViewDeleter {
    void operator()(lcor_view *view) const { lcor_view_free(view); }
};
struct FieldDeleter {
    void operator()(lcor_field *field) const { lcor_field_free(field); }
};

/* Samples are the pieces of a row's pixels, span after span, pixel after pixel. */
class Picture
{
  public:
    /* Finds visible surfaces and their illuminance. All references must outlive the picture. */
    Picture(const Scene &scene, const lcor_solution *solution, const lcor_camera &camera,
            double tolerance, Threads &threads);

    size_t width() const { return camera_.size_x; }
    size_t height() const { return camera_.size_y; }
    const lcor_camera &camera() const { return camera_; }
    const lcor_view *view() const { return view_.get(); }
    const lcor_field *field() const { return field_.get(); }
    const Scene &scene() const { return scene_; }
    size_t samples(size_t y) const { return rows_[y + 1] - rows_[y]; }
    /* Illuminance [lux] of a sample of row y. */
    double illuminance(size_t y, size_t sample) const;

    /* What the correction works on. Emitted light counts as reflected: `illuminance` times `rho` is
     * the whole luminous exitance [lm/m2] of the surface, and `rgb` the linear colour that has that
     * exitance under that illuminance. Where the measured reflectance differs from the texture's
     * (section 5.2), illuminance carries the factor. Arrays of samples(y); rgb is
     * left empty without `with_colour`. */
    struct Row {
        std::vector<float> rgb, illuminance, rho;
    };
    void row(size_t y, bool with_colour, Row &out) const;

    /* Calls task(from, to) on all threads for bands that make up rows y0..y1-1. */
    void each_band(size_t y0, size_t y1, const std::function<void(size_t, size_t)> &task) const;
    /* Every pixel is wholly covered by surfaces. */
    bool opaque() const;

  private:
    struct Surface { /* what a row needs of a surface */
        const MipTexture *texture, *emission_texture;
        double uv[3][2];
        double colour[3][3]; /* affine over u, v; the material's factor included */
        double emission[3];  /* exitance towards the camera */
        bool emits;
        double ratio, rho; /* measured over textured reflectance (section 5.2); the textured one */
    };
    void prepare_textures();
    void prepare_surfaces();
    void light();
    void light_row(size_t y);
    std::array<double, 3> emission(const Surface &surface, const lcor_place &at) const;

    const Scene &scene_;
    lcor_camera camera_;
    Threads &threads_;
    std::unique_ptr<lcor_view, ViewDeleter> view_;
    std::unique_ptr<lcor_field, FieldDeleter> field_;
    std::vector<std::unique_ptr<MipTexture>> textures_;
    std::vector<Surface> surfaces_;
    std::vector<size_t> rows_; /* first sample of each row */
    std::vector<float> light_; /* illuminance, `channels_` each sample */
    size_t channels_ = 1;
};

} // namespace cli

#endif
