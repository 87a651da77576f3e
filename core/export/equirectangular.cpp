#include "core/export/equirectangular.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/export/export.h"
#include "core/export/picture_metadata.h"
#include "core/export/rags.h"
#include "core/panorama/pull_push.h"
#include "core/view/inpainting.h"

namespace ldp {
namespace {

// Columns of its other end that a full turn is given on either side, so that what is filled closes as well: an eighth
// of its own, more where that takes little memory.
constexpr int kMargin_px = 256, kMarginParts = 8, kFewPixels = 1 << 17;

int margin_of(const PanoramaGrid& grid) {
  if (!grid.wraps) return 0;
  return std::min({grid.width, kMargin_px, std::max(grid.width / kMarginParts, kFewPixels / grid.height)});
}

struct Swept {
  int margin = 0;  // columns before the panorama's first
  RgbImage colour;
  Plane<float> inverse_depth;  // negative where nothing is seen
  Plane<uint8_t> alpha;        // 255, or 0 where nothing is seen
};

// What is seen first at each place of the grid.
Swept seen_first(const LayeredPanorama& panorama) {
  const PanoramaGrid& grid = panorama.grid;
  const int margin = margin_of(grid);
  const int width = grid.width + 2 * margin;
  Swept swept = {margin, RgbImage(width, grid.height), Plane<float>(width, grid.height, -1),
                 Plane<uint8_t>(width, grid.height)};
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < width; ++x) {
      const int column = (x - margin + grid.width) % grid.width;
      const size_t pixel = panorama.layers[0].coverage.index(column, y);
      const Layer* layer = panorama.seen_first(pixel);
      if (layer == nullptr) continue;
      swept.colour.at(x, y) = layer->colour.samples[pixel];
      swept.inverse_depth.at(x, y) = static_cast<float>(grid.inverse_depth(layer->depth.disparity(column, y)));
      swept.alpha.at(x, y) = 255;
    }
  return swept;
}

// Holes go on from what lies farthest beside them, as in views; beyond the border nothing was hidden, and all goes on.
void fill(Swept& swept) {
  const Plane<uint8_t> outside = beyond_border(swept.alpha);
  view::fill_background(swept.inverse_depth, swept.colour, swept.alpha);
  RgbImage& colour = swept.colour;
  Plane<WeightedColour> around(colour.width, colour.height);
  for (size_t i = 0; i < colour.samples.size(); ++i)
    if (outside.samples[i] == 0) around.samples[i] = known(colour.samples[i]);
  fill_by_pull_push(around);
  for (size_t i = 0; i < colour.samples.size(); ++i)
    if (outside.samples[i] != 0) colour.samples[i] = rounded(around.samples[i]);
}

uint8_t between(uint8_t a, uint8_t b, double t) { return static_cast<uint8_t>(std::lround(a + (b - a) * t)); }

// Rows lie at equal steps of tan(elevation) in the panorama, at equal steps of elevation in the result.
RgbImage equal_angles(const Swept& swept, const PanoramaGrid& grid, double top_rad, int height, int width) {
  const RgbImage& image = swept.colour;
  RgbImage flat(width, height);
  for (int y = 0; y < height; ++y) {
    const double v = std::tan(top_rad - (y + 0.5) * grid.theta_pitch);
    const double from = std::clamp((grid.v_top - v) / grid.v_pitch - 0.5, 0.0, image.height - 1.0);
    const int above = std::min(static_cast<int>(from), std::max(0, image.height - 2));
    const int below = std::min(above + 1, image.height - 1);
    for (int x = 0; x < width; ++x) {
      const Rgb a = image.at(swept.margin + x, above);
      const Rgb b = image.at(swept.margin + x, below);
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
  trim_rags(swept.alpha);
  fill(swept);
  flat.image = equal_angles(swept, grid, top, height, width);
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
