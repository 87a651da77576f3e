// The choice of source frames as a source of costs. Made by the stage `colour`, read by `solve`.
#pragma once

#include <cstdint>

namespace ldp {

struct ColourCosts {
  virtual ~ColourCosts() = default;
  virtual int width() const = 0;
  virtual int height() const = 0;
  virtual bool wraps() const = 0;
  virtual int frames() const = 0;  // 1 .. kMostSources
  // Candidates of one pixel: up to 16 frames by rising index, with their angle in 1/64 degree as cost. Calls from
  // several threads at once are allowed.
  virtual int candidates(int x, int y, uint16_t frame[16], uint16_t cost[16]) const = 0;
  virtual uint8_t depth_label(int x, int y) const = 0;
  virtual bool present(int x, int y) const = 0;
};

}  // namespace ldp
