#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

// The parts of a layer that hang together by sides, one after the other: pixels side by side are of one part while
// their disparities differ by at most `apart`.
class Components {
 public:
  Components(const DisparityMap& layer, bool wraps, int apart)
      : layer_(layer), wraps_(wraps), apart_(apart), visited_(layer.width, layer.height, 0) {}

  // Of the pixel, which no part so far holds. Valid until the next.
  const std::vector<size_t>& part(size_t seed) {
    found_.clear();
    border_.clear();
    visit(seed);
    for (size_t next = 0; next < found_.size(); ++next) {
      const auto width = static_cast<size_t>(layer_.width);
      const int x = static_cast<int>(found_[next] % width), y = static_cast<int>(found_[next] / width);
      constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
      for (const auto& [dx, dy] : kNeighbours) {
        const int nx = wraps_ ? (x + dx + layer_.width) % layer_.width : x + dx;
        if (layer_.contains(nx, y + dy)) meet(layer_.index(nx, y + dy), layer_.samples[found_[next]]);
      }
    }
    return found_;
  }
  // The disparities that the part stood beside, as often as it did.
  std::vector<uint16_t>& border() { return border_; }
  bool waits(size_t pixel) const { return layer_.samples[pixel] != kNoDisparity && visited_.samples[pixel] == 0; }

 private:
  void meet(size_t pixel, int disparity) {
    const uint16_t other = layer_.samples[pixel];
    if (other == kNoDisparity) return;
    if (std::abs(other - disparity) > apart_)
      border_.push_back(other);
    else if (waits(pixel))
      visit(pixel);
  }
  void visit(size_t pixel) {
    visited_.samples[pixel] = 1;
    found_.push_back(pixel);
  }

  const DisparityMap& layer_;
  bool wraps_;
  int apart_;
  Plane<uint8_t> visited_;
  std::vector<size_t> found_;
  std::vector<uint16_t> border_;
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

void drop_small_components(int least, bool wraps, DisparityMap& layer, int apart) {
  Components components(layer, wraps, apart);
  std::vector<size_t> small;
  for (size_t i = 0; i < layer.samples.size(); ++i) {
    if (!components.waits(i)) continue;
    const std::vector<size_t>& part = components.part(i);
    if (part.size() < static_cast<size_t>(least)) small.insert(small.end(), part.begin(), part.end());
  }
  for (const size_t i : small) layer.samples[i] = kNoDisparity;
}

void absorb_specks(const PanoramaGrid& grid, int least, DisparityMap& layer) {
  const DisparityMap before = layer;
  Components components(before, grid.wraps, static_cast<int>(parallax_steps(grid, tuning::kFusionApartPx)));
  for (size_t i = 0; i < before.samples.size(); ++i) {
    if (!components.waits(i)) continue;
    const std::vector<size_t>& part = components.part(i);
    std::vector<uint16_t>& border = components.border();
    if (part.size() >= static_cast<size_t>(least) || border.empty()) continue;
    const auto middle = border.begin() + static_cast<std::ptrdiff_t>(border.size() / 2);
    std::nth_element(border.begin(), middle, border.end());
    for (const size_t pixel : part) layer.samples[pixel] = *middle;
  }
}

}  // namespace ldp
