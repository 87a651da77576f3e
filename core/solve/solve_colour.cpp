#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/smoothness.h"
#include "core/solve/solve.h"
#include "core/solve/windows.h"

namespace ldp::solve {
namespace {

constexpr int kAnglesPerDegree = 64;
constexpr uint8_t kNoFrame = 255;  // where there is no candidate
constexpr int kSixteenths = 16;    // energy units are given in sixteenths per cost step

// A frame's slot is its index modulo 16, its position the index modulo 256.
class ColourSource final : public GridSource {
 public:
  ColourSource(const ColourCosts& costs, int units_in_sixteenths) : costs_(costs), units_(units_in_sixteenths) {}
  int width() const override { return costs_.width(); }
  int height() const override { return costs_.height(); }
  bool wraps() const override { return costs_.wraps(); }
  int slots() const override { return std::min(costs_.frames(), kSlots); }
  bool has_positions() const override { return true; }

  int edge_factor(int, int, bool) const override { return 1; }

  void load(const Window& window, PixelTerms& terms, int first) const override {
    for (int x = 0; x < window.width; ++x)
      for (int y = 0; y < window.height; ++y)
        load_pixel((window.x + x) % costs_.width(), window.y + y, first + x * terms.height + y, terms);
  }

 private:
  static constexpr int kCeiling = 4096;  // above the pixel's least cost; no such slot is in a best labelling

  void load_pixel(int gx, int gy, int p, PixelTerms& terms) const {
    uint16_t frame[kSlots];
    uint16_t angle[kSlots];
    const auto pixel = static_cast<size_t>(p);
    uint16_t* cost = terms.cost.data() + pixel * kSlots;
    uint8_t* position = terms.position.data() + pixel * kSlots;
    const int count = costs_.present(gx, gy) ? costs_.candidates(gx, gy, frame, angle) : 0;
    std::fill_n(terms.grey.begin() + static_cast<ptrdiff_t>(pixel * kSlots), kSlots, costs_.depth_label(gx, gy));
    std::fill_n(cost, kSlots, count > 0 ? kForbidden : uint16_t{0});
    std::fill_n(position, kSlots, kNoFrame);
    terms.solved[pixel] = count > 0;
    terms.floor[pixel] = 0;
    if (count == 0) return;
    for (int slot = 0; slot < kSlots; ++slot) position[slot] = static_cast<uint8_t>(slot);
    const int least = *std::min_element(angle, angle + count);
    terms.floor[pixel] = static_cast<uint16_t>(in_units(least));
    for (int i = 0; i < count; ++i) {
      const int slot = frame[i] % kSlots;
      const int above = std::min(in_units(angle[i] - least), kCeiling);
      if (above >= cost[slot]) continue;
      cost[slot] = static_cast<uint16_t>(above);
      position[slot] = static_cast<uint8_t>(frame[i]);
    }
  }
  int in_units(int angle) const { return (angle * units_ + kSixteenths / 2) / kSixteenths; }

  const ColourCosts& costs_;
  int units_;
};

int units_in_sixteenths(const ColourSolveOptions& options) {
  const double widest = options.lambda * kAnglesPerDegree * options.truncation;
  if (!(options.lambda > 0) || options.truncation < 1 || options.truncation > 15 || widest > kWidestPair * kSixteenths)
    throw std::logic_error("solve_colour: lambda * truncation must lie in 0 .. 62 degrees, truncation in 1 .. 15");
  return std::clamp(static_cast<int>(kWidestPair * kSixteenths / widest), 1, 256);
}

// The cheapest candidate at that position, kNoSource where there is none.
int source_at(const ColourCosts& costs, int x, int y, uint8_t position) {
  uint16_t frame[kSlots];
  uint16_t cost[kSlots];
  const int count = costs.present(x, y) ? costs.candidates(x, y, frame, cost) : 0;
  int best = -1;
  for (int i = 0; i < count; ++i)
    if (static_cast<uint8_t>(frame[i]) == position && (best < 0 || cost[i] < cost[best])) best = i;
  return best < 0 ? kNoSource : frame[best];
}

// From positions, which tell the frames apart where there are no more of them than positions.
SourceMap sources_at(const ColourCosts& costs, Plane<uint8_t> positions, const Job& job) {
  if (costs.frames() <= SourceMap::kMostNarrow) return SourceMap(std::move(positions));
  SourceMap sources(positions.width, positions.height, costs.frames());
  parallel_for(job, positions.height, [&](int y) {
    for (int x = 0; x < positions.width; ++x) sources.set(x, y, source_at(costs, x, y, positions.at(x, y)));
  });
  return sources;
}

}  // namespace
}  // namespace ldp::solve

namespace ldp {

using namespace solve;

ColourSolve solve_colour(const ColourCosts& costs, const ColourSolveOptions& options, const Job& job) {
  if (costs.frames() < 1 || costs.frames() > kMostSources)
    throw std::logic_error("solve_colour: frames must lie in 1 .. 16383");
  if (costs.wraps() && costs.width() < 4) throw std::logic_error("solve_colour: a grid that wraps is at least 4 wide");
  const int units = units_in_sixteenths(options);
  const int step = std::max(1, static_cast<int>(std::lround(options.lambda * kAnglesPerDegree * units / kSixteenths)));
  const Smoothness smoothness(step, options.contrast, options.truncation);
  const ColourSource source(costs, units);
  WindowSolve solved =
      solve_windows(source, smoothness,
                    {options.core_px, options.margin_px, options.iterations, options.cycles, options.passes}, job);
  const double degrees = static_cast<double>(kSixteenths) / (units * kAnglesPerDegree);
  return {sources_at(costs, std::move(solved.slot_map.positions), job), report_of(solved, degrees)};
}

}  // namespace ldp
