#include "core/consistency/classify.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "core/base/exact_math.h"

namespace ldp::consistency {
namespace {

constexpr int kEvery = 2;       // pixels, both ways, are classified
constexpr int kAsked = 4;       // of what differs in a square of so many, other photographs are asked about the first
constexpr int kOpaque = 128;    // alpha from which a pixel is not a hole
constexpr int kPlainRange = 6;  // grey levels within 3x3 pixels of a plain place
constexpr double kSamePlace = 0.15;  // share of its inverse depth by which a surface may differ and still be seen
constexpr double kBehind = 1e-6;
// A pixel and its neighbours across corners.
constexpr std::array<std::array<int, 2>, kPatchPixels> kPatch = {{{0, 0}, {-1, -1}, {1, 1}, {1, -1}, {-1, 1}}};

std::array<int, 3> channels(Rgb c) { return {c.r, c.g, c.b}; }

std::array<int, 3> moved(std::array<int, 3> c, const std::array<int, 3>& by) {
  for (size_t k = 0; k < 3; ++k) c[k] += by[k];
  return c;
}

}  // namespace

double plain_noise(const RgbImage& photo, const Rendering& rendering) {
  std::array<int64_t, 256> counts{};
  int64_t all = 0;
  for (int y = 1; y + 1 < photo.height; y += kEvery)
    for (int x = 1; x + 1 < photo.width; x += kEvery) {
      const int centre = grey(photo.at(x, y));
      int differ = 0;
      for (int i = 0; i < 9; ++i)
        differ = std::max(differ, std::abs(grey(photo.at(x - 1 + i % 3, y - 1 + i / 3)) - centre));
      if (differ > kPlainRange || rendering.alpha.at(x, y) < kOpaque) continue;
      ++counts[static_cast<size_t>(std::abs(centre - grey(rendering.colour.at(x, y))))];
      ++all;
    }
  int64_t below = 0;
  for (size_t level = 0; level < counts.size(); ++level) {
    if (2 * (below + counts[level]) >= all && all > 0)  // within the level, as if its differences lay evenly in it
      return std::max(
          0.0, static_cast<double>(level) - 0.5 +
                   (0.5 * static_cast<double>(all) - static_cast<double>(below)) / static_cast<double>(counts[level]));
    below += counts[level];
  }
  return 0;
}

Classifier::Classifier(const Held& own, const Rendering& rendering, const std::vector<const Held*>& beside,
                       double most_inverse_z, int tolerance, int most_depths)
    : own_(own),
      rendering_(rendering),
      most_inverse_z_(most_inverse_z),
      tolerance_(tolerance),
      most_depths_(most_depths) {
  if (beside.size() > kMostBeside) throw std::logic_error("Classifier: too many photographs are asked");
  const Pose& from = own.camera->pose;
  for (const Held* held : beside) {
    const Pose& to = held->camera->pose;
    View view{held, {}, {}};
    const Eigen::Vector3d step = exact_transposed_product(to.world_from_camera, from.centre - to.centre);
    for (int column = 0; column < 3; ++column) {
      const Eigen::Vector3d axis = exact_transposed_product(to.world_from_camera, from.world_from_camera.col(column));
      for (int row = 0; row < 3; ++row) view.turn[static_cast<size_t>(3 * row + column)] = axis[row];
      view.step[static_cast<size_t>(column)] = step[column];
    }
    views_.push_back(view);
  }
}

ResidualStatistics Classifier::cell(int x0, int y0, Plane<uint8_t>& map) const {
  ResidualStatistics sums;
  const int x1 = std::min(own_.photo.width, x0 + kCellPx), y1 = std::min(own_.photo.height, y0 + kCellPx);
  const Offset brightness = median_difference(x0, y0);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const bool hole = rendering_.alpha.at(x, y) < kOpaque;
      const auto a = channels(own_.photo.at(x, y)),
                 b = hole ? std::array{128, 128, 128} : channels(rendering_.colour.at(x, y));
      for (size_t k = 0; k < 3; ++k) sums.squared_difference += int64_t{a[k] - b[k]} * (a[k] - b[k]);
      sums.holes += hole;
      ++sums.pixels;
      if (x % kEvery != 0 || y % kEvery != 0) continue;
      const auto first = static_cast<Agreement>(map.at(x / kAsked * kAsked / kEvery, y / kAsked * kAsked / kEvery));
      const bool asked = x % kAsked != 0 || y % kAsked != 0;
      const Agreement agreement = hole ? Agreement::hole : classify(x, y, brightness, asked ? &first : nullptr);
      ++sums.classes[static_cast<size_t>(agreement)];
      map.at(x / kEvery, y / kEvery) = static_cast<uint8_t>(agreement);
    }
  return sums;
}

// Of the photograph minus the rendering.
Classifier::Offset Classifier::median_difference(int x0, int y0) const {
  constexpr int kMost = 255;
  std::array<std::array<uint16_t, 2 * kMost + 1>, 3> counts{};
  int all = 0;
  for (int y = y0; y < std::min(own_.photo.height, y0 + kCellPx); y += kEvery)
    for (int x = x0; x < std::min(own_.photo.width, x0 + kCellPx); x += kEvery) {
      if (rendering_.alpha.at(x, y) < kOpaque) continue;
      const auto a = channels(own_.photo.at(x, y)), b = channels(rendering_.colour.at(x, y));
      for (size_t k = 0; k < 3; ++k) ++counts[k][static_cast<size_t>(a[k] - b[k] + kMost)];
      ++all;
    }
  Offset offset;
  if (all == 0) return offset;
  for (size_t k = 0; k < 3; ++k) {
    size_t level = 0;
    for (int below = counts[k][0]; below <= all / 2; below += counts[k][level]) ++level;
    offset.median[k] = static_cast<int>(level) - kMost;
  }
  return offset;
}

bool Classifier::agree(const Surroundings& a, const Surroundings& b) const {
  return b.hold(a.colour(), tolerance_) && a.hold(b.colour(), tolerance_);
}

Agreement Classifier::classify(int x, int y, const Offset& brightness, const Agreement* first) const {
  const Surroundings photo(own_.photo, x, y), view(rendering_.colour, x, y);
  if (agree(photo, view)) return Agreement::agrees;
  const auto& by = brightness.median;
  if (view.hold(moved(photo.colour(), {-by[0], -by[1], -by[2]}), tolerance_) &&
      photo.hold(moved(view.colour(), by), tolerance_))
    return Agreement::exposure;
  return first && *first >= Agreement::wrong_colour ? *first : ask_others(x, y, photo);
}

// So many that a step is two pixels of parallax at most: of two pixels, one lies within a pixel of the other's place.
int Classifier::depths_to_try() const {
  double parallax_px = 0;
  for (const View& view : views_) {
    const double step =
        std::sqrt(view.step[0] * view.step[0] + view.step[1] * view.step[1] + view.step[2] * view.step[2]);
    parallax_px = std::max(parallax_px, step * most_inverse_z_ * own_.camera->intrinsics.fx);
  }
  return static_cast<int>(std::clamp(std::ceil(parallax_px / 2), 1.0, static_cast<double>(most_depths_)));
}

Agreement Classifier::ask_others(int x, int y, const Surroundings& own) const {
  const float depth = own_.depth.at(x, y);
  const double shown = depth > 0 ? 1 / static_cast<double>(depth) : 0;
  const Eigen::Vector3d ray = unproject(own_.camera->intrinsics, {x + 0.5, y + 0.5});
  Rays rays;
  bool seen_at_all = false;
  for (size_t i = 0; i < views_.size(); ++i) {
    const View& view = views_[i];
    rays[i] = turned(view, ray);
    const Seen seen = look(view, rays[i], shown);
    if (!seen.inside) continue;
    seen_at_all = true;
    if (visible(view, seen, shown) && agree(own, {view.held->photo, seen.x, seen.y})) return Agreement::wrong_colour;
  }
  if (x < 1 || y < 1 || x + 1 >= own_.photo.width || y + 1 >= own_.photo.height)
    return seen_at_all ? Agreement::moved : Agreement::alone;
  Patch patch;
  for (size_t i = 0; i < kPatch.size(); ++i) patch[i] = {own_.photo, x + kPatch[i][0], y + kPatch[i][1]};
  const int depths = depths_to_try();
  for (int i = depths; i >= 0; --i) {
    const double inverse_z = most_inverse_z_ * i / depths;
    if (patches_agree(patch, rays, inverse_z)) return inverse_z > shown ? Agreement::missing : Agreement::wrong_depth;
  }
  return seen_at_all ? Agreement::moved : Agreement::alone;
}

Eigen::Vector3d Classifier::turned(const View& view, const Eigen::Vector3d& ray) const {
  Eigen::Vector3d there;
  for (int row = 0; row < 3; ++row) {
    const auto at = static_cast<size_t>(3 * row);
    there[row] = view.turn[at] * ray.x() + view.turn[at + 1] * ray.y() + view.turn[at + 2] * ray.z();
  }
  return there;
}

Classifier::Seen Classifier::look(const View& view, const Eigen::Vector3d& turned_ray, double inverse_z) const {
  Eigen::Vector3d there = turned_ray;
  for (int row = 0; row < 3; ++row) there[row] += view.step[static_cast<size_t>(row)] * inverse_z;
  if (there.z() < kBehind) return {};
  const Eigen::Vector2d place = project(view.held->camera->intrinsics, there);
  const RgbImage& photo = view.held->photo;
  if (!(place.x() >= 1 && place.x() < photo.width - 1 && place.y() >= 1 && place.y() < photo.height - 1)) return {};
  return {true, static_cast<int>(place.x()), static_cast<int>(place.y()), there.z()};
}

// Does the panorama show it there, too?
bool Classifier::visible(const View& view, const Seen& seen, double inverse_z) const {
  const float depth = view.held->depth.at(seen.x, seen.y);
  const double nearest = depth > 0 ? 1 / static_cast<double>(depth) : 0;
  return nearest <= (1 + kSamePlace) * inverse_z / seen.z + kSamePlace * most_inverse_z_ / kLabels;
}

// Whether it looks the same in every photograph that may see it there.
bool Classifier::patches_agree(const Patch& patch, const Rays& rays, double inverse_z) const {
  int views = 0;
  for (size_t v = 0; v < views_.size(); ++v) {
    const Seen seen = look(views_[v], rays[v], inverse_z);
    if (!seen.inside) continue;
    for (size_t i = 0; i < patch.size(); ++i)
      if (!agree(patch[i], {views_[v].held->photo, seen.x + kPatch[i][0], seen.y + kPatch[i][1]})) return false;
    ++views;
  }
  return views > 0;
}

}  // namespace ldp::consistency
