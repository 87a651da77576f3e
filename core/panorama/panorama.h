// The layered depth panorama: what `build` makes, the .ldp file keeps and `render` shows (paper, section 3).
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/plane.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/photos/exposure/gain_field.h"

namespace ldp {

// One layer over the whole grid. Layer 0 is the front one and dense; a later layer is present only where some camera
// sees behind the earlier ones, and lies strictly behind them there.
struct Layer {
  DepthCodes depth;
  Plane<uint8_t> coverage;  // 1 = present, 0 = absent
  Plane<uint8_t> alpha;     // empty = opaque wherever present; else opacity 0..255 for soft silhouettes
  RgbImage colour;          // absent pixels hold {0, 0, 0}

  friend bool operator==(const Layer&, const Layer&) = default;
};

// How far from the arc views hold, in the capture's unit of length: a view is good while its centre's distance from
// the arc's axis is within [inner_radius, outer_radius] and its height above the arc's plane within +-height.
struct ViewingLimits {
  double inner_radius = 0, outer_radius = 0, height = 0;

  // Whether a place is farther from where views hold than these are wide: little is seen there but what is invented.
  // Of a sweep that moved along no arc nobody can tell.
  bool are_far_from(double from_axis, double above) const {
    return outer_radius > 0 && (from_axis > 2 * outer_radius || std::abs(above) > height + outer_radius);
  }
};

struct LayeredPanorama {
  PanoramaGrid grid;
  std::vector<Layer> layers;    // front to back, 1 .. 8
  std::vector<Camera> cameras;  // the source cameras, as used
  ViewingLimits limits;
  std::map<std::string, double> quality;        // named figures, e.g. "psnr_leave_one_out_db"
  std::map<std::string, std::string> metadata;  // e.g. "device", "captured_utc" (ISO 8601), "software"
  // By what light colours at even exposure were multiplied, by direction, the same for all layers (local_exposure.h);
  // empty where colours are at even exposure.
  DisplayExposure exposure = {};

  // The layer that is seen first at a pixel (row by row) of the grid: the frontmost that is present; null: there is
  // none.
  const Layer* seen_first(size_t pixel) const {
    for (const Layer& layer : layers)
      if (layer.coverage.samples[pixel] != 0) return &layer;
    return nullptr;
  }
};

}  // namespace ldp
