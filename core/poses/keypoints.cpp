#include "keypoints.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace ldp {
namespace {

constexpr int kBuckets = 8;          // the picture is dealt out in kBuckets x kBuckets cells
constexpr double kContrast = 0.012;  // lower than Lowe's 0.04: skies and walls have faint texture, and it matches

// From OpenCV's pixel centres at whole numbers to ours at .5, less the quarter pixel by which its SIFT errs: it doubles
// the picture with pixel centres kept in place, and halves the positions found as if their corners had been.
constexpr double kMiddle = 0.5 - 0.25;

// cv::Mat has no const view.
template <typename Sample>
cv::Mat view(const Plane<Sample>& image, int type) {
  return {image.height, image.width, type, const_cast<void*>(static_cast<const void*>(image.samples.data()))};
}

cv::Mat scaled(const cv::Mat& grey, double scale) {
  if (scale >= 1) return grey;
  cv::Mat small;
  cv::resize(grey, small, cv::Size(), scale, scale, cv::INTER_AREA);
  return small;
}

// Strongest first, but no cell of the picture takes more than twice its share as long as others have some to offer.
std::vector<size_t> spread_out(const std::vector<cv::KeyPoint>& points, cv::Size size, int most) {
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto key = [&](size_t i) {
    return std::make_tuple(-points[i].response, points[i].pt.x, points[i].pt.y, points[i].angle, points[i].size);
  };
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return key(a) < key(b); });
  std::vector<int> taken(kBuckets * kBuckets, 0);
  std::vector<size_t> kept, spare;
  const int share = std::max(1, 2 * most / (kBuckets * kBuckets));
  for (const size_t i : order) {
    const int column =
        std::clamp(static_cast<int>(points[i].pt.x * kBuckets / static_cast<float>(size.width)), 0, kBuckets - 1);
    const int row =
        std::clamp(static_cast<int>(points[i].pt.y * kBuckets / static_cast<float>(size.height)), 0, kBuckets - 1);
    int& count = taken[static_cast<size_t>(row * kBuckets + column)];
    (count++ < share ? kept : spare).push_back(i);
  }
  kept.insert(kept.end(), spare.begin(), spare.end());
  if (kept.size() > static_cast<size_t>(most)) kept.resize(static_cast<size_t>(most));
  return kept;
}

// RootSIFT: square roots of the histogram normalised to sum 1, so that Euclidean distance compares by Hellinger's.
void root_descriptor(const float* sift, int16_t* out) {
  float sum = 1e-7F;
  for (int i = 0; i < kDescriptorLength; ++i) sum += sift[i];
  for (int i = 0; i < kDescriptorLength; ++i) {
    out[i] = static_cast<int16_t>(std::lround(kDescriptorNorm * std::sqrt(static_cast<double>(sift[i] / sum))));
  }
}

}  // namespace

GreyPhoto make_grey_photo(const RgbImage& image, int most_px) {
  cv::Mat grey;
  cv::cvtColor(view(image, CV_8UC3), grey, cv::COLOR_RGB2GRAY);
  grey = scaled(grey, static_cast<double>(most_px) / std::max(image.width, image.height));
  GreyPhoto picture{GreyImage(grey.cols, grey.rows), static_cast<double>(grey.cols) / image.width, image.width,
                    image.height};
  grey.copyTo(view(picture.grey, CV_8UC1));
  return picture;
}

Features detect_features(const GreyPhoto& image, const FeatureOptions& options) {
  Features features;
  features.width = image.width;
  features.height = image.height;
  const cv::Mat grey =
      scaled(view(image.grey, CV_8UC1), options.longer_side_px / std::max(image.grey.width, image.grey.height));
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(0, 3, kContrast, 10, 1.6);
  std::vector<cv::KeyPoint> found;
  sift->detect(grey, found);
  std::vector<cv::KeyPoint> points;
  for (const size_t i : spread_out(found, grey.size(), options.most)) points.push_back(found[i]);
  cv::Mat descriptors;
  sift->compute(grey, points, descriptors);

  const double scale_x = static_cast<double>(image.width) / grey.cols,
               scale_y = static_cast<double>(image.height) / grey.rows;
  features.descriptors.resize(points.size() * kDescriptorLength);
  for (size_t i = 0; i < points.size(); ++i) {
    const cv::KeyPoint& p = points[i];
    features.positions.emplace_back((static_cast<double>(p.pt.x) + kMiddle) * scale_x,
                                    (static_cast<double>(p.pt.y) + kMiddle) * scale_y);
    features.sizes.push_back(static_cast<float>(p.size * scale_x));
    root_descriptor(descriptors.ptr<float>(static_cast<int>(i)), features.descriptors.data() + i * kDescriptorLength);
  }
  return features;
}

}  // namespace ldp
