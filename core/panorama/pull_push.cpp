#include "core/panorama/pull_push.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ldp {
namespace {

using Cells = Plane<WeightedColour>;

Cells pull(const Cells& fine) {
  Cells coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const WeightedColour& from = fine.at(x, y);
      WeightedColour& to = coarse.at(x / 2, y / 2);
      to.r += from.weight * from.r;
      to.g += from.weight * from.g;
      to.b += from.weight * from.b;
      to.weight += from.weight;
    }
  for (WeightedColour& c : coarse.samples) {
    if (c.weight <= 0) continue;
    c = {c.r / c.weight, c.g / c.weight, c.b / c.weight, std::min(1.0F, c.weight)};
  }
  return coarse;
}

// Bilinear sample of the coarse level at the centre of a fine cell.
WeightedColour sample(const Cells& coarse, int x, int y) {
  const int x0 = (x - 1) >> 1, y0 = (y - 1) >> 1;
  const float s = (x & 1) != 0 ? 0.25F : 0.75F, t = (y & 1) != 0 ? 0.25F : 0.75F;
  WeightedColour sum;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const WeightedColour& c =
          coarse.at(std::clamp(x0 + i, 0, coarse.width - 1), std::clamp(y0 + j, 0, coarse.height - 1));
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
      WeightedColour& c = fine.at(x, y);
      if (c.weight >= 1) continue;
      const WeightedColour from = sample(coarse, x, y);
      const float w = c.weight;
      c = {w * c.r + (1 - w) * from.r, w * c.g + (1 - w) * from.g, w * c.b + (1 - w) * from.b, 1};
    }
}

}  // namespace

Rgb rounded(const WeightedColour& colour) {
  const auto level = [](float mean) { return static_cast<uint8_t>(std::lround(mean)); };
  return {level(colour.r), level(colour.g), level(colour.b)};
}

void fill_by_pull_push(Plane<WeightedColour>& image) {
  std::vector<Cells> coarser;
  const auto finest = [&]() -> Cells& { return coarser.empty() ? image : coarser.back(); };
  while (finest().width > 1 || finest().height > 1) coarser.push_back(pull(finest()));
  if (finest().samples[0].weight <= 0) finest().samples[0] = {127, 127, 127, 1};
  for (size_t i = coarser.size(); i > 0; --i) push(coarser[i - 1], i > 1 ? coarser[i - 2] : image);
}

}  // namespace ldp
