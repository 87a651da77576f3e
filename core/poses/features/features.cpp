#include "core/poses/features/features.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/photos/resize.h"
#include "core/poses/features/feature_tuning.h"
#include "core/poses/features/sift.h"

namespace ldp::sfm {
namespace {

static_assert(std::tuple_size_v<Sift::Histograms> == kDescriptorLength);

GreyImage scaled(GreyImage grey, double scale) {
  if (scale >= 1) return grey;
  const auto size = [scale](int pixels) { return std::max(1, static_cast<int>(std::lround(scale * pixels))); };
  return resize_by_area(grey, size(grey.width), size(grey.height));
}

// Bucketing: strongest first, but no cell of the picture takes more than twice its share as long as others have some to
// offer.
std::vector<Keypoint> select_keypoints(const Sift& sift, const GreyImage& picture, int most) {
  std::vector<Keypoint> points = sift.extrema();
  std::stable_sort(points.begin(), points.end(),
                   [](const Keypoint& p, const Keypoint& q) { return p.response > q.response; });
  std::vector<int> taken(size_t{kKeypointGridCells} * kKeypointGridCells, 0);
  std::vector<Keypoint> kept;
  std::vector<std::pair<Keypoint, size_t>> spare;  // extrema, and how many of their directions were taken
  const int share = std::max(1, 2 * most / (kKeypointGridCells * kKeypointGridCells));
  const auto bucket = [](double place, int size) {
    return std::clamp(static_cast<int>(place * kKeypointGridCells / size), 0, kKeypointGridCells - 1);
  };
  const auto enough = [&] { return kept.size() >= static_cast<size_t>(most); };
  for (size_t i = 0; i < points.size() && !enough(); ++i) {
    const Keypoint& p = points[i];
    const int column = bucket(p.in_picture(p.x), picture.width), row = bucket(p.in_picture(p.y), picture.height);
    int& count = taken[static_cast<size_t>(row * kKeypointGridCells + column)];
    size_t taken_orientations = 0;
    if (count < share) {
      const std::vector<Keypoint> oriented = sift.oriented(p);
      for (; taken_orientations < oriented.size() && count < share; ++taken_orientations, ++count)
        kept.push_back(oriented[taken_orientations]);
    }
    if (count >= share) spare.emplace_back(p, taken_orientations);
  }
  for (size_t i = 0; i < spare.size() && !enough(); ++i) {
    const std::vector<Keypoint> oriented = sift.oriented(spare[i].first);
    kept.insert(kept.end(), oriented.begin() + static_cast<std::ptrdiff_t>(spare[i].second), oriented.end());
  }
  if (enough()) kept.resize(static_cast<size_t>(most));
  return kept;
}

// RootSIFT: square roots of the histogram normalised to sum 1, so that Euclidean distance compares by Hellinger's.
void append_root_sift(const Sift::Histograms& histograms, std::vector<int16_t>& descriptors) {
  const double sum = std::max(1, std::accumulate(histograms.begin(), histograms.end(), 0));
  for (const uint8_t h : histograms) {
    descriptors.push_back(static_cast<int16_t>(std::floor(kDescriptorNorm * std::sqrt(h / sum) + 0.5)));
  }
}

}  // namespace

GreyPhoto make_grey_photo(const RgbImage& image, int most_px) {
  GreyImage grey(image.width, image.height);
  std::transform(image.samples.begin(), image.samples.end(), grey.samples.begin(), [](const Rgb& pixel) {
    return static_cast<uint8_t>((4899 * pixel.r + 9617 * pixel.g + 1868 * pixel.b + 8192) / 16384);  // BT.601
  });
  grey = scaled(std::move(grey), static_cast<double>(most_px) / std::max(image.width, image.height));
  const Eigen::Vector2d scale(static_cast<double>(grey.width) / image.width,
                              static_cast<double>(grey.height) / image.height);
  return {std::move(grey), scale, image.width, image.height};
}

Features detect_features(const GreyPhoto& image, const FeatureOptions& options) {
  const GreyImage grey = scaled(image.grey, options.longer_side_px / std::max(image.grey.width, image.grey.height));
  const Sift sift(grey, kMinKeypointContrast);
  Features features;
  features.width = image.width;
  features.height = image.height;
  const double scale_x = static_cast<double>(image.width) / grey.width,
               scale_y = static_cast<double>(image.height) / grey.height;
  for (const Keypoint& p : select_keypoints(sift, grey, options.max_features)) {
    features.positions.emplace_back(p.in_picture(p.x) * scale_x, p.in_picture(p.y) * scale_y);
    append_root_sift(sift.describe(p), features.descriptors);
  }
  return features;
}

}  // namespace ldp::sfm
