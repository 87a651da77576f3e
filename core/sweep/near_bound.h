// How near things come that no feature point told of: leaves, chair backs, sleeves.
//
// Takes upright frames and a grid whose range came from feature points; sweeps nearer depths in a part of its columns
// and gives the inverse depth that holds what matches there and nowhere within the range. Does not lay the grid.
#pragma once

#include <vector>

#include "geometry.h"
#include "job.h"
#include "upright.h"

namespace ldp {

// grid.w_near where hardly anything matches nearer; at most 1.5 times it, since labels are so few.
double matched_near(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid, const Job& job);

}  // namespace ldp
