#include "core/verdict/rephotography.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/base/exact_math.h"
#include "core/geometry/degrees.h"

namespace ldp {
namespace {

constexpr uint8_t kHoleGrey = 127;
constexpr int kBandRows = 32;     // that are compared at once, a multiple of kStride
constexpr int kStride = 2;        // of the pixels that are compared with the photograph beside
constexpr double kHidden = 1.05;  // depth at which the neighbour sees something nearer instead
constexpr int kUnexplained = 40;  // levels by which a channel differs from all colours within a pixel

using consistency::Held;
using consistency::Rendering;

int squared_difference(const Rgb& a, const Rgb& b) {
  const int r = a.r - b.r, g = a.g - b.g, blue = a.b - b.b;
  return r * r + g * g + blue * blue;
}

int largest_difference(const Rgb& a, const Rgb& b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

// Of one photograph, gathered by bands of rows.
using Directions = std::vector<DirectionEvidence>;

// Whether no colour of the view within a pixel comes near the photograph's.
bool unexplained(const RgbImage& photo, const Rendering& back, int x, int y) {
  const Rgb& seen = photo.at(x, y);
  if (largest_difference(seen, back.colour.at(x, y)) <= kUnexplained) return false;  // as most do
  for (int v = std::max(0, y - 1); v <= std::min(photo.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(photo.width - 1, x + 1); ++u)
      if (back.alpha.at(u, v) != 0 && largest_difference(seen, back.colour.at(u, v)) <= kUnexplained) return false;
  return true;
}

void compare_back(const RgbImage& photo, const Rendering& back, int y, const std::vector<size_t>& columns,
                  Directions& directions) {
  for (int x = 0; x < photo.width; ++x) {
    DirectionEvidence& direction = directions[columns[static_cast<size_t>(x)]];
    const bool hole = back.alpha.at(x, y) == 0;
    const Rgb shown = hole ? Rgb{kHoleGrey, kHoleGrey, kHoleGrey} : back.colour.at(x, y);
    direction.back.sum += squared_difference(photo.at(x, y), shown);
    direction.back.samples += 3;
    ++direction.pixels;
    direction.holes += hole ? 1 : 0;
    if (hole) continue;
    ++direction.compared;
    direction.unexplained += unexplained(photo, back, x, y) ? 1 : 0;
  }
}

// The colour of a photograph between its pixels, in 1/64 of a pixel.
Rgb sample(const RgbImage& photo, const Eigen::Vector2d& at) {
  constexpr int kFine = 64;
  const int x = static_cast<int>(std::floor((at.x() - 0.5) * kFine)),
            y = static_cast<int>(std::floor((at.y() - 0.5) * kFine));
  const int left = std::clamp(x / kFine, 0, photo.width - 2), top = std::clamp(y / kFine, 0, photo.height - 2);
  const int u = std::clamp(x - left * kFine, 0, kFine), v = std::clamp(y - top * kFine, 0, kFine);
  const auto mix = [&](uint8_t Rgb::*channel) {
    const int above = photo.at(left, top).*channel * (kFine - u) + photo.at(left + 1, top).*channel * u;
    const int below = photo.at(left, top + 1).*channel * (kFine - u) + photo.at(left + 1, top + 1).*channel * u;
    return static_cast<uint8_t>((above * (kFine - v) + below * v + kFine * kFine / 2) / (kFine * kFine));
  };
  return {mix(&Rgb::r), mix(&Rgb::g), mix(&Rgb::b)};
}

// Where the neighbour shows the surface that the panorama has at a pixel, if it does.
bool shown_beside(const Held& own, const Held& beside, int x, int y, Eigen::Vector2d& at) {
  const double z = static_cast<double>(own.depth.at(x, y));
  if (z <= 0) return false;
  const Pose &here = own.camera->pose, &there = beside.camera->pose;
  const Eigen::Vector3d ray = unproject(own.camera->intrinsics, {x + 0.5, y + 0.5});
  const Eigen::Vector3d direction = exact_product(here.world_from_camera, ray);
  const bool far = std::isinf(z);
  const Eigen::Vector3d offset = far ? direction : Eigen::Vector3d(here.centre + z * direction - there.centre);
  const Eigen::Vector3d local = exact_transposed_product(there.world_from_camera, offset);
  if (local.z() <= 0) return false;
  at = project(beside.camera->intrinsics, local);
  const RgbImage& photo = beside.photo;
  if (!(at.x() >= 0.5 && at.y() >= 0.5 && at.x() < photo.width - 0.5 && at.y() < photo.height - 0.5)) return false;
  const double shown = static_cast<double>(beside.depth.at(static_cast<int>(at.x()), static_cast<int>(at.y())));
  if (shown == 0) return false;
  return far ? std::isinf(shown) : local.z() <= kHidden * shown;
}

void compare_beside(const Held& own, const Held& beside, int y, const std::vector<size_t>& columns,
                    Directions& directions) {
  for (int x = 0; x < own.photo.width; x += kStride) {
    Eigen::Vector2d at;
    if (!shown_beside(own, beside, x, y, at)) continue;
    SquaredError& error = directions[columns[static_cast<size_t>(x)]].neighbour;
    error.sum += squared_difference(own.photo.at(x, y), sample(beside.photo, at));
    error.samples += 3;
  }
}

// Adds what `compare` tells of every `step`th row to `all`.
template <typename Compare>
void add_rows(const Job& job, int height, int step, Directions& all, const Compare& compare) {
  const int bands = (height + kBandRows - 1) / kBandRows;
  std::vector<Directions> found(static_cast<size_t>(bands), Directions(all.size()));
  parallel_for(job, bands, [&](int band) {
    const int end = std::min(height, (band + 1) * kBandRows);
    for (int y = band * kBandRows; y < end; y += step) compare(y, found[static_cast<size_t>(band)]);
  });
  for (const Directions& part : found)
    for (size_t d = 0; d < all.size(); ++d) all[d].add(part[d]);
}

}  // namespace

// Directions in which the columns of a photograph look, as indices of `directions`.
class Rephotography::Columns {
 public:
  Columns(const PanoramaGrid& grid, const std::vector<Camera>& cameras) {
    double before = 0;
    for (const Camera& camera : cameras) {
      const Eigen::Vector3d f = camera.pose.world_from_camera.col(2);
      const double across = exact_dot(f, grid.arc.world_from_arc.col(1)),
                   along = exact_dot(f, grid.arc.world_from_arc.col(0));
      double theta = std::atan2(across, along) * kDegreesPerRadian;
      if (!heading_.empty()) theta += 360 * std::round((before - theta) / 360);
      before = theta;
      heading_.push_back(theta);
    }
    sense_ = heading_.back() >= heading_.front() ? 1 : -1;
    const double first = heading_.front();
    for (double& heading : heading_) heading = rounded(sense_ * (heading - first), 8);
    double least = 0, most = 0;
    for (size_t i = 0; i < cameras.size(); ++i) {
      const Intrinsics& k = cameras[i].intrinsics;
      for (const double x : {0.5, k.width - 0.5}) {
        least = std::min(least, degrees(i, k, x));
        most = std::max(most, degrees(i, k, x));
      }
    }
    // Cameras from elsewhere may turn on and on though they move along an arc: what is beyond two rounds starts anew.
    round_ = grid.wraps || most - least > 2 * 360;
    first_ = round_ ? 0 : static_cast<int>(std::floor(least / kDirection_deg));
    count_ = round_ ? kFullTurn : static_cast<int>(std::floor(most / kDirection_deg)) + 1 - first_;
  }

  double heading(size_t camera) const { return heading_[camera]; }
  double first_deg() const { return first_ * kDirection_deg; }
  size_t count() const { return static_cast<size_t>(count_); }

  std::vector<size_t> of(size_t camera, const Intrinsics& k) const {
    std::vector<size_t> indices;
    for (int x = 0; x < k.width; ++x) {
      const int at = static_cast<int>(std::floor(degrees(camera, k, x + 0.5) / kDirection_deg)) - first_;
      const int turned = round_ ? ((at % kFullTurn) + kFullTurn) % kFullTurn : std::clamp(at, 0, count_ - 1);
      indices.push_back(static_cast<size_t>(turned));
    }
    return indices;
  }

 private:
  double degrees(size_t camera, const Intrinsics& k, double x) const {
    return rounded(heading_[camera] - sense_ * std::atan((x - k.cx) / k.fx) * kDegreesPerRadian, 8);
  }

  std::vector<double> heading_;
  double sense_ = 1;
  bool round_ = false;
  int first_ = 0, count_ = 0;
};

void DirectionEvidence::add(const DirectionEvidence& other) {
  pixels += other.pixels, holes += other.holes, unexplained += other.unexplained, compared += other.compared;
  back.add(other.back);
  neighbour.add(other.neighbour);
}

Rephotography::Rephotography(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                             const std::vector<Gain>& gains, const Job& job, SweepEvidence& evidence)
    : job_(job), evidence_(evidence), columns_(std::make_unique<Columns>(grid, cameras)) {
  evidence.first_deg = columns_->first_deg();
  const Intrinsics& lens = cameras.front().intrinsics;
  evidence.field_deg = rounded(2 * std::atan(0.5 * lens.width / lens.fx) * kDegreesPerRadian, 8);
  evidence.photos.resize(cameras.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    PhotoEvidence& photo = evidence.photos[i];
    photo.heading_deg = columns_->heading(i);
    photo.gain = static_cast<double>(gains[i][1]);
    photo.directions.resize(columns_->count());
  }
}

Rephotography::~Rephotography() = default;

void Rephotography::rendered(size_t camera, const Held& own, const Rendering& rendering, const Held* before) {
  const std::vector<size_t> columns = columns_->of(camera, own.camera->intrinsics);
  const int height = own.photo.height;
  Directions& directions = evidence_.photos[camera].directions;
  add_rows(job_, height, 1, directions,
           [&](int y, Directions& found) { compare_back(own.photo, rendering, y, columns, found); });
  if (before == nullptr) return;
  add_rows(job_, height, kStride, directions,
           [&](int y, Directions& found) { compare_beside(own, *before, y, columns, found); });
  const std::vector<size_t> columns_before = columns_->of(camera - 1, before->camera->intrinsics);
  add_rows(job_, before->photo.height, kStride, evidence_.photos[camera - 1].directions,
           [&](int y, Directions& found) { compare_beside(*before, own, y, columns_before, found); });
}

}  // namespace ldp
