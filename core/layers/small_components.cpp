#include <array>
#include <cstdint>
#include <vector>

#include "core/layers/layers.h"

namespace ldp::layers {
namespace {

// The parts of a layer that hang together by sides, one after the other.
class Components {
 public:
  Components(const DisparityMap& layer, bool wraps)
      : layer_(layer), wraps_(wraps), visited_(layer.width, layer.height, 0) {}

  // Of the pixel, which no part so far holds. Valid until the next.
  const std::vector<size_t>& part(size_t seed) {
    found_.clear();
    visit(seed);
    for (size_t next = 0; next < found_.size(); ++next) {
      const auto width = static_cast<size_t>(layer_.width);
      const int x = static_cast<int>(found_[next] % width), y = static_cast<int>(found_[next] / width);
      constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
      for (const auto& [dx, dy] : kNeighbours) {
        const int nx = wraps_ ? (x + dx + layer_.width) % layer_.width : x + dx;
        if (layer_.contains(nx, y + dy)) visit(layer_.index(nx, y + dy));
      }
    }
    return found_;
  }
  bool waits(size_t pixel) const { return layer_.samples[pixel] != kNoDisparity && visited_.samples[pixel] == 0; }

 private:
  void visit(size_t pixel) {
    if (!waits(pixel)) return;
    visited_.samples[pixel] = 1;
    found_.push_back(pixel);
  }

  const DisparityMap& layer_;
  bool wraps_;
  Plane<uint8_t> visited_;
  std::vector<size_t> found_;
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

void drop_small_components(int least, bool wraps, DisparityMap& layer) {
  Components components(layer, wraps);
  std::vector<size_t> small;
  for (size_t i = 0; i < layer.samples.size(); ++i) {
    if (!components.waits(i)) continue;
    const std::vector<size_t>& part = components.part(i);
    if (part.size() < static_cast<size_t>(least)) small.insert(small.end(), part.begin(), part.end());
  }
  for (const size_t i : small) layer.samples[i] = kNoDisparity;
}

}  // namespace ldp
