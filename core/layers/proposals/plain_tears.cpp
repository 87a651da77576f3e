#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

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
constexpr int kPixelsAtOnce = 4096;

// Row by row, kNoDisparity where unknown: so squares of a map are looked at.
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
  Slopes(const PanoramaGrid& grid, const Plane<uint16_t>& greys, const Job& job, DisparityMap& layer)
      : grid_(grid),
        job_(job),
        layer_(layer),
        plain_(plain(grid, greys, kSlopePlainPx)),
        now_(layer.width, layer.height) {
    find_tears(plain(grid, greys, kTearPlainPx));
    spread();
    std::copy(layer.samples.begin(), layer.samples.end(), now_.samples.begin());
  }

  void settle() {
    std::vector<float> next(slope_.size());
    for (int round = 0; round < kSlopeRounds; ++round) {
      for_slope([&](size_t i) { next[i] = mean_of_sides(slope_[i]); });
      for_slope([&](size_t i) { now_.at(slope_[i].x, slope_[i].y) = next[i]; });
    }
    for (const Pixel& pixel : slope_)
      layer_.at(pixel.x, pixel.y) = static_cast<uint16_t>(std::lround(now_.at(pixel.x, pixel.y)));
  }

 private:
  struct Pixel {
    int x, y;
  };

  bool present(int x, int y) const { return layer_.contains(x, y) && layer_.at(x, y) != kNoDisparity; }
  bool may_slope(int x, int y) const { return present(x, y) && plain_.at(x, y); }

  // Both sides of steps with nothing to see around them.
  void find_tears(const Plane<uint8_t>& plain_around) {
    const double least = parallax_steps(grid_, kTearPx);
    for (int y = 0; y < layer_.height; ++y)
      for (int x = 0; x < layer_.width; ++x) {
        if (!present(x, y) || !plain_around.at(x, y)) continue;
        for (const auto& [right, down] : kHalfOfSides) {
          const int column = neighbour_column(grid_, x + right);
          if (!present(column, y + down) || !plain_around.at(column, y + down)) continue;
          if (std::abs(layer_.at(x, y) - layer_.at(column, y + down)) <= least) continue;
          slope_.push_back({x, y});
          slope_.push_back({column, y + down});
        }
      }
  }

  // From there through what is plain, so far: not across edges.
  void spread() {
    Plane<uint8_t> met(layer_.width, layer_.height, 0);
    const auto meet = [&](int x, int y, std::vector<Pixel>& pixels) {
      if (may_slope(x, y) && !std::exchange(met.at(x, y), uint8_t{1})) pixels.push_back({x, y});
    };
    std::vector<Pixel> border, next;
    for (const Pixel& pixel : std::exchange(slope_, {})) meet(pixel.x, pixel.y, border);
    for (int px = 0; px < kSlopePx && !border.empty(); ++px) {
      next.clear();
      for (const Pixel& pixel : border)
        for (const auto& [right, down] : kSides) meet(neighbour_column(grid_, pixel.x + right), pixel.y + down, next);
      slope_.insert(slope_.end(), border.begin(), border.end());
      border.swap(next);
    }
  }

  template <typename Use>
  void for_slope(const Use& use) const {
    const int count = static_cast<int>(slope_.size());
    parallel_for(job_, (count + kPixelsAtOnce - 1) / kPixelsAtOnce, [&](int part) {
      for (int i = part * kPixelsAtOnce; i < std::min(count, (part + 1) * kPixelsAtOnce); ++i)
        use(static_cast<size_t>(i));
    });
  }

  // Of those that are plain: what has an edge may be another surface.
  float mean_of_sides(const Pixel& pixel) const {
    float sum = 0, count = 0;
    for (const auto& [right, down] : kSides) {
      const int column = neighbour_column(grid_, pixel.x + right), y = pixel.y + down;
      if (!may_slope(column, y)) continue;
      sum += now_.at(column, y);
      count += 1;
    }
    return count > 0 ? sum / count : now_.at(pixel.x, pixel.y);
  }

  const PanoramaGrid& grid_;
  const Job& job_;
  DisparityMap& layer_;
  Plane<uint8_t> plain_;      // where a slope may be
  std::vector<Pixel> slope_;  // each once
  Plane<float> now_;          // disparity
};

}  // namespace

void close_plain_tears(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Job& job,
                       DisparityMap& layer) {
  const Plane<uint16_t> greys = row_by_row(front_greys(grid, frames, layer, job));
  Slopes(grid, greys, job, layer).settle();
}

}  // namespace ldp
