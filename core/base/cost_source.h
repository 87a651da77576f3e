// The disparity space image as a source of windows: the solver pulls what it needs, so no whole volume need exist.
#pragma once

#include <cstdint>

namespace ldp {

// A window of the panorama grid. In a source that wraps, x may run past the width and is taken modulo it.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;
};

class CostSource {
 public:
  virtual ~CostSource() = default;
  virtual int width() const = 0;
  virtual int height() const = 0;
  virtual int labels() const = 0;  // L, 2 .. 16
  virtual bool wraps() const = 0;

  // Fills, for every pixel of the window, L matching costs phi (paper 3.2) and L median greys mu. Layout of both:
  // out[(x_local * window.height + y_local) * L + label]; x outer because the sweep yields columns.
  // Costs are in units of 1/kCostScale grey level. Calls from several threads at once are allowed.
  virtual void read(const Window& window, uint8_t* cost, uint8_t* median) const = 0;
};

constexpr int kCostScale = 4;

}  // namespace ldp
