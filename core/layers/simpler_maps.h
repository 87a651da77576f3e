// Simpler depth maps, for photographs to choose (ProposalFusion::simplify). Photographs tell little of plain and of
// slanted surfaces: steps, noise and tears in those are mostly chance.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/photos/upright_frame.h"

namespace ldp {

// Puts pixels onto the plane that most of what is around them lies on, where that is no other surface
// (proposals/plane_fits.cpp). Inverse depth on a plane is all but linear in columns and rows over a few degrees.
void put_onto_planes(const PanoramaGrid& grid, const Job& job, DisparityMap& layer);

// Makes slopes of steps around which the camera next to each ray shows nothing (proposals/plain_tears.cpp). A step
// between two things shows as an edge; through one without, a view from aside sees what lies behind.
void close_plain_tears(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Job& job,
                       DisparityMap& layer);

}  // namespace ldp
