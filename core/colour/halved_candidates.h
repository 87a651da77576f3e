// The candidates of every second pixel each way: photographs are chosen for cells of 2 x 2 pixels, since the choice
// changes seldom, and every pixel then takes its cell's choice where that photograph sees it too.
#pragma once

#include "core/base/job.h"
#include "core/base/source_costs.h"
#include "core/base/source_map.h"
#include "core/colour/colour.h"

namespace ldp {

// A cell has the candidates of its first pixel that is present. `whole` must outlive it.
class HalvedCandidates final : public ColourCosts {
 public:
  explicit HalvedCandidates(const SourceCandidates& whole) : whole_(whole) {}
  int width() const override { return (whole_.width() + 1) / 2; }
  int height() const override { return (whole_.height() + 1) / 2; }
  bool wraps() const override { return whole_.wraps(); }
  int frames() const override { return whole_.frames(); }
  int candidates(int x, int y, uint16_t frame[16], uint16_t cost[16]) const override;
  uint8_t depth_label(int x, int y) const override;
  bool present(int x, int y) const override;

  // The choice of every pixel of the whole: its cell's if that photograph sees it, else its cheapest candidate.
  SourceMap spread(const SourceMap& choice, const Job& job) const;

 private:
  struct Pixel {
    int x, y;
  };
  Pixel pixel_of(int x, int y) const;

  const SourceCandidates& whole_;
};

}  // namespace ldp
