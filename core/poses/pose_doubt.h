// Whether a reconstruction contradicts what was seen: an honest word about poses that fit their points well and may be
// wrong all the same (repeated texture, moving things, too little overlap).
//
// Asked of the photos' own evidence, not of the residuals, which outliers have already left: do verified matches agree
// with the poses, do enough points tie each photo to those before it and close a full turn, do photos that should show
// the same share points, does a third photo compare the steps between two?
#pragma once

#include <string>
#include <vector>

#include "core/poses/poses.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

struct Doubt {
  PoseDoubt kind = PoseDoubt::none;
  std::string text;  // one line that names the most suspicious photos; empty when nothing is
};

// `names` are the sweep's frames', focal_known whether someone told the focal length.
Doubt doubt(const MatchedSweep& sweep, const Reconstruction& reconstruction, const std::vector<std::string>& names,
            bool focal_known);

// The share of the verified matches of neighbouring photos, of all together, that agree with the poses; 1 without any.
// What moves through many photos is matched there as well, and pulls the poses.
double agreement(const MatchedSweep& sweep, const Reconstruction& reconstruction);

}  // namespace ldp::sfm
