// Cost volumes for the solver's benchmark: the Middlebury MRF benchmark's stereo pairs and mirror-tiled mosaics of
// them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cost_source.h"
#include "solve.h"

namespace ldp {

// A whole volume in memory. Costs are 8 bit above the pixel's least cost, which is kept aside; what exceeds 255 is cut
// there, which no good labelling notices.
class Volume final : public CostSource {
 public:
  Volume(int width, int height, int labels, bool wraps);
  int width() const override { return width_; }
  int height() const override { return height_; }
  int labels() const override { return labels_; }
  bool wraps() const override { return wraps_; }
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override;
  size_t index(int x, int y) const {
    return (static_cast<size_t>(x) * static_cast<size_t>(height_) + static_cast<size_t>(y)) *
           static_cast<size_t>(labels_);
  }

  std::vector<uint8_t> cost, median;  // the source's layout; an empty median stands for zeros
  int64_t least_sum = 0;

 private:
  int width_, height_, labels_;
  bool wraps_;
};

struct Problem {
  std::string name;
  Volume volume;
  EdgeFactors factors;  // empty: all 1
  SolveOptions options;
  double unit = 1;  // grey levels per unit of the energies printed
};

Problem tsukuba();
Problem teddy16();
Problem mirror_tiled(const Problem& problem, int width, int height);

}  // namespace ldp
