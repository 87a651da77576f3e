#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "label_grid.h"
#include "smoothness.h"
#include "solve.h"
#include "windows.h"

namespace ldp {

namespace {

constexpr int kAnglesPerDegree = 64;
constexpr int kSixteenths = 16;  // energy units are given in sixteenths per cost step

// A frame's slot is its index modulo 16.
class ColourSource final : public GridSource {
 public:
  ColourSource(const ColourCosts& costs, int units_in_sixteenths) : costs_(costs), units_(units_in_sixteenths) {}
  int width() const override { return costs_.width(); }
  int height() const override { return costs_.height(); }
  bool wraps() const override { return costs_.wraps(); }
  int slots() const override { return std::min(costs_.frames(), kSlots); }
  bool has_positions() const override { return true; }

  void load(const Window& window, LabelGrid& grid) const override {
    grid.resize(window.width, window.height, true);
    for (int x = 0; x < window.width; ++x) {
      const int gx = (window.x + x) % costs_.width();
      for (int y = 0; y < window.height; ++y) load_pixel(gx, window.y + y, x * window.height + y, grid);
    }
    const auto solved = [&](int p) { return grid.costs(p)[kSlots - 1] != kAbsent; };
    for (int p = 0; p < grid.size(); ++p) {
      if (!solved(p)) continue;
      if ((p + 1) % window.height != 0) grid.down[static_cast<size_t>(p)] = solved(p + 1);
      if (p + window.height < grid.size()) grid.right[static_cast<size_t>(p)] = solved(p + window.height);
    }
    for (uint16_t& cost : grid.cost)
      if (cost == kAbsent) cost = 0;
    grid.find_grey_ranges();
  }

  struct Choice {
    uint8_t frame = 255;  // 255 for a pixel without candidates
    int angle = 0, least_angle = 0;
  };

  // The frame of a slot.
  Choice choice(int x, int y, int slot) const {
    uint8_t frame[kSlots];
    uint16_t angle[kSlots];
    const int count = costs_.present(x, y) ? costs_.candidates(x, y, frame, angle) : 0;
    if (count == 0) return {};
    Choice best{255, 1 << 30, *std::min_element(angle, angle + count)};
    for (int i = 0; i < count; ++i)
      if (frame[i] % kSlots == slot && angle[i] < best.angle) {
        best.frame = frame[i];
        best.angle = angle[i];
      }
    return best;
  }

 private:
  static constexpr uint16_t kAbsent = 0xFFFF;  // marks pixels outside the problem while a window is loaded
  static constexpr int kCeiling = 4096;        // above the pixel's least cost; no such slot is in a best labelling

  void load_pixel(int gx, int gy, int p, LabelGrid& grid) const {
    uint8_t frame[kSlots];
    uint16_t angle[kSlots];
    uint16_t* cost = grid.cost.data() + static_cast<ptrdiff_t>(p) * kSlots;
    uint8_t* position = grid.position.data() + static_cast<ptrdiff_t>(p) * kSlots;
    const int count = costs_.present(gx, gy) ? costs_.candidates(gx, gy, frame, angle) : 0;
    std::fill_n(grid.grey.begin() + static_cast<ptrdiff_t>(p) * kSlots, kSlots, costs_.depth_label(gx, gy));
    for (int slot = 0; slot < kSlots; ++slot) position[slot] = static_cast<uint8_t>(slot);
    std::fill_n(cost, kSlots, count > 0 ? kForbidden : kAbsent);
    if (count == 0) return;
    const int least = *std::min_element(angle, angle + count);
    for (int i = 0; i < count; ++i) {
      const int slot = frame[i] % kSlots;
      const int above = std::min(((angle[i] - least) * units_ + kSixteenths / 2) / kSixteenths, kCeiling);
      if (above >= cost[slot]) continue;
      cost[slot] = static_cast<uint16_t>(above);
      position[slot] = frame[i];
    }
  }

  const ColourCosts& costs_;
  int units_;
};

int units_in_sixteenths(const ColourSolveOptions& options) {
  const double widest = options.lambda * kAnglesPerDegree * options.truncation;
  if (!(options.lambda > 0) || options.truncation < 1 || options.truncation > 15 || widest > kWidestPair * kSixteenths)
    throw std::logic_error("solve_colour: lambda * truncation must lie in 0 .. 62 degrees, truncation in 1 .. 15");
  return std::clamp(static_cast<int>(kWidestPair * kSixteenths / widest), 1, 256);
}

struct Angles {  // sums over pixels, in 1/kAnglesPerDegree
  int64_t taken = 0, least = 0;
};

}  // namespace

Labelling solve_colour(const ColourCosts& costs, const ColourSolveOptions& options, const Job& job) {
  if (costs.frames() < 1 || costs.frames() > 255) throw std::logic_error("solve_colour: frames must lie in 1 .. 255");
  if (costs.wraps() && costs.width() < 4) throw std::logic_error("solve_colour: a grid that wraps is at least 4 wide");
  const int units = units_in_sixteenths(options);
  const int step = std::max(1, static_cast<int>(std::lround(options.lambda * kAnglesPerDegree * units / kSixteenths)));
  const Smoothness smoothness(step, options.contrast, options.truncation);
  const ColourSource source(costs, units);
  const WindowSolve solve =
      solve_windows(source, smoothness, {options.core_px, options.margin_px, options.iterations, options.passes}, job);
  Labelling result;
  result.labels = Plane<uint8_t>(costs.width(), costs.height());
  std::vector<Angles> sums(static_cast<size_t>(costs.height()));
  parallel_for(job, costs.height(), [&](int y) {
    Angles& sum = sums[static_cast<size_t>(y)];
    for (int x = 0; x < costs.width(); ++x) {
      const auto choice = source.choice(x, y, solve.slots.at(x, y));
      result.labels.at(x, y) = choice.frame;
      sum.taken += choice.angle;
      sum.least += choice.least_angle;
    }
  });
  Angles angles;
  for (const Angles& sum : sums) angles = {angles.taken + sum.taken, angles.least + sum.least};
  const double degrees = static_cast<double>(kSixteenths) / (units * kAnglesPerDegree);
  result.report.data_energy = static_cast<double>(angles.taken) / kAnglesPerDegree;
  result.report.smoothness_energy = static_cast<double>(solve.final.smoothness) * degrees;
  result.report.initial_energy =
      static_cast<double>(solve.initial.total()) * degrees + static_cast<double>(angles.least) / kAnglesPerDegree;
  result.report.passes = solve.passes;
  result.report.peak_bytes = solve.peak_bytes;
  return result;
}

}  // namespace ldp
