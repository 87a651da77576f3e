// How a grid is cut into windows.
#pragma once

#include <vector>

namespace ldp::solve {

// Intervals that cut a length into parts of about core_px, its cores, each widened by the margin; `shift` moves the
// cuts by half a part. Intervals i and i + 2 are at least 2 pixels apart (but for the first and the last of a ring).
struct Interval {
  int begin, size;
  int core_begin, core_size;
};

std::vector<Interval> cut_line(int length, int core_px, int margin_px, bool shift);

// The same on a ring: an interval may run past the length, modulo which it is meant.
std::vector<Interval> cut_ring(int length, int core_px, int margin_px, bool shift);

// What cuts a grid into windows.
struct WindowCuts {
  std::vector<Interval> columns, rows;
};

}  // namespace ldp::solve
