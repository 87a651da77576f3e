// One window of a labelling problem, as arrays. A problem has at most 16 slots a pixel; for depth a slot is a label,
// for colour it is a source frame modulo 16, `position` then holding the frame modulo 256: of frames that are
// further apart than that, two neighbours hardly take both, and truncation is reached long before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/cost_source.h"
#include "core/base/plane.h"
#include "core/solve/moves/message_passing.h"
#include "core/solve/moves/smoothness.h"

namespace ldp::solve {

constexpr int kSlots = 16;
constexpr uint16_t kForbidden = 8000;  // cost of a slot that must not be taken

// Directions to the 4-neighbours of a pixel; d ^ 1 is the opposite of d.
enum Direction : uint8_t { kUp = 0, kDown = 1, kLeft = 2, kRight = 3 };

// Pixels are stored by columns: p = x * height + y.
inline size_t at(int p) { return static_cast<size_t>(p); }

// What a problem says about each pixel by itself.
struct PixelTerms {
  int width = 0, height = 0;
  std::vector<uint16_t> cost;     // 16 per pixel
  std::vector<uint16_t> floor;    // what was taken off all costs of a pixel, or empty: nothing was
  std::vector<uint8_t> grey;      // 16 per pixel
  std::vector<uint8_t> position;  // 16 per pixel, or empty: slot number = position
  std::vector<uint8_t> solved;    // 1 per pixel: is it part of the problem?

  void resize(int new_width, int new_height, bool with_positions);
  int size() const { return width * height; }
  size_t bytes() const;

  const uint16_t* costs(int p) const { return cost.data() + static_cast<ptrdiff_t>(p) * kSlots; }
  const uint8_t* greys(int p) const { return grey.data() + static_cast<ptrdiff_t>(p) * kSlots; }
  int position_of(int p, int slot) const {
    return position.empty() ? slot : position[static_cast<size_t>(p) * kSlots + static_cast<size_t>(slot)];
  }
  // V of the pair (slot a at p, slot b at q) across an edge of some factor.
  int pair(const Smoothness& smoothness, int factor, int p, int a, int q, int b) const {
    const auto steps = static_cast<int8_t>(static_cast<uint8_t>(position_of(p, a) - position_of(q, b)));
    return smoothness(factor, steps, greys(p)[a] - greys(q)[b]);
  }
};

// The same with edges, messages and labels. An edge belongs to its upper or left pixel.
struct LabelGrid : PixelTerms {
  std::vector<uint8_t> grey_range;   // least and largest grey, 2 per pixel
  std::vector<uint8_t> message;      // 64 per pixel: what came from each direction, 16 each (a reparametrisation)
  std::vector<uint8_t> down, right;  // edge factors, 1 per pixel; 0 = no edge
  std::vector<uint8_t> fresh;        // 1 per pixel, see KernelGrid
  std::vector<uint8_t> label;        // slot taken, 1 per pixel

  void resize(int new_width, int new_height, bool with_positions);
  int stride(int direction) const {
    return direction == kDown ? 1 : direction == kUp ? -1 : direction == kRight ? height : -height;
  }
  size_t bytes() const;
  // To be called when the greys were filled.
  void find_grey_ranges();
  const uint8_t* messages(int p, int direction) const {
    return message.data() + (static_cast<ptrdiff_t>(p) * 4 + direction) * kSlots;
  }
  KernelGrid kernel_grid(const Smoothness& smoothness);
  // Factor of the edge that leaves p in a direction, 0 at the rim.
  int factor(int p, int direction) const {
    switch (direction) {
      case kDown:
        return down[static_cast<size_t>(p)];
      case kRight:
        return right[static_cast<size_t>(p)];
      case kUp:
        return p >= 1 ? down[static_cast<size_t>(p - 1)] : 0;
      default:
        return p >= height ? right[static_cast<size_t>(p - height)] : 0;
    }
  }
};

// The grid at half its resolution: costs of 2x2 pixels summed and, like the edges between blocks, halved, so that a
// message of the coarse grid stands for that of each fine edge.
void coarsen(const LabelGrid& fine, LabelGrid& coarse);

// Gives every pixel the messages of its coarse pixel, where there is an edge to carry them.
void spread_messages(const LabelGrid& coarse, LabelGrid& fine);

struct Energy {
  int64_t data = 0, smoothness = 0;
  int64_t total() const { return data + smoothness; }
  Energy& operator+=(const Energy& other) {
    data += other.data;
    smoothness += other.smoothness;
    return *this;
  }
  Energy& operator-=(const Energy& other) {
    data -= other.data;
    smoothness -= other.smoothness;
    return *this;
  }
};

// Energy of every pixel's label and of the edges, floors apart.
Energy energy_of(const LabelGrid& grid, const Smoothness& smoothness);

// A labelling problem that gives any window of itself.
class GridSource {
 public:
  virtual ~GridSource() = default;
  virtual int width() const = 0;
  virtual int height() const = 0;
  virtual bool wraps() const = 0;
  virtual int slots() const = 0;
  virtual bool has_positions() const = 0;
  // Factor of the edge from (x, y) to the pixel below or to the right, where both are part of the problem.
  virtual int edge_factor(int x, int y, bool down) const = 0;
  // Writes a window, which lies inside the grid but for x modulo width in a source that wraps, to terms large enough;
  // its corner becomes pixel `first` of them. Pixels that are not part of the problem get equal costs.
  virtual void load(const Window& window, PixelTerms& terms, int first) const = 0;
};

// Sets the edges of a grid that holds a window's terms.
void set_edges(const GridSource& source, const Window& window, LabelGrid& grid);

}  // namespace ldp::solve
