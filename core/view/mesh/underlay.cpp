#include "core/view/mesh/underlay.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace ldp::render {
namespace {

constexpr int kReachPx = 20;

struct Step {
  size_t to, from;
};

void copy(const PreparedLayer& source, size_t from, PreparedLayer& target, size_t to) {
  target.w.samples[to] = source.w.samples[from];
  target.code_w.samples[to] = source.code_w.samples[from];
  target.colour.samples[to] = source.colour.samples[from];
  target.step.samples[to] = source.step.samples[from];
}

PreparedLayer deepest_of(const std::vector<PreparedLayer>& layers) {
  PreparedLayer deepest = layers[0];
  for (size_t k = 1; k < layers.size(); ++k)
    for (size_t i = 0; i < deepest.w.samples.size(); ++i) {
      const float w = layers[k].w.samples[i], so_far = deepest.w.samples[i];
      if (w >= 0 && (so_far < 0 || w < so_far)) copy(layers[k], i, deepest, i);
    }
  return deepest;
}

class Grower {
 public:
  Grower(PreparedLayer deepest, bool wraps, float parallax)
      : deepest_(std::move(deepest)),
        wraps_(wraps),
        parallax_(parallax),
        columns_(wraps ? deepest_.w.width - 1 : deepest_.w.width),
        asked_in_(deepest_.w.width, deepest_.w.height, 0) {}

  PreparedLayer grow() {
    PreparedLayer underlay = deepest_;
    std::fill(underlay.w.samples.begin(), underlay.w.samples.end(), kAbsent);
    std::fill(underlay.code_w.samples.begin(), underlay.code_w.samples.end(), kAbsent);
    std::vector<size_t> asked = all_pixels();
    for (int i = 1; i <= kReachPx; ++i) {
      const std::vector<Step> steps = steps_at(asked);
      for (const Step& s : steps) copy(deepest_, s.from, underlay, s.to);
      for (const Step& s : steps) copy(underlay, s.to, deepest_, s.to);
      asked = around(steps, static_cast<uint8_t>(i));
    }
    return underlay;
  }

 private:
  std::vector<size_t> all_pixels() const {
    std::vector<size_t> pixels;
    pixels.reserve(deepest_.w.samples.size());
    for (int y = 0; y < deepest_.w.height; ++y)
      for (int x = 0; x < columns_; ++x) pixels.push_back(deepest_.w.index(x, y));
    return pixels;
  }

  // Of the pixels asked those beside a deeper surface, and the pixel of it that goes on there.
  std::vector<Step> steps_at(const std::vector<size_t>& asked) const {
    std::vector<Step> steps;
    for (const size_t pixel : asked) {
      const size_t from = deeper_neighbour(pixel);
      if (from != pixel) steps.push_back({pixel, from});
    }
    return steps;
  }

  // What changed and its neighbours, each once: nowhere else is there anything new.
  std::vector<size_t> around(const std::vector<Step>& steps, uint8_t round) {
    std::vector<size_t> pixels;
    const auto add = [&](size_t pixel) {
      if (std::exchange(asked_in_.samples[pixel], round) != round) pixels.push_back(pixel);
    };
    for (const Step& s : steps) {
      add(s.to);
      for_neighbours(s.to, add);
    }
    return pixels;
  }

  template <typename Use>
  void for_neighbours(size_t pixel, Use use) const {
    constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    const Plane<float>& w = deepest_.w;
    const auto width = static_cast<size_t>(w.width);
    const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
    for (const auto& [dx, dy] : kNeighbours) {
      const int nx = wraps_ ? (x + dx + columns_) % columns_ : x + dx;
      if (w.contains(nx, y + dy)) use(w.index(nx, y + dy));
    }
  }

  // The pixel itself when there is none.
  size_t deeper_neighbour(size_t own) const {
    const Plane<float>& w = deepest_.w;
    size_t best = own;
    for_neighbours(own, [&](size_t n) {
      if (w.samples[n] >= 0 && w.samples[n] < w.samples[best] && !same_surface(own, n)) best = n;
    });
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
  int columns_;  // without the repeated one
  Plane<uint8_t> asked_in_;
};

}  // namespace

PreparedLayer make_underlay(const std::vector<PreparedLayer>& layers, bool wraps, float parallax) {
  return Grower(deepest_of(layers), wraps, parallax).grow();
}

}  // namespace ldp::render
