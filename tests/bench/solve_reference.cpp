#include "tests/bench/solve_reference.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/solve/moves/alpha_expansion.h"

namespace ldp::solve {

void expand_whole_grid(LabelGrid& grid, const Smoothness& smoothness, int slots) {
  std::fill(grid.label.begin(), grid.label.end(), uint8_t{0});
  Expansion expansion;
  expansion.start(grid, smoothness);
  for (int quiet = 0, alpha = 0; quiet < slots; alpha = (alpha + 1) % slots)
    quiet = expansion.expand(alpha) ? 1 : quiet + 1;
}

namespace {

using Vector = std::array<float, kSlots>;

class MessagePassing {
 public:
  MessagePassing(const LabelGrid& grid, const Smoothness& smoothness)
      : grid_(grid), smoothness_(smoothness), messages_(static_cast<size_t>(grid.size()) * 4, Vector{}) {
    flat_ = std::all_of(grid.grey.begin(), grid.grey.end(), [](uint8_t grey) { return grey == 0; });
  }

  double sweep(bool forward) {
    double bound = 0;
    for (int i = 0; i < grid_.size(); ++i) bound += visit(forward ? i : grid_.size() - 1 - i, forward);
    return bound;
  }

 private:
  Vector& message(int p, int direction) {
    return messages_[static_cast<size_t>(p) * 4 + static_cast<size_t>(direction)];
  }

  static double take_minimum(Vector& vector) {
    const float least = *std::min_element(vector.begin(), vector.end());
    for (float& value : vector) value -= least;
    return static_cast<double>(least);
  }

  double visit(int p, bool forward) {
    Vector belief;
    for (size_t a = 0; a < kSlots; ++a) belief[a] = static_cast<float>(grid_.costs(p)[a]);
    int ahead = 0, behind = 0;
    for (int d = 0; d < 4; ++d) {
      if (grid_.factor(p, d) == 0) continue;
      ++(d == kDown || d == kRight ? ahead : behind);
      for (size_t a = 0; a < kSlots; ++a) belief[a] += message(p, d)[a];
    }
    double bound = take_minimum(belief);
    const float share = 1.0F / static_cast<float>(std::max({1, ahead, behind}));
    for (const int d : {kDown, kRight, kUp, kLeft})
      if ((d == kDown || d == kRight) == forward && grid_.factor(p, d) != 0) bound += send(p, d, share, belief);
    return bound;
  }

  double send(int p, int direction, float share, const Vector& belief) {
    const int q = p + grid_.stride(direction), factor = grid_.factor(p, direction);
    Vector from, to;
    for (size_t a = 0; a < kSlots; ++a) from[a] = share * belief[a] - message(p, direction)[a];
    to.fill(1e9F);
    for (int a = 0; a < kSlots; ++a)
      for (int b = 0; b < kSlots; ++b) {
        const int pair = flat_ && grid_.position.empty()
                             ? std::min(std::abs(a - b), smoothness_.truncation()) * smoothness_.weight(factor, 0)
                             : grid_.pair(smoothness_, factor, p, a, q, b);
        to[static_cast<size_t>(b)] =
            std::min(to[static_cast<size_t>(b)], from[static_cast<size_t>(a)] + static_cast<float>(pair));
      }
    const double least = take_minimum(to);
    message(q, direction ^ 1) = to;
    return least;
  }

  const LabelGrid& grid_;
  const Smoothness& smoothness_;
  std::vector<Vector> messages_;
  bool flat_ = false;
};

}  // namespace

constexpr int kBetweenLooks = 25;
constexpr double kNoGain = 1e-5;

double lower_bound(const LabelGrid& grid, const Smoothness& smoothness, int iterations) {
  MessagePassing passing(grid, smoothness);
  double best = 0, before = 0;
  for (int i = 0; i < iterations; ++i) {
    passing.sweep(true);
    best = std::max(best, passing.sweep(false));
    if (i % kBetweenLooks != kBetweenLooks - 1) continue;
    if (best - before < kNoGain * best) break;
    before = best;
  }
  return best;
}

}  // namespace ldp::solve
