#include "underlay.h"

#include <algorithm>
#include <array>
#include <utility>

namespace ldp::render {
namespace {

constexpr int kReachPx = 5;

struct Step {
  size_t to, from;
};

void copy(const PreparedLayer& source, size_t from, PreparedLayer& target, size_t to) {
  target.mesh.w.samples[to] = source.mesh.w.samples[from];
  target.code_w.samples[to] = source.code_w.samples[from];
  target.mesh.colour.samples[to] = source.mesh.colour.samples[from];
  target.step.samples[to] = source.step.samples[from];
}

PreparedLayer deepest_of(const std::vector<PreparedLayer>& layers) {
  PreparedLayer deepest = layers[0];
  for (size_t k = 1; k < layers.size(); ++k)
    for (size_t i = 0; i < deepest.mesh.w.samples.size(); ++i) {
      const float w = layers[k].mesh.w.samples[i], so_far = deepest.mesh.w.samples[i];
      if (w >= 0 && (so_far < 0 || w < so_far)) copy(layers[k], i, deepest, i);
    }
  return deepest;
}

class Grower {
 public:
  Grower(PreparedLayer deepest, bool wraps, float parallax)
      : deepest_(std::move(deepest)), wraps_(wraps), parallax_(parallax) {}

  PreparedLayer grow() {
    PreparedLayer underlay = deepest_;
    std::fill(underlay.mesh.w.samples.begin(), underlay.mesh.w.samples.end(), kAbsent);
    std::fill(underlay.code_w.samples.begin(), underlay.code_w.samples.end(), kAbsent);
    for (int i = 0; i < kReachPx; ++i) {
      const std::vector<Step> steps = one_pixel_on();
      for (const Step& s : steps) copy(deepest_, s.from, underlay, s.to);
      for (const Step& s : steps) copy(underlay, s.to, deepest_, s.to);
    }
    return underlay;
  }

 private:
  // Pixels beside a deeper surface, and the pixel of it that goes on there.
  std::vector<Step> one_pixel_on() const {
    const Plane<float>& w = deepest_.mesh.w;
    const int columns = wraps_ ? w.width - 1 : w.width;
    std::vector<Step> steps;
    for (int y = 0; y < w.height; ++y)
      for (int x = 0; x < columns; ++x) {
        const size_t own = w.index(x, y), from = deeper_neighbour(x, y, columns);
        if (from == own) continue;
        steps.push_back({own, from});
      }
    return steps;
  }

  // The pixel itself when there is none.
  size_t deeper_neighbour(int x, int y, int columns) const {
    constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    const Plane<float>& w = deepest_.mesh.w;
    const size_t own = w.index(x, y);
    size_t best = own;
    for (const auto& [dx, dy] : kNeighbours) {
      const int nx = wraps_ ? (x + dx + columns) % columns : x + dx;
      if (!w.contains(nx, y + dy)) continue;
      const size_t n = w.index(nx, y + dy);
      if (w.samples[n] >= 0 && w.samples[n] < w.samples[best] && !same_surface(own, n)) best = n;
    }
    return best;
  }

  bool same_surface(size_t a, size_t b) const {
    const auto& w = deepest_.code_w.samples;
    const auto& step = deepest_.step.samples;
    return connected(w[a], step[a], w[b], step[b], parallax_);
  }

  PreparedLayer deepest_;
  bool wraps_;
  float parallax_;
};

}  // namespace

PreparedLayer make_underlay(const std::vector<PreparedLayer>& layers, bool wraps, float parallax) {
  return Grower(deepest_of(layers), wraps, parallax).grow();
}

}  // namespace ldp::render
