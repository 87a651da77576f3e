// One octave of a picture's scale space (Lowe 2004, sections 3 and 4): ever more blurred copies, and the places where
// differences of neighbouring ones are extreme.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/plane.h"
#include "core/poses/features/sift.h"

namespace ldp::sfm {

// Half of a Gaussian: exp(-d^2 / 2 sigma^2) for d = 0, 1, ...
std::vector<float> gaussian(int count, double sigma);

// What an octave begins with: the first one with a picture of twice the size, the others with every second pixel of a
// level of the one before.
Plane<float> base_level(const GreyImage& picture);
Plane<float> decimated(const Plane<float>& image);

class Octave {
 public:
  static constexpr int kBorder = 5;  // pixels without extrema

  explicit Octave(Plane<float> first);

  Plane<float>& blur(int level) { return blur_[static_cast<size_t>(level)]; }

  // Of levels 1 to Sift::kLevels, level by level; without directions, and without the octave's number.
  std::vector<Keypoint> extrema(double contrast) const;

 private:
  static constexpr int kBlurs = Sift::kLevels + 3;  // each blurred 2^(1 / kLevels) times as much as the one before

  int width() const { return blur_[0].width; }
  int height() const { return blur_[0].height; }
  float difference(int level, int x, int y) const {
    const size_t i = static_cast<size_t>(level), at = blur_[0].index(x, y);
    return blur_[i + 1].samples[at] - blur_[i].samples[at];
  }
  std::optional<Keypoint> localised(int level, int x, int y, double contrast) const;

  std::array<Plane<float>, kBlurs> blur_;
};

}  // namespace ldp::sfm
