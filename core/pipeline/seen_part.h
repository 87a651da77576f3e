// Which part of a grid the photographs see.
//
// At any depth of the grid's range: which one a ray has is not known before it is swept, and where one photo alone
// looks it is anyone's guess. (Masks from depths found on few rays lose what photos show at their borders:
// decisions.md.)
#pragma once

#include <vector>

#include "core/base/cost_source.h"
#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/geometry.h"
#include "core/photos/upright_frame.h"

namespace ldp {

struct SeenPart {
  Window box;           // of the grid: no photo sees anything beside it
  Plane<uint8_t> mask;  // of the box: 0 = seen by no photo; empty: all of it may be
};

// All of the grid where it is too small to be looked at coarsely, or where less than one by kWorthLeavingOut is unseen.
SeenPart find_seen_part(const std::vector<UprightFrame>& upright, const PanoramaGrid& grid, const Job& job);

}  // namespace ldp
