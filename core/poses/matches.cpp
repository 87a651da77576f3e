#include "matches.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace ldp {
namespace {

constexpr int kFarthest = std::numeric_limits<int>::max();

// Products stay below 2^18 and the sum of all below 2^31, whatever the descriptors.
int dot(const int16_t* a, const int16_t* b) {
  int sum = 0;
  for (int i = 0; i < kDescriptorLength; ++i) sum += a[i] * b[i];
  return sum;
}

// The two nearest so far, as squared distances.
struct Nearest {
  int index = -1, best = kFarthest, second = kFarthest;

  void offer(int candidate, int distance) {
    if (distance < best) {
      second = best, best = distance, index = candidate;
    } else {
      second = std::min(second, distance);
    }
  }
  bool clear(double ratio) const { return index >= 0 && best < ratio * ratio * second; }
};

std::vector<int> squared_lengths(const Features& features, int count) {
  std::vector<int> lengths;
  for (int i = 0; i < count; ++i) lengths.push_back(dot(features.descriptor(i), features.descriptor(i)));
  return lengths;
}

}  // namespace

std::vector<Match> match_features(const Features& a, const Features& b, const MatchOptions& options) {
  const int count_a = options.most > 0 ? std::min(options.most, a.size()) : a.size();
  const int count_b = options.most > 0 ? std::min(options.most, b.size()) : b.size();
  const std::vector<int> length_a = squared_lengths(a, count_a), length_b = squared_lengths(b, count_b);
  std::vector<Nearest> of_a(static_cast<size_t>(count_a)), of_b(static_cast<size_t>(count_b));
  for (int i = 0; i < count_a; ++i) {
    const size_t ia = static_cast<size_t>(i);
    for (int j = 0; j < count_b; ++j) {
      const size_t jb = static_cast<size_t>(j);
      const int distance = length_a[ia] + length_b[jb] - 2 * dot(a.descriptor(i), b.descriptor(j));
      of_a[ia].offer(j, distance);
      of_b[jb].offer(i, distance);
    }
  }
  std::vector<Match> matches;
  for (int i = 0; i < count_a; ++i) {
    const Nearest& nearest = of_a[static_cast<size_t>(i)];
    if (!nearest.clear(options.ratio)) continue;
    const Nearest& back = of_b[static_cast<size_t>(nearest.index)];
    if (back.index == i && back.clear(options.ratio)) matches.push_back({i, nearest.index, nearest.best});
  }
  return matches;
}

}  // namespace ldp
