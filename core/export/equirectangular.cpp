#include "core/export/equirectangular.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/export/export.h"
#include "core/export/picture_metadata.h"
#include "core/export/rags.h"
#include "core/view/inpainting.h"

namespace ldp {
namespace {

// What is seen first at each place of the grid.
struct Swept {
  RgbImage colour;
  Plane<float> inverse_depth;  // 0 at the farthest .. 1
  Plane<uint8_t> alpha;        // 255, or 0 where nothing is seen
};

Swept seen_first(const LayeredPanorama& panorama) {
  const int width = panorama.grid.width, height = panorama.grid.height;
  Swept swept = {RgbImage(width, height), Plane<float>(width, height, -1), Plane<uint8_t>(width, height)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const size_t pixel = swept.alpha.index(x, y);
      const Layer* layer = panorama.seen_first(pixel);
      if (layer == nullptr) continue;
      swept.colour.samples[pixel] = layer->colour.samples[pixel];
      swept.inverse_depth.samples[pixel] = static_cast<float>(layer->depth.disparity(x, y)) / kDisparitySteps;
      swept.alpha.samples[pixel] = 255;
    }
  return swept;
}

uint8_t between(uint8_t a, uint8_t b, double t) { return static_cast<uint8_t>(std::lround(a + (b - a) * t)); }

// Rows lie at equal steps of tan(elevation) in the panorama, at equal steps of elevation in the result.
RgbImage equal_angles(const RgbImage& image, const PanoramaGrid& grid, double top_rad, int height, int width) {
  RgbImage flat(width, height);
  for (int y = 0; y < height; ++y) {
    const double v = std::tan(top_rad - (y + 0.5) * grid.theta_pitch);
    const double from = std::clamp((grid.v_top - v) / grid.v_pitch - 0.5, 0.0, image.height - 1.0);
    const int above = std::min(static_cast<int>(from), std::max(0, image.height - 2));
    const int below = std::min(above + 1, image.height - 1);
    for (int x = 0; x < width; ++x) {
      const Rgb a = image.at(x, above);
      const Rgb b = image.at(x, below);
      const double t = from - above;
      flat.at(x, y) = {between(a.r, b.r, t), between(a.g, b.g, t), between(a.b, b.b, t)};
    }
  }
  return flat;
}

}  // namespace

FlatPanorama flatten(const LayeredPanorama& panorama) {
  const PanoramaGrid& grid = panorama.grid;
  FlatPanorama flat;
  flat.full_width = std::max(2, static_cast<int>(std::lround(2 * std::numbers::pi / grid.theta_pitch)));
  flat.full_height = flat.full_width / 2;
  const int width = std::min(grid.width, flat.full_width);  // an arc that overlaps itself is cut
  const double top = std::atan(grid.v_top);
  const double bottom = std::atan(grid.v(grid.height));
  const int height = std::clamp(static_cast<int>(std::lround((top - bottom) / grid.theta_pitch)), 1, flat.full_height);
  Swept swept = seen_first(panorama);
  trim_rags(swept.alpha, grid.wraps);
  view::fill_background(swept.inverse_depth, swept.colour, swept.alpha);
  flat.image = equal_angles(swept.colour, grid, top, height, width);
  flat.left = (flat.full_width - width) / 2;
  const int top_px = static_cast<int>(std::lround((std::numbers::pi / 2 - top) / grid.theta_pitch));
  flat.top = std::clamp(top_px, 0, flat.full_height - height);
  return flat;
}

std::vector<uint8_t> export_jpeg(const LayeredPanorama& panorama, const ExportOptions& options) {
  const FlatPanorama flat = flatten(panorama);
  return picture_file(".jpg", flat.image, gpano_xmp(flat, panorama), panorama, options.quality);
}

std::vector<uint8_t> export_png(const LayeredPanorama& panorama) {
  const FlatPanorama flat = flatten(panorama);
  return picture_file(".png", flat.image, gpano_xmp(flat, panorama), panorama, 0);
}

}  // namespace ldp
