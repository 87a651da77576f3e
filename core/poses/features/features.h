// Feature points of one photograph: where they are, and what they look like. Scale-invariant (SIFT, Lowe 2004) on grey
// scaled down, because it is the coarse points that survive a change of view, and because time and memory go by area.
//
// Takes a colour image; gives at most `max_features` points, strongest first but spread over the picture. Descriptors
// are RootSIFT (Arandjelovic and Zisserman 2012) rounded to integers, so that matching is exact.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/plane.h"

namespace ldp::sfm {

constexpr int kDescriptorLength = 128;

struct Features {
  int width = 0, height = 0;               // of the photograph, pixels
  std::vector<Eigen::Vector2d> positions;  // in the photograph, pixel centres at .5
  std::vector<int16_t> descriptors;        // kDescriptorLength per point, of Euclidean length about kDescriptorNorm

  int size() const { return static_cast<int>(positions.size()); }
  Eigen::Vector2d centred(int i) const {
    return positions[static_cast<size_t>(i)] - 0.5 * Eigen::Vector2d(width, height);
  }
  const int16_t* descriptor(int i) const { return descriptors.data() + static_cast<size_t>(i) * kDescriptorLength; }
};

constexpr int kDescriptorNorm = 512;

struct FeatureOptions {
  int max_features = 2000;      // points kept
  double longer_side_px = 480;  // the photo is scaled down to about this before detection (which works at twice it)
};

// The photograph in grey, scaled down if its longer side has more than `most_px` pixels. This is what is kept of it.
struct GreyPhoto {
  GreyImage grey;
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();  // pixels of `grey` per pixel of the photograph
  int width = 0, height = 0;                        // of the photograph
};

GreyPhoto make_grey_photo(const RgbImage& image, int most_px);

Features detect_features(const GreyPhoto& picture, const FeatureOptions& options);

}  // namespace ldp::sfm
