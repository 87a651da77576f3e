// Cost volumes for the solver's benchmark: the Middlebury MRF benchmark's stereo pairs and mirror-tiled mosaics of
// them.
#pragma once

#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/cost_source.h"
#include "core/solve/solve.h"

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
  std::vector<int> least;             // per pixel, by columns
  int64_t least_sum() const { return std::accumulate(least.begin(), least.end(), int64_t{0}); }

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

// The volume of the first layer of a capture folder with transforms.json.
Problem capture_problem(const std::string& folder);
void save_volume(const Volume& volume, const std::string& file);
Problem saved_problem(const std::string& file);

}  // namespace ldp
