// Wires before the sky are darker than what is around them, and gaps between leaves lighter, or the other way round:
// what is alike in that is mostly of one surface.
#include <cstdlib>
#include <vector>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"
#include "core/layers/proposals/front_greys.h"

namespace ldp {
namespace {

using namespace layers;

// Sum and number of what is known.
struct Known {
  int sum = 0, count = 0;
  void add(int grey, int times) {
    if (grey == kUnknownGrey) return;
    sum += times * grey;
    count += times;
  }
};

}  // namespace

Plane<Lightness> lightness(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const DisparityMap& layer,
                           int reach_px, const Job& job) {
  const Plane<int16_t> greys = front_greys(grid, frames, layer, job);
  Plane<Lightness> found(layer.width, layer.height, Lightness::as_around);
  parallel_for(job, layer.width, [&](int x) {
    std::vector<Known> rows(static_cast<size_t>(layer.height));
    for (int beside = x - reach_px; beside <= x + reach_px; ++beside) {
      const int column = neighbour_column(grid, beside);
      for (int y = 0; column >= 0 && y < layer.height; ++y) rows[static_cast<size_t>(y)].add(greys.row(column)[y], 1);
    }
    Known square;
    const auto add = [&](int y, int times) {
      if (y < 0 || y >= layer.height) return;
      square.sum += times * rows[static_cast<size_t>(y)].sum;
      square.count += times * rows[static_cast<size_t>(y)].count;
    };
    for (int y = 0; y < reach_px; ++y) add(y, 1);
    for (int y = 0; y < layer.height; ++y) {
      add(y + reach_px, 1);
      add(y - reach_px - 1, -1);
      const int own = greys.row(x)[y];
      if (own == kUnknownGrey) continue;
      const int differs = own * square.count - square.sum, enough = tuning::kLightnessDiffers * square.count;
      if (std::abs(differs) > enough) found.at(x, y) = differs > 0 ? Lightness::lighter : Lightness::darker;
    }
  });
  return found;
}

}  // namespace ldp
