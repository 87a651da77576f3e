#include "core/view/inpainting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

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

struct Cell {
  float r = 0, g = 0, b = 0, weight = 0;  // colour is the mean of what was averaged, weight at most 1
};
using Cells = Plane<Cell>;

// Solid pixels near a hole whose depth is that of the hole's background.
Cells rim_of_holes(const Plane<float>& inverse_z, const RgbImage& colour, const Plane<uint8_t>& alpha) {
  const Plane<float> background = BackgroundDepth(inverse_z, alpha).take();
  Cells rim(colour.width, colour.height);
  for (int y = 0; y < rim.height; ++y)
    for (int x = 0; x < rim.width; ++x) {
      if (alpha.at(x, y) >= kSolidAlpha) continue;
      const float farthest = 1.1F * background.at(x, y) + 1e-4F;
      for (int ny = std::max(0, y - kRimPx); ny <= std::min(rim.height - 1, y + kRimPx); ++ny)
        for (int nx = std::max(0, x - kRimPx); nx <= std::min(rim.width - 1, x + kRimPx); ++nx) {
          if (alpha.at(nx, ny) < kSolidAlpha || inverse_z.at(nx, ny) > farthest) continue;
          const Rgb c = colour.at(nx, ny);
          rim.at(nx, ny) = {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b), 1};
        }
    }
  return rim;
}

Cells pull(const Cells& fine) {
  Cells coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const Cell& from = fine.at(x, y);
      Cell& to = coarse.at(x / 2, y / 2);
      to.r += from.weight * from.r;
      to.g += from.weight * from.g;
      to.b += from.weight * from.b;
      to.weight += from.weight;
    }
  for (Cell& c : coarse.samples) {
    if (c.weight <= 0) continue;
    c = {c.r / c.weight, c.g / c.weight, c.b / c.weight, std::min(1.0F, c.weight)};
  }
  return coarse;
}

// Bilinear sample of the coarse level at the centre of a fine cell.
Cell sample(const Cells& coarse, int x, int y) {
  const int x0 = (x - 1) >> 1, y0 = (y - 1) >> 1;
  const float s = (x & 1) != 0 ? 0.25F : 0.75F, t = (y & 1) != 0 ? 0.25F : 0.75F;
  Cell sum;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const Cell& c = coarse.at(std::clamp(x0 + i, 0, coarse.width - 1), std::clamp(y0 + j, 0, coarse.height - 1));
      const float w = (i != 0 ? s : 1 - s) * (j != 0 ? t : 1 - t);
      sum.r += w * c.r;
      sum.g += w * c.g;
      sum.b += w * c.b;
    }
  return sum;
}

void push(const Cells& coarse, Cells& fine) {
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      Cell& c = fine.at(x, y);
      if (c.weight >= 1) continue;
      const Cell from = sample(coarse, x, y);
      const float w = c.weight;
      c = {w * c.r + (1 - w) * from.r, w * c.g + (1 - w) * from.g, w * c.b + (1 - w) * from.b, 1};
    }
}

}  // namespace

double fill_background(const Plane<float>& inverse_z, RgbImage& colour, Plane<uint8_t>& alpha) {
  const auto holes = std::count_if(alpha.samples.begin(), alpha.samples.end(), [](uint8_t a) { return a < 128; });
  std::vector<Cells> levels = {rim_of_holes(inverse_z, colour, alpha)};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(pull(levels.back()));
  if (levels.back().samples[0].weight <= 0) levels.back().samples[0] = {127, 127, 127, 1};
  for (size_t i = levels.size() - 1; i > 0; --i) push(levels[i], levels[i - 1]);
  for (size_t i = 0; i < colour.samples.size(); ++i) {
    const Cell& background = levels[0].samples[i];
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
