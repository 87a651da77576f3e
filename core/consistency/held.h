// A photograph beside what the panorama shows in its place, and who looks on while they are compared.
#pragma once

#include <cstddef>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"

namespace ldp::consistency {

inline int grey(Rgb c) { return (77 * c.r + 150 * c.g + 29 * c.b) >> 8; }

// A photograph at even exposure, and the panorama's z-depth as its camera sees it (0 = hole, infinity).
struct Held {
  const Camera* camera = nullptr;
  RgbImage photo;
  Plane<float> depth;
};

// The rendering to compare it with.
struct Rendering {
  RgbImage colour;
  Plane<uint8_t> alpha;
};

// Is told of each camera in turn, by rising index. What it is given lasts for the call.
class Observer {
 public:
  virtual ~Observer() = default;
  // The photograph rendered back; `before`: the photograph before it, or null.
  virtual void rendered(size_t camera, const Held& own, const Rendering& rendering, const Held* before) = 0;
};

}  // namespace ldp::consistency
