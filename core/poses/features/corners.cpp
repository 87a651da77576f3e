#include "core/poses/features/corners.h"

#include <algorithm>
#include <cmath>

#include "core/poses/features/feature_tuning.h"

namespace ldp::sfm {
namespace {

struct Gradients {
  Plane<float> xx, xy, yy;  // products; sums of 49 are whole numbers of quarters below 2^22, hence exact in any order
};

Gradients gradient_products(const GreyImage& picture) {
  const int w = picture.width, h = picture.height;
  Gradients g{{w, h, 0}, {w, h, 0}, {w, h, 0}};
  for (int y = 1; y + 1 < h; ++y) {
    const uint8_t *above = picture.row(y - 1), *row = picture.row(y), *below = picture.row(y + 1);
    float *xx = g.xx.row(y), *xy = g.xy.row(y), *yy = g.yy.row(y);
    for (int x = 1; x + 1 < w; ++x) {
      const float gx = 0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
      const float gy = 0.5F * static_cast<float>(below[x] - above[x]);
      xx[x] = gx * gx, xy[x] = gx * gy, yy[x] = gy * gy;
    }
  }
  return g;
}

// Each sample becomes the sum of the window around it; 0 where that is not all inside.
void sum_windows(Plane<float>& samples) {
  const int w = samples.width, h = samples.height;
  Plane<float> rows(w, h, 0);
  for (int y = 0; y < h; ++y) {
    const float* from = samples.row(y);
    float* to = rows.row(y);
    for (int i = -kCornerWindowRadius_px; i <= kCornerWindowRadius_px; ++i) {
      for (int x = kCornerWindowRadius_px; x + kCornerWindowRadius_px < w; ++x) to[x] += from[x + i];
    }
  }
  for (int y = 0; y < h; ++y) {
    float* to = samples.row(y);
    std::fill(to, to + w, 0.0F);
    if (y < kCornerWindowRadius_px || y + kCornerWindowRadius_px >= h) continue;
    for (int i = -kCornerWindowRadius_px; i <= kCornerWindowRadius_px; ++i) {
      const float* from = rows.row(y + i);
      for (int x = 0; x < w; ++x) to[x] += from[x];
    }
  }
}

Plane<float> corner_strengths(const GreyImage& picture) {
  Gradients g = gradient_products(picture);
  for (Plane<float>* sums : {&g.xx, &g.xy, &g.yy}) sum_windows(*sums);
  Plane<float> strength = std::move(g.xx);
  for (size_t i = 0; i < strength.samples.size(); ++i) {
    const float a = strength.samples[i], b = g.xy.samples[i], c = g.yy.samples[i], d = a - c;
    strength.samples[i] = 0.5F * (a + c - std::sqrt(d * d + 4 * b * b));
  }
  return strength;
}

// Of equals, the first in the order of rows.
bool is_local_maximum(const Plane<float>& strength, int x, int y) {
  const float here = strength.at(x, y);
  for (int v = -kCornerSuppressionRadius_px; v <= kCornerSuppressionRadius_px; ++v) {
    for (int u = -kCornerSuppressionRadius_px; u <= kCornerSuppressionRadius_px; ++u) {
      const float there = strength.at(x + u, y + v);
      if (there > here || (there == here && (v < 0 || (v == 0 && u < 0)))) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<Corner> find_corners(const GreyImage& picture, int margin) {
  const Plane<float> strength = corner_strengths(picture);
  const int border = std::max(margin, kCornerSuppressionRadius_px);
  std::vector<Corner> corners;
  for (int y = border; y + border < strength.height; ++y) {
    for (int x = border; x + border < strength.width; ++x) {
      const float s = strength.at(x, y);
      if (s > 0 && is_local_maximum(strength, x, y)) corners.push_back({s, x, y});
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& p, const Corner& q) { return p.strength > q.strength; });
  return corners;
}

}  // namespace ldp::sfm
