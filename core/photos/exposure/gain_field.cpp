#include "core/photos/exposure/gain_field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ldp {
namespace {

// The two nodes along one axis around a place, and how far it is from the first to the second.
struct Between {
  int first = 0, second = 0;
  double share = 0;

  Between(double place, int nodes, bool wraps) {
    const double at = place * nodes - 0.5, before = std::floor(at);
    share = at - before;
    const int node = static_cast<int>(before);
    const auto kept = [&](int n) { return wraps ? (n % nodes + nodes) % nodes : std::clamp(n, 0, nodes - 1); };
    first = kept(node);
    second = kept(node + 1);
  }
};

}  // namespace

std::array<double, 3> GainField::at(double x_share, double y_share) const {
  const Between x(x_share, nodes.width, wraps), y(y_share, nodes.height, false);
  const auto &above = nodes.at(x.first, y.first), &above_right = nodes.at(x.second, y.first),
             &below = nodes.at(x.first, y.second), &below_right = nodes.at(x.second, y.second);
  std::array<double, 3> gain{};
  for (size_t c = 0; c < 3; ++c) {
    const double upper = above[c] + x.share * (above_right[c] - above[c]);
    const double lower = below[c] + x.share * (below_right[c] - below[c]);
    gain[c] = (upper + y.share * (lower - upper)) / kOne;
  }
  return gain;
}

}  // namespace ldp
