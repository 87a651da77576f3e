// Surfaces through uncertain disparities: a weak membrane (Blake and Zisserman, Visual Reconstruction, 1987). Each
// pixel is held at its disparity as firmly as matching knows it, and tied to the neighbours of like grey, unless they
// differ so much that the tie breaks: by a sixth of a label, and where the guide is plain all around, so that matching
// knows little, by a whole one. What was matched well draws what was not; renderers tear surfaces that are not even.
#pragma once

#include "core/base/job.h"
#include "core/base/plane.h"
#include "core/geometry/disparity.h"

namespace ldp::sweep {

// Pixels of kNoDisparity stay and are not looked at. `firmness` (how fast the cost of matching rises beside its least,
// see depth_refinement.cpp) and `guide` (grey) have the map's size; `label_steps`: disparity steps of a label; `wraps`:
// columns are modulo the width.
DisparityMap weak_membrane(const DisparityMap& disparity, const Plane<uint8_t>& firmness, const Plane<uint8_t>& guide,
                           int label_steps, bool wraps, const Job& job);

}  // namespace ldp::sweep
