#include "core/consistency/classify.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/base/exact_math.h"

namespace ldp::consistency {
namespace {

constexpr int kEvery = 2;       // pixels, both ways, are classified
constexpr int kAsked = 4;       // of what differs in a square of so many, other photographs are asked about the first
constexpr int kOpaque = 128;    // alpha from which a pixel is not a hole
constexpr int kPlainRange = 6;  // grey levels within 3x3 pixels of a plain place
constexpr double kSamePlace = 0.15;  // share of its inverse depth by which a surface may differ and still be seen
constexpr double kBehind = 1e-6;
constexpr std::array<std::array<int, 2>, 5> kPatch = {{{0, 0}, {-1, -1}, {1, 1}, {1, -1}, {-1, 1}}};

std::array<int, 3> channels(Rgb c) { return {c.r, c.g, c.b}; }

// The range of each channel over the pixel and its neighbours.
struct Range {
  std::array<int, 3> low{255, 255, 255}, high{0, 0, 0};

  Range(const RgbImage& image, int x, int y) {
    const bool inside = x > 0 && y > 0 && x + 1 < image.width && y + 1 < image.height;
    inside ? take_square(image, x, y) : take_what_there_is(image, x, y);
  }
  bool holds(const std::array<int, 3>& c, int tolerance) const {
    for (size_t k = 0; k < 3; ++k)
      if (c[k] < low[k] - tolerance || c[k] > high[k] + tolerance) return false;
    return true;
  }

 private:
  // Rows first: their bytes lie side by side.
  void take_square(const RgbImage& image, int x, int y) {
    static_assert(sizeof(Rgb) == 3);
    const auto row = [&](int ny) { return reinterpret_cast<const uint8_t*>(image.row(ny) + x - 1); };
    const uint8_t *above = row(y - 1), *on = row(y), *below = row(y + 1);
    std::array<uint8_t, 9> least, most;
    for (size_t i = 0; i < 9; ++i) {
      least[i] = std::min(std::min(above[i], on[i]), below[i]);
      most[i] = std::max(std::max(above[i], on[i]), below[i]);
    }
    for (size_t k = 0; k < 3; ++k) {
      low[k] = std::min(std::min(least[k], least[k + 3]), least[k + 6]);
      high[k] = std::max(std::max(most[k], most[k + 3]), most[k + 6]);
    }
  }
  void take_what_there_is(const RgbImage& image, int x, int y) {
    for (int ny = std::max(0, y - 1); ny <= std::min(image.height - 1, y + 1); ++ny)
      for (int nx = std::max(0, x - 1); nx <= std::min(image.width - 1, x + 1); ++nx) {
        const auto c = channels(image.at(nx, ny));
        for (size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], c[k]), high[k] = std::max(high[k], c[k]);
      }
  }
};

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
  std::array<std::vector<int>, 3> differences;
  for (int y = y0; y < std::min(own_.photo.height, y0 + kCellPx); y += kEvery)
    for (int x = x0; x < std::min(own_.photo.width, x0 + kCellPx); x += kEvery) {
      if (rendering_.alpha.at(x, y) < kOpaque) continue;
      const auto a = channels(own_.photo.at(x, y)), b = channels(rendering_.colour.at(x, y));
      for (size_t k = 0; k < 3; ++k) differences[k].push_back(a[k] - b[k]);
    }
  Offset offset;
  for (size_t k = 0; k < 3; ++k) {
    if (differences[k].empty()) continue;
    const auto middle = differences[k].begin() + static_cast<std::ptrdiff_t>(differences[k].size() / 2);
    std::nth_element(differences[k].begin(), middle, differences[k].end());
    offset.median[k] = *middle;
  }
  return offset;
}

// Whether either pixel's colour occurs around the other: half a pixel's shift is no disagreement.
bool Classifier::agree(const RgbImage& a, int ax, int ay, const RgbImage& b, int bx, int by,
                       const Offset& brighter) const {
  auto of_a = channels(a.at(ax, ay)), of_b = channels(b.at(bx, by));
  for (size_t k = 0; k < 3; ++k) of_a[k] -= brighter.median[k], of_b[k] += brighter.median[k];
  return Range(b, bx, by).holds(of_a, tolerance_) && Range(a, ax, ay).holds(of_b, tolerance_);
}

Agreement Classifier::classify(int x, int y, const Offset& brightness, const Agreement* first) const {
  if (agree(own_.photo, x, y, rendering_.colour, x, y, {})) return Agreement::agrees;
  if (agree(own_.photo, x, y, rendering_.colour, x, y, brightness)) return Agreement::exposure;
  return first && *first >= Agreement::wrong_colour ? *first : ask_others(x, y);
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

Agreement Classifier::ask_others(int x, int y) const {
  const float depth = own_.depth.at(x, y);
  const double shown = depth > 0 ? 1 / static_cast<double>(depth) : 0;
  const Eigen::Vector3d ray = unproject(own_.camera->intrinsics, {x + 0.5, y + 0.5});
  bool seen_at_all = false;
  for (const View& view : views_) {
    const Seen seen = look(view, ray, shown);
    if (!seen.inside) continue;
    seen_at_all = true;
    if (visible(view, seen, shown) && agree(own_.photo, x, y, view.held->photo, seen.x, seen.y, {}))
      return Agreement::wrong_colour;
  }
  const int depths = depths_to_try();
  for (int i = depths; i >= 0; --i) {
    const double inverse_z = most_inverse_z_ * i / depths;
    if (patches_agree(x, y, ray, inverse_z)) return inverse_z > shown ? Agreement::missing : Agreement::wrong_depth;
  }
  return seen_at_all ? Agreement::moved : Agreement::alone;
}

Classifier::Seen Classifier::look(const View& view, const Eigen::Vector3d& ray, double inverse_z) const {
  Eigen::Vector3d there;
  for (int row = 0; row < 3; ++row) {
    const auto at = static_cast<size_t>(3 * row);
    there[row] = view.turn[at] * ray.x() + view.turn[at + 1] * ray.y() + view.turn[at + 2] * ray.z() +
                 view.step[static_cast<size_t>(row)] * inverse_z;
  }
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

// Whether a patch looks the same in every photograph that may see them there.
bool Classifier::patches_agree(int x, int y, const Eigen::Vector3d& ray, double inverse_z) const {
  const RgbImage& photo = own_.photo;
  if (x < 1 || y < 1 || x + 1 >= photo.width || y + 1 >= photo.height) return false;
  int views = 0;
  for (const View& view : views_) {
    const Seen seen = look(view, ray, inverse_z);
    if (!seen.inside) continue;
    for (const auto& [dx, dy] : kPatch)
      if (!agree(photo, x + dx, y + dy, view.held->photo, seen.x + dx, seen.y + dy, {})) return false;
    ++views;
  }
  return views > 0;
}

}  // namespace ldp::consistency
