// Captures with given cameras, up to the sweep.
#pragma once

#include <string>
#include <vector>

#include "geometry.h"
#include "upright.h"

namespace ldp {

struct PreparedCapture {
  PanoramaGrid grid;
  std::vector<UprightFrame> upright;
};

// A folder with transforms.json and its photos, or `frames` with them.
PreparedCapture prepare_capture(const std::string& folder);

}  // namespace ldp
