#include "core/poses/features/descriptor_matching.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/poses/features/descriptor_distance.h"

namespace ldp::sfm {
namespace {

constexpr int kFarthest = std::numeric_limits<int>::max();
constexpr int kTile = 64;  // points of b that stay in the cache while all of a pass by
static_assert(descriptor_distance::kLength == kDescriptorLength);

// The two nearest so far of many points, as squared distances.
struct Nearest {
  std::vector<int> best, second, index;

  explicit Nearest(int count)
      : best(static_cast<size_t>(count), kFarthest), second(best), index(static_cast<size_t>(count), -1) {}

  bool passes_ratio_test(int i, double ratio) const {
    const size_t at = static_cast<size_t>(i);
    return index[at] >= 0 && best[at] < ratio * ratio * second[at];
  }
  descriptor_distance::NearestRow from(int i) { return {best.data() + i, second.data() + i, index.data() + i}; }
};

// Products stay below 2^18 and the sum of all below 2^31, whatever the descriptors.
std::vector<int> squared_lengths(const Features& features, int count) {
  std::vector<int> lengths;
  for (int i = 0; i < count; ++i) {
    const int16_t* d = features.descriptor(i);
    lengths.push_back(std::inner_product(d, d + kDescriptorLength, d, 0));
  }
  return lengths;
}

// One point is at these distances from the points `first` and following.
void update_nearest(const int* distances, int first, int count, int& best, int& second, int& index) {
  for (int j = 0; j < count; ++j) {
    if (distances[j] < best) {
      second = best, best = distances[j], index = first + j;
    } else {
      second = std::min(second, distances[j]);
    }
  }
}

}  // namespace

std::vector<Match> match_features(const Features& a, const Features& b, const MatchOptions& options) {
  const int count_a = options.max_features > 0 ? std::min(options.max_features, a.size()) : a.size();
  const int count_b = options.max_features > 0 ? std::min(options.max_features, b.size()) : b.size();
  const std::vector<int> length_a = squared_lengths(a, count_a), length_b = squared_lengths(b, count_b);
  const descriptor_distance::Kernels& kernels = descriptor_distance::best();
  Nearest of_a(count_a), of_b(count_b);
  std::array<int, kTile> distances;
  for (int first = 0; first < count_b; first += kTile) {
    const int count = std::min(kTile, count_b - first);
    for (int i = 0; i < count_a; ++i) {
      const size_t ia = static_cast<size_t>(i);
      kernels.distances(a.descriptor(i), length_a[ia], b.descriptor(first), length_b.data() + first, count,
                        distances.data());
      kernels.update_nearest(distances.data(), i, count, of_b.from(first));
      if (kernels.minimum(distances.data(), count) >= of_a.second[ia]) continue;
      update_nearest(distances.data(), first, count, of_a.best[ia], of_a.second[ia], of_a.index[ia]);
    }
  }
  std::vector<Match> matches;
  for (int i = 0; i < count_a; ++i) {
    if (!of_a.passes_ratio_test(i, options.ratio)) continue;
    const int nearest = of_a.index[static_cast<size_t>(i)];
    if (of_b.index[static_cast<size_t>(nearest)] == i && of_b.passes_ratio_test(nearest, options.ratio))
      matches.push_back({i, nearest, of_a.best[static_cast<size_t>(i)]});
  }
  return matches;
}

}  // namespace ldp::sfm
