#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"
#include "core/layers/proposals/front_greys.h"
#include "core/layers/simpler_maps.h"

namespace ldp {
namespace {

using namespace layers;
using namespace tuning;

// Right and down, and all four.
constexpr std::pair<int, int> kHalfOfSides[] = {{1, 0}, {0, 1}}, kSides[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

// Row by row, absent as in a disparity map, of which squares are looked at.
Plane<uint16_t> row_by_row(const Plane<int16_t>& greys) {
  Plane<uint16_t> rows(greys.height, greys.width);
  for (int x = 0; x < rows.width; ++x)
    for (int y = 0; y < rows.height; ++y) {
      const int16_t grey = greys.row(x)[y];
      rows.at(x, y) = grey == kUnknownGrey ? kNoDisparity : static_cast<uint16_t>(grey);
    }
  return rows;
}

// 1 where what is known of the square that reaches so far is of nearly one grey.
Plane<uint8_t> plain(const PanoramaGrid& grid, const Plane<uint16_t>& greys, int reach_px) {
  const Plane<uint16_t> darkest = farthest_around(grid, greys, reach_px),
                        brightest = nearest_around(grid, greys, reach_px);
  Plane<uint8_t> found(greys.width, greys.height);
  for (size_t i = 0; i < found.samples.size(); ++i)
    found.samples[i] =
        darkest.samples[i] != kNoDisparity && brightest.samples[i] - darkest.samples[i] <= kPlainTearContrast;
  return found;
}

// A layer whose plain parts are drawn smooth beside tears.
class Slopes {
 public:
  Slopes(const PanoramaGrid& grid, const Plane<uint16_t>& greys, const DisparityMap& layer, const Job& job)
      : grid_(grid),
        layer_(layer),
        job_(job),
        plain_(plain(grid, greys, kSlopePlainPx)),
        slope_(beside(tears(plain(grid, greys, kTearPlainPx)))),
        now_(layer.width, layer.height),
        next_(layer.width, layer.height) {
    std::copy(layer.samples.begin(), layer.samples.end(), now_.samples.begin());
    next_ = now_;
  }

  DisparityMap settled() {
    for (int round = 0; round < kSlopeRounds; ++round) {
      parallel_for(job_, layer_.height, [&](int y) {
        for (int x = 0; x < layer_.width; ++x)
          if (slope_.at(x, y)) next_.at(x, y) = mean_of_sides(x, y);
      });
      std::swap(now_, next_);
    }
    DisparityMap result = layer_;
    for (size_t i = 0; i < result.samples.size(); ++i)
      if (slope_.samples[i]) result.samples[i] = static_cast<uint16_t>(now_.samples[i] + 0.5F);
    return result;
  }

 private:
  bool present(int x, int y) const { return layer_.contains(x, y) && layer_.at(x, y) != kNoDisparity; }

  // 1 on both sides of a step with nothing to see around it.
  Plane<uint16_t> tears(const Plane<uint8_t>& wide) const {
    const double least = parallax_steps(grid_, kTearPx);
    Plane<uint16_t> found(layer_.width, layer_.height, 0);
    for (int y = 0; y < layer_.height; ++y)
      for (int x = 0; x < layer_.width; ++x) {
        if (!wide.at(x, y) || !present(x, y)) continue;
        for (const auto& [right, down] : kHalfOfSides) {
          const int column = neighbour_column(grid_, x + right);
          if (!present(column, y + down)) continue;
          if (std::abs(layer_.at(x, y) - layer_.at(column, y + down)) > least)
            found.at(x, y) = found.at(column, y + down) = 1;
        }
      }
    return found;
  }

  // 1 where a slope may be: in plain parts around tears.
  Plane<uint8_t> beside(const Plane<uint16_t>& tears) const {
    const Plane<uint16_t> around = nearest_around(grid_, tears, kSlopePx);
    Plane<uint8_t> found(layer_.width, layer_.height, 0);
    for (int y = 0; y < layer_.height; ++y)
      for (int x = 0; x < layer_.width; ++x) found.at(x, y) = around.at(x, y) != 0 && plain_.at(x, y) && present(x, y);
    return found;
  }

  // Of those that are plain: what has an edge may be another surface.
  float mean_of_sides(int x, int y) const {
    float sum = 0, count = 0;
    for (const auto& [right, down] : kSides) {
      const int column = neighbour_column(grid_, x + right);
      if (!present(column, y + down) || !plain_.at(column, y + down)) continue;
      sum += now_.at(column, y + down);
      count += 1;
    }
    return count > 0 ? sum / count : now_.at(x, y);
  }

  const PanoramaGrid& grid_;
  const DisparityMap& layer_;
  const Job& job_;
  Plane<uint8_t> plain_, slope_;
  Plane<float> now_, next_;  // disparity
};

}  // namespace

void close_plain_tears(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Job& job,
                       DisparityMap& layer) {
  const Plane<uint16_t> greys = row_by_row(front_greys(grid, frames, layer, job));
  layer = Slopes(grid, greys, layer, job).settled();
}

}  // namespace ldp
