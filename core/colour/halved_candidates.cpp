#include "core/colour/halved_candidates.h"

#include <algorithm>

namespace ldp {

HalvedCandidates::Pixel HalvedCandidates::pixel_of(int x, int y) const {
  const int right = std::min(2 * x + 1, whole_.width() - 1), below = std::min(2 * y + 1, whole_.height() - 1);
  for (const Pixel p : {Pixel{2 * x, 2 * y}, {right, below}, {right, 2 * y}, {2 * x, below}})
    if (whole_.present(p.x, p.y)) return p;
  return {2 * x, 2 * y};
}

int HalvedCandidates::candidates(int x, int y, uint16_t frame[16], uint16_t cost[16]) const {
  const Pixel p = pixel_of(x, y);
  return whole_.candidates(p.x, p.y, frame, cost);
}

uint8_t HalvedCandidates::depth_label(int x, int y) const {
  const Pixel p = pixel_of(x, y);
  return whole_.depth_label(p.x, p.y);
}

bool HalvedCandidates::present(int x, int y) const {
  const Pixel p = pixel_of(x, y);
  return whole_.present(p.x, p.y);
}

SourceMap HalvedCandidates::spread(const SourceMap& choice, const Job& job) const {
  SourceMap sources(whole_.width(), whole_.height(), whole_.frames());
  parallel_for(job, whole_.height(), [&](int y) {
    for (int x = 0; x < whole_.width(); ++x) {
      if (!whole_.present(x, y)) continue;
      const int chosen = choice.at(x / 2, y / 2);
      sources.set(x, y, chosen != kNoSource && whole_.sees(chosen, x, y) ? chosen : whole_.cheapest(x, y));
    }
  });
  return sources;
}

}  // namespace ldp
