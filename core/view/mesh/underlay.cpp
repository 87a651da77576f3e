#include "core/view/mesh/underlay.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

struct Step {
  uint32_t to, from;
};

struct Grown {
  float w;
  Rgba colour;
  uint16_t code;
  uint8_t step;
};

void copy(const PreparedLayer& source, size_t from, PreparedLayer& target, size_t to) {
  target.w.samples[to] = source.w.samples[from];
  target.code.samples[to] = source.code.samples[from];
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
  Grower(PreparedLayer deepest, const CodedDepths& depths, bool wraps, float parallax)
      : deepest_(std::move(deepest)),
        depths_(depths),
        wraps_(wraps),
        parallax_(parallax),
        columns_(wraps ? deepest_.w.width - 1 : deepest_.w.width),
        asked_in_(deepest_.w.width, deepest_.w.height, 0),
        grown_(deepest_.w.width, deepest_.w.height, 0) {}

  PreparedLayer grow() {
    std::vector<Step> steps = steps_everywhere();
    for (int i = 1; i <= kReachPx; ++i) {
      take(steps);
      steps = steps_at(around(steps, static_cast<uint8_t>(i)));
    }
    for (size_t i = 0; i < deepest_.w.samples.size(); ++i) {
      if (grown_.samples[i]) continue;
      deepest_.w.samples[i] = kAbsent;
      deepest_.code.samples[i] = kNoDisparity;
    }
    return std::move(deepest_);
  }

 private:
  // All from the same state.
  void take(const std::vector<Step>& steps) {
    std::vector<Grown> grown;
    grown.reserve(steps.size());
    for (const Step& s : steps)
      grown.push_back({deepest_.w.samples[s.from], deepest_.colour.samples[s.from], deepest_.code.samples[s.from],
                       deepest_.step.samples[s.from]});
    for (size_t i = 0; i < steps.size(); ++i) {
      const size_t to = steps[i].to;
      deepest_.w.samples[to] = grown[i].w;
      deepest_.colour.samples[to] = grown[i].colour;
      deepest_.code.samples[to] = grown[i].code;
      deepest_.step.samples[to] = grown[i].step;
      grown_.samples[to] = 1;
    }
  }

  std::vector<Step> steps_everywhere() const {
    std::vector<Step> steps;
    for (int y = 0; y < deepest_.w.height; ++y)
      for (int x = 0; x < columns_; ++x) add_step(static_cast<uint32_t>(deepest_.w.index(x, y)), steps);
    return steps;
  }

  // Of the pixels asked those beside a deeper surface, and the pixel of it that goes on there.
  std::vector<Step> steps_at(const std::vector<uint32_t>& asked) const {
    std::vector<Step> steps;
    for (const uint32_t pixel : asked) add_step(pixel, steps);
    return steps;
  }
  void add_step(uint32_t pixel, std::vector<Step>& steps) const {
    const uint32_t from = deeper_neighbour(pixel);
    if (from != pixel) steps.push_back({pixel, from});
  }

  // What changed and its neighbours, each once: nowhere else is there anything new.
  std::vector<uint32_t> around(const std::vector<Step>& steps, uint8_t round) {
    std::vector<uint32_t> pixels;
    const auto add = [&](uint32_t pixel) {
      if (std::exchange(asked_in_.samples[pixel], round) != round) pixels.push_back(pixel);
    };
    for (const Step& s : steps) {
      add(s.to);
      for_neighbours(s.to, add);
    }
    return pixels;
  }

  template <typename Use>
  void for_neighbours(uint32_t pixel, Use use) const {
    constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    const Plane<float>& w = deepest_.w;
    const auto width = static_cast<size_t>(w.width);
    const int x = static_cast<int>(pixel % width), y = static_cast<int>(pixel / width);
    for (const auto& [dx, dy] : kNeighbours) {
      const int nx = wraps_ ? (x + dx + columns_) % columns_ : x + dx;
      if (w.contains(nx, y + dy)) use(static_cast<uint32_t>(w.index(nx, y + dy)));
    }
  }

  // The pixel itself when there is none.
  uint32_t deeper_neighbour(uint32_t own) const {
    const Plane<float>& w = deepest_.w;
    uint32_t best = own;
    for_neighbours(own, [&](uint32_t n) {
      if (w.samples[n] >= 0 && w.samples[n] < w.samples[best] && !same_surface(own, n)) best = n;
    });
    return best;
  }

  bool same_surface(size_t a, size_t b) const {
    const auto w = [&](size_t i) { return depths_.w(deepest_.code.samples[i]); };
    const auto step = [&](size_t i) { return depths_.step(deepest_.step.samples[i]); };
    return connected(w(a), step(a), w(b), step(b), parallax_);
  }

  PreparedLayer deepest_;
  const CodedDepths& depths_;
  bool wraps_;
  float parallax_;
  int columns_;  // without the repeated one
  Plane<uint8_t> asked_in_, grown_;
};

}  // namespace

PreparedLayer make_underlay(const std::vector<PreparedLayer>& layers, const CodedDepths& depths, bool wraps,
                            float parallax) {
  return Grower(deepest_of(layers), depths, wraps, parallax).grow();
}

}  // namespace ldp::view
