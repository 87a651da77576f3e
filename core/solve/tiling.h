// How a grid is cut into windows.
#pragma once

#include <vector>

namespace ldp::solve {

// Intervals that cut a length into parts of about core_px, its cores, each widened by the margin; `shift` moves the
// tiling by half a part. Intervals i and i + 2 are at least 2 pixels apart (but for the first and the last of a ring).
struct Interval {
  int begin, size;
  int core_begin, core_size;
};

std::vector<Interval> tile_line(int length, int core_px, int margin_px, bool shift);

// The same on a ring: an interval may run past the length, modulo which it is meant.
std::vector<Interval> tile_ring(int length, int core_px, int margin_px, bool shift);

// What tiling a grid into windows.
struct WindowTiling {
  std::vector<Interval> columns, rows;
};

}  // namespace ldp::solve
