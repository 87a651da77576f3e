// What feature points around a ray tell of its label where photographs themselves hardly do: on plain surfaces.
//
// Each cell of pixels has the median of the labels of the points near it, weighted by nearness and by how many cameras
// saw them, and a weight: points that are few, far away or of several depths tell little.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/geometry.h"

namespace ldp::sweep {

class PointsPrior {
 public:
  static constexpr int kLabelSteps = 16;  // parts of a label
  static constexpr int kFull = 256;       // weight of what many points agree on

  struct Expectation {
    int16_t label = 0;  // in 1/kLabelSteps
    int16_t weight = 0;
  };

  // Points as the poses give them, in world coordinates; those outside the panorama's depths are left out.
  PointsPrior(const PanoramaGrid& grid, const std::vector<ScenePoint>& points, int labels);

  // x wraps where the panorama does.
  Expectation at(int x, int y) const;

 private:
  int width_;  // of the panorama
  Plane<Expectation> cells_;
};

}  // namespace ldp::sweep
