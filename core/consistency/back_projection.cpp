#include "core/consistency/back_projection.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace ldp {
namespace {

using consistency::grey;
using consistency::Held;
using consistency::Rendering;

// Figures: decisions.md.
constexpr int kMostDiffers = 64;            // grey levels; what differs more is another thing
constexpr int kMostTold = 24;               // levels that one photograph may ask for
constexpr int kFewestPhotos = 3;            // whose word counts
constexpr double kDoubt = 2;                // times the variance of their mean
constexpr double kOneSurfaceLabels = 0.25;  // by which depths rendered around a pixel may be off
constexpr double kParallax = 0.2;           // of the cosine, by which rays seen may point less forward
constexpr uint8_t kMostPhotos = 32;         // so that sums fit
constexpr int kSubpixels = 16;              // and steps of a level that sums are kept in

// Where a pixel of the front layer falls in a photograph: among four pixels, from (x, y).
struct Place {
  int x = 0, y = 0;
  int right = 0, down = 0;  // of kSubpixels
  double inverse_z = 0;
};

std::optional<Place> place_of(const Camera& camera, const Eigen::Vector3d& in_camera, double w) {
  if (in_camera.z() < kLeastForward) return {};
  const Eigen::Vector2d p = project(camera.intrinsics, in_camera);
  const Intrinsics& size = camera.intrinsics;
  if (!(p.x() >= 1 && p.y() >= 1 && p.x() < size.width - 1 && p.y() < size.height - 1)) return {};
  const auto x = static_cast<int>((p.x() - 0.5) * kSubpixels), y = static_cast<int>((p.y() - 0.5) * kSubpixels);
  return Place{x / kSubpixels, y / kSubpixels, x % kSubpixels, y % kSubpixels, w / in_camera.z()};
}

// In grey [1/kSubpixels level]; none where another surface or thing shows.
std::optional<int> difference_at(const Held& own, const Rendering& rendering, const Place& place, double tolerance) {
  int sum = 0;
  for (const int j : {0, 1})
    for (const int i : {0, 1}) {
      const int x = place.x + i, y = place.y + j;
      const float depth = own.depth.at(x, y);
      if (depth == 0 || std::abs(1.0 / static_cast<double>(depth) - place.inverse_z) > tolerance) return {};
      const int difference = grey(own.photo.at(x, y)) - grey(rendering.colour.at(x, y));
      if (std::abs(difference) > kMostDiffers) return {};
      const int weight = (i ? place.right : kSubpixels - place.right) * (j ? place.down : kSubpixels - place.down);
      sum += weight * std::clamp(difference, -kMostTold, kMostTold);
    }
  return sum / kSubpixels;
}

uint8_t moved(uint8_t level, double by) {
  return static_cast<uint8_t>(std::clamp(static_cast<int>(std::floor(level + by + 0.5)), 0, 255));
}

}  // namespace

BackProjection::BackProjection(const LayeredPanorama& panorama, const Job& job)
    : panorama_(panorama), job_(job), differences_(panorama.grid.width, panorama.grid.height) {
  for (int x = 0; x < panorama.grid.width; ++x) headings_.push_back(heading(panorama.grid.theta(x + 0.5)));
}

void BackProjection::rendered(size_t camera, const Held& own, const Rendering& rendering, const Held*) {
  const PhotoProjection projection(panorama_.grid, panorama_.cameras[camera]);
  const std::vector<InView> columns = in_view(panorama_.cameras[camera], projection);
  parallel_for(job_, panorama_.grid.height, [&](int y) { add_row(own, rendering, projection, columns, y); });
}

// Those whose rays point nearly as far forward as one to a corner of the picture.
std::vector<BackProjection::InView> BackProjection::in_view(const Camera& camera,
                                                            const PhotoProjection& projection) const {
  const Intrinsics& lens = camera.intrinsics;
  const double width = lens.width / lens.fx, height = lens.height / lens.fx;
  const double least = 1 / std::sqrt(1 + (width * width + height * height) / 4) - kParallax;
  std::vector<InView> columns;
  for (int x = 0; x < panorama_.grid.width; ++x) {
    const PhotoProjection::Column direction = projection.column(headings_[static_cast<size_t>(x)]);
    if (direction[2] > least) columns.push_back({x, direction});
  }
  return columns;
}

void BackProjection::add_row(const Held& own, const Rendering& rendering, const PhotoProjection& projection,
                             const std::vector<InView>& columns, int y) {
  const PanoramaGrid& grid = panorama_.grid;
  const Layer& front = panorama_.layers.front();
  const double tolerance = kOneSurfaceLabels * (grid.w_near - grid.w_far) / (kLabels - 1), v = grid.v(y + 0.5);
  for (const InView& column : columns) {
    Differences& pixel = differences_.at(column.x, y);
    if (front.coverage.at(column.x, y) == 0 || pixel.photos == kMostPhotos) continue;
    const double w = grid.inverse_depth(front.depth.disparity(column.x, y));
    const Eigen::Vector3d in_camera = projection.in_camera_axes(column.direction, v, w);
    const auto place = place_of(*own.camera, in_camera, w);
    if (!place) continue;
    const auto told = difference_at(own, rendering, *place, tolerance / in_camera.z());
    if (!told) continue;
    pixel.sum = static_cast<int16_t>(pixel.sum + *told);
    pixel.squares = static_cast<uint16_t>(pixel.squares + *told * *told / (kSubpixels * kSubpixels));
    ++pixel.photos;
  }
}

// The mean of what photographs tell, the less of it the less they agree (James and Stein 1961).
void BackProjection::correct(Layer& front) const {
  parallel_for(job_, front.coverage.height, [&](int y) {
    for (int x = 0; x < front.coverage.width; ++x) {
      const Differences& pixel = differences_.at(x, y);
      if (pixel.photos < kFewestPhotos) continue;
      const double mean = pixel.sum / (1.0 * kSubpixels * pixel.photos), square = mean * mean;
      if (square == 0) continue;
      const double variance = std::max(0.0, pixel.squares / (1.0 * pixel.photos) - square);
      const double by = mean * square / (square + kDoubt * variance / pixel.photos);
      Rgb& colour = front.colour.at(x, y);
      colour = {moved(colour.r, by), moved(colour.g, by), moved(colour.b, by)};
    }
  });
}

}  // namespace ldp
