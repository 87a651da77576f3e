#include "core/solve/tiling.h"

#include <algorithm>
#include <cstdint>

namespace ldp::solve {

std::vector<Interval> tile_line(int length, int core_px, int margin_px, bool shift) {
  std::vector<Interval> intervals;
  const int parts = std::max(1, (length + core_px / 2) / core_px) + (shift ? 1 : 0);
  const int cells = shift ? parts - 1 : parts;
  const auto edge = [&](int k) {
    const double position = shift ? k - 0.5 : k;
    return std::clamp(static_cast<int>(position * length / cells), 0, length);
  };
  for (int i = 0; i < parts; ++i) {
    const int begin = std::max(0, edge(i) - margin_px), end = std::min(length, edge(i + 1) + margin_px);
    if (end > begin) intervals.push_back({begin, end - begin, edge(i), edge(i + 1) - edge(i)});
  }
  return intervals;
}

std::vector<Interval> tile_ring(int length, int core_px, int margin_px, bool shift) {
  std::vector<Interval> intervals;
  const int parts = std::max(2, (length + core_px / 2) / core_px);
  const int64_t half = shift ? length / (2 * parts) : 0;
  for (int64_t i = 0; i < parts; ++i) {
    const int core = static_cast<int>(i * length / parts + half);
    const int core_end = static_cast<int>((i + 1) * length / parts + half);
    const int begin = core - margin_px, end = core_end + margin_px;
    intervals.push_back(
        {((begin % length) + length) % length, std::min(end - begin, length - 1), core % length, core_end - core});
  }
  return intervals;
}

}  // namespace ldp::solve
