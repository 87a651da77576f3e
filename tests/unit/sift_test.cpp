#include "core/poses/features/sift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/base/exact_math.h"

namespace ldp::sfm {
namespace {

// Bright and dark spots of many sizes: whole numbers from exact functions only.
GreyImage spots(int width, int height) {
  std::vector<double> sums(static_cast<size_t>(width * height), 128);
  uint32_t state = 1;
  const auto random = [&state](uint32_t below) {
    return static_cast<int>((state = state * 1664525U + 1013904223U) / 65536 % below);
  };
  for (int i = 0; i < 150; ++i) {
    const int x = random(static_cast<uint32_t>(width)), y = random(static_cast<uint32_t>(height));
    const double sigma = 1 + 0.1 * random(60), height_of = random(2) == 0 ? 60 : -60;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const double squared = (u - x) * (u - x) + (v - y) * (v - y);
        sums[static_cast<size_t>(v * width + u)] +=
            height_of * exact_exp(std::max(-100.0, -0.5 * squared / (sigma * sigma)));
      }
    }
  }
  GreyImage image(width, height);
  std::transform(sums.begin(), sums.end(), image.samples.begin(),
                 [](double s) { return static_cast<uint8_t>(std::clamp(s, 0.0, 255.0)); });
  return image;
}

GreyImage quarter_turned(const GreyImage& image) {  // (x, y) to (height - y, x)
  GreyImage turned(image.height, image.width);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) turned.at(image.height - 1 - y, x) = image.at(x, y);
  }
  return turned;
}

std::vector<Keypoint> keypoints_of(const Sift& sift) {
  std::vector<Keypoint> keypoints;
  for (const Keypoint& extremum : sift.extrema()) {
    for (const Keypoint& keypoint : sift.oriented(extremum)) keypoints.push_back(keypoint);
  }
  return keypoints;
}

int distance(const Sift::Histograms& a, const Sift::Histograms& b) {
  int sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return static_cast<int>(std::lround(std::sqrt(sum)));
}

TEST(Sift, FindsASpotWhereItIsAndAsLargeAsItIs) {
  for (const double sigma : {2.0, 3.7, 6.0}) {
    const double x = 50.3, y = 47.8;
    GreyImage image(100, 100);
    for (int v = 0; v < 100; ++v) {
      for (int u = 0; u < 100; ++u) {
        const double squared = std::pow(u + 0.5 - x, 2) + std::pow(v + 0.5 - y, 2);
        image.at(u, v) = static_cast<uint8_t>(std::lround(50 + 200 * std::exp(-0.5 * squared / (sigma * sigma))));
      }
    }
    const Sift sift(image, 5);
    ASSERT_FALSE(keypoints_of(sift).empty()) << "sigma " << sigma;
    for (const Keypoint& p : keypoints_of(sift)) {
      EXPECT_NEAR(p.in_picture(p.x), x, 0.05);
      EXPECT_NEAR(p.in_picture(p.y), y, 0.05);
      EXPECT_NEAR(p.sigma * 0.5 * (1 << p.octave) / sigma, 0.9, 0.15);
    }
  }
}

// In the first octave: those after it keep every second pixel, which are others when turned.
TEST(Sift, OfATurnedPictureIsTurnedAndLooksTheSame) {
  const GreyImage image = spots(160, 120);
  const Sift sift(image, 1), turned(quarter_turned(image), 1);
  const std::vector<Keypoint> all_turned = keypoints_of(turned);
  int all = 0, found = 0;
  for (const Keypoint& p : keypoints_of(sift)) {
    if (p.octave > 0) continue;
    ++all;
    const Sift::Histograms wanted = sift.describe(p);
    found += std::any_of(all_turned.begin(), all_turned.end(), [&](const Keypoint& q) {
      const double dx = q.in_picture(q.x) - (image.height - p.in_picture(p.y)),
                   dy = q.in_picture(q.y) - p.in_picture(p.x);
      const double by = std::remainder(q.angle_rad - p.angle_rad - std::numbers::pi / 2, 2 * std::numbers::pi);
      return std::hypot(dx, dy) < 0.5 && std::abs(by) < 0.1 && distance(turned.describe(q), wanted) < 100;
    });
  }
  EXPECT_GT(all, 20);
  EXPECT_EQ(found, all);
}

TEST(Sift, FindsNothingInPlainPicturesAndBearsSmallOnes) {
  EXPECT_TRUE(Sift(GreyImage(64, 64, 90), 1).extrema().empty());
  EXPECT_TRUE(Sift(GreyImage(1, 1, 90), 1).extrema().empty());
  EXPECT_TRUE(Sift(GreyImage(200, 3, 90), 1).extrema().empty());
}

// The number was found on x86-64; it changes only with the method.
TEST(Sift, GivesTheSameBytesOnEveryMachine) {
  const Sift sift(spots(160, 120), 1);
  uint64_t sum = 0;
  const auto take = [&sum](uint64_t value) { sum = (sum ^ value) * 1099511628211U; };
  for (const Keypoint& p : keypoints_of(sift)) {
    for (const double value : {p.x, p.y, p.sigma, p.response, p.angle_rad}) take(std::bit_cast<uint64_t>(value));
    for (const uint8_t byte : sift.describe(p)) take(byte);
  }
  EXPECT_EQ(sum, 13396217140366786282U);
}

}  // namespace
}  // namespace ldp::sfm
