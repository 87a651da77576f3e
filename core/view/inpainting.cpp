#include "core/view/inpainting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/panorama/pull_push.h"
#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

// Background inverse z of every hole: the smallest among the first solid pixels to its left, right, top and bottom.
// Solid pixels keep infinity.
class BackgroundDepth {
 public:
  BackgroundDepth(const Plane<float>& inverse_z, const Plane<uint8_t>& alpha)
      : inverse_z_(inverse_z), alpha_(alpha), result_(inverse_z.width, inverse_z.height, kNone) {
    const int width = inverse_z.width, height = inverse_z.height;
    for (int y = 0; y < height; ++y) sweep(width, [y](int i) { return std::array{i, y}; });
    for (int x = 0; x < width; ++x) sweep(height, [x](int i) { return std::array{x, i}; });
  }
  Plane<float> take() { return std::move(result_); }
  static constexpr float kNone = std::numeric_limits<float>::infinity();

 private:
  template <class Place>
  void sweep(int count, Place place) {
    const auto pass = [&](auto index) {
      float last = kNone;
      for (int i = 0; i < count; ++i) {
        const auto [x, y] = place(index(i));
        if (alpha_.at(x, y) >= kSolidAlpha)
          last = inverse_z_.at(x, y);
        else
          result_.at(x, y) = std::min(result_.at(x, y), last);
      }
    };
    pass([](int i) { return i; });
    pass([count](int i) { return count - 1 - i; });
  }

  const Plane<float>& inverse_z_;
  const Plane<uint8_t>& alpha_;
  Plane<float> result_;
};

// Solid pixels near a hole whose depth is that of the hole's background.
Plane<WeightedColour> rim_of_holes(const Plane<float>& inverse_z, const RgbImage& colour, const Plane<uint8_t>& alpha) {
  const Plane<float> background = BackgroundDepth(inverse_z, alpha).take();
  Plane<WeightedColour> rim(colour.width, colour.height);
  for (int y = 0; y < rim.height; ++y)
    for (int x = 0; x < rim.width; ++x) {
      if (alpha.at(x, y) >= kSolidAlpha) continue;
      const float farthest = 1.1F * background.at(x, y) + 1e-4F;
      for (int ny = std::max(0, y - kRimPx); ny <= std::min(rim.height - 1, y + kRimPx); ++ny)
        for (int nx = std::max(0, x - kRimPx); nx <= std::min(rim.width - 1, x + kRimPx); ++nx) {
          if (alpha.at(nx, ny) < kSolidAlpha || inverse_z.at(nx, ny) > farthest) continue;
          rim.at(nx, ny) = known(colour.at(nx, ny));
        }
    }
  return rim;
}

}  // namespace

double fill_background(const Plane<float>& inverse_z, RgbImage& colour, Plane<uint8_t>& alpha) {
  const auto holes = std::count_if(alpha.samples.begin(), alpha.samples.end(), [](uint8_t a) { return a < 128; });
  Plane<WeightedColour> continued = rim_of_holes(inverse_z, colour, alpha);
  fill_by_pull_push(continued);
  for (size_t i = 0; i < colour.samples.size(); ++i) {
    const WeightedColour& background = continued.samples[i];
    const float own = static_cast<float>(alpha.samples[i]) / 255;
    const auto mix = [own](uint8_t mine, float other) {
      return static_cast<uint8_t>(std::floor(own * static_cast<float>(mine) + (1 - own) * other + 0.5F));
    };
    Rgb& c = colour.samples[i];
    if (alpha.samples[i] < kSolidAlpha) c = {mix(c.r, background.r), mix(c.g, background.g), mix(c.b, background.b)};
    alpha.samples[i] = 255;
  }
  return static_cast<double>(holes) / static_cast<double>(std::max<size_t>(1, colour.samples.size()));
}

Plane<float> background_behind_holes(const Plane<float>& inverse_z, const Plane<uint8_t>& alpha) {
  Plane<float> whole = inverse_z;
  const Plane<float> background = BackgroundDepth(inverse_z, alpha).take();
  for (size_t i = 0; i < whole.samples.size(); ++i) {
    if (whole.samples[i] >= 0) continue;
    whole.samples[i] = std::isfinite(background.samples[i]) ? background.samples[i] : 0;
  }
  return whole;
}

}  // namespace ldp::view
