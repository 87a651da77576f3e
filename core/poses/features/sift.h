// Scale-invariant feature points (Lowe, "Distinctive image features from scale-invariant keypoints", 2004).
//
// Takes a grey picture; gives the points where differences of Gaussians are extreme over place and scale, the
// directions in which brightness changes most around them, and histograms of gradients that describe them.
//
// Here and not from a library: libraries multiply and add in one rounding where a processor can, and the smallest
// differences become other keypoints, matches and poses. Here every operation is one of IEEE 754 in a fixed order, so
// that features are the same bytes everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/plane.h"

namespace ldp::sfm {

struct Keypoint {
  double x = 0, y = 0, sigma = 0;  // place and scale in pixels of its octave, whose centres are at whole numbers
  int octave = 0, level = 0;
  double response = 0;   // the difference of Gaussians, grey levels
  double angle_rad = 0;  // of the gradients around it

  // A place of its octave in the picture, pixel centres at .5: the first octave has twice the picture's pixels, each
  // further one those at even places of the one before.
  double in_picture(double place) const { return 0.5 * (place * (1 << octave) + 0.5); }
};

class Sift {
 public:
  static constexpr int kLevels = 3;  // per octave
  static constexpr int kCells = 4, kOrientations = 8;
  using Histograms = std::array<uint8_t, size_t{kCells} * kCells * kOrientations>;

  // Extrema below `contrast` grey levels are left out.
  Sift(const GreyImage& picture, double contrast);

  // Without directions.
  const std::vector<Keypoint>& extrema() const { return extrema_; }

  // An extremum, once for each of its directions.
  std::vector<Keypoint> oriented(const Keypoint& extremum) const;

  Histograms describe(const Keypoint& keypoint) const;

 private:
  const Plane<float>& level_of(const Keypoint& keypoint) const {
    return octaves_[static_cast<size_t>(keypoint.octave)][static_cast<size_t>(keypoint.level) - 1];
  }

  std::vector<std::array<Plane<float>, kLevels>> octaves_;  // blurred ever more
  std::vector<Keypoint> extrema_;
};

}  // namespace ldp::sfm
