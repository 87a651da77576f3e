#include "core/view/mesh/underlay.h"

#include <algorithm>
#include <array>
#include <cstddef>
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
  Grower(PreparedLayer deepest, const CodedDepths& depths, float parallax)
      : deepest_(std::move(deepest)),
        depths_(depths),
        parallax_(parallax),
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
    const Plane<float>& w = deepest_.w;
    std::vector<uint8_t> asked(static_cast<size_t>(w.width));
    for (int y = 0; y < w.height; ++y) {
      find_beside_deeper(w.row(y), w.row(std::max(0, y - 1)), w.row(std::min(w.height - 1, y + 1)), asked);
      for (int x = 0; x < w.width; ++x)
        if (asked[static_cast<size_t>(x)]) add_step(x, y, steps);
    }
    return steps;
  }

  // Which pixels of a row may have a deeper neighbour. Without branches, for vectors.
  void find_beside_deeper(const float* own, const float* above, const float* below, std::vector<uint8_t>& found) const {
    const size_t last = found.size() - 1;
    const auto deeper = [&](float there, float here) { return (there >= 0) & (there < here - parallax_); };
    for (size_t x = 0; x <= last; ++x)
      found[x] = static_cast<uint8_t>(deeper(above[x], own[x]) | deeper(below[x], own[x]));
    for (size_t x = 0; x < last; ++x) found[x] = static_cast<uint8_t>(found[x] | deeper(own[x + 1], own[x]));
    for (size_t x = 1; x <= last; ++x) found[x] = static_cast<uint8_t>(found[x] | deeper(own[x - 1], own[x]));
  }

  // Of the pixels asked those beside a deeper surface, and the pixel of it that goes on there.
  std::vector<Step> steps_at(const std::vector<uint32_t>& asked) const {
    std::vector<Step> steps;
    for (const uint32_t pixel : asked) add_step(column(pixel), row(pixel), steps);
    return steps;
  }
  void add_step(int x, int y, std::vector<Step>& steps) const {
    const auto pixel = static_cast<uint32_t>(deepest_.w.index(x, y));
    const uint32_t from = deeper_neighbour(x, y);
    if (from != pixel) steps.push_back({pixel, from});
  }
  int column(uint32_t pixel) const { return static_cast<int>(pixel % static_cast<uint32_t>(deepest_.w.width)); }
  int row(uint32_t pixel) const { return static_cast<int>(pixel / static_cast<uint32_t>(deepest_.w.width)); }

  // What changed and its neighbours, each once: nowhere else is there anything new.
  std::vector<uint32_t> around(const std::vector<Step>& steps, uint8_t round) {
    std::vector<uint32_t> pixels;
    const auto add = [&](uint32_t pixel) {
      if (std::exchange(asked_in_.samples[pixel], round) != round) pixels.push_back(pixel);
    };
    for (const Step& s : steps) {
      add(s.to);
      for_neighbours(column(s.to), row(s.to), add);
    }
    return pixels;
  }

  template <typename Use>
  void for_neighbours(int x, int y, Use use) const {
    constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    const Plane<float>& w = deepest_.w;
    for (const auto& [dx, dy] : kNeighbours) {
      if (w.contains(x + dx, y + dy)) use(static_cast<uint32_t>(w.index(x + dx, y + dy)));
    }
  }

  // The pixel itself when there is none. (Smoothing moves depths within what codes leave unknown, so that what is no
  // farther than the slack of a slant is of its surface.)
  uint32_t deeper_neighbour(int x, int y) const {
    const Plane<float>& w = deepest_.w;
    const auto own = static_cast<uint32_t>(w.index(x, y));
    const float deeper = w.samples[own] - parallax_;
    uint32_t best = own;
    for_neighbours(x, y, [&](uint32_t n) {
      const float there = w.samples[n];
      if (there >= 0 && there < deeper && there < w.samples[best] && !same_surface(own, n)) best = n;
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
  float parallax_;
  Plane<uint8_t> asked_in_, grown_;
};

}  // namespace

PreparedLayer make_underlay(const std::vector<PreparedLayer>& layers, const CodedDepths& depths, float parallax) {
  return Grower(deepest_of(layers), depths, parallax).grow();
}

}  // namespace ldp::view
