// Tracking of points (Kanade, Lucas, Tomasi) into every frame that should show them: where bundle adjustment predicts a
// point, its surroundings in one frame (the anchor) are aligned with the picture there, to a fraction of a pixel (Lucas
// and Kanade 1981, inverse compositional as in Baker and Matthews 2004, zero-mean and of unit contrast so that exposure
// does not matter). Then all frames that show it, the anchor among them, are aligned with what they show on the
// average, and with more of the surroundings where these are flat. Matching descriptors finds a thing in a few of the
// frames that show it; tracking finds it in most, and more exactly. That is what makes focal length and long arcs
// accurate.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/job.h"
#include "core/poses/features/features.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/tracks.h"

namespace ldp::sfm {

struct KltOptions {
  double reach = 6;  // pixels of the picture from the prediction within which the thing is looked for
  double min_correlation = 0.75;
};

// Every track (its point is bundle.points[i]) with all frames in which it was found, its anchor included; one frame
// means that it was not found again.
std::vector<Track> track_points(const std::vector<GreyPhoto>& pictures, const std::vector<Track>& tracks,
                                const Bundle& bundle, const KltOptions& options, const Job& job);

}  // namespace ldp::sfm
