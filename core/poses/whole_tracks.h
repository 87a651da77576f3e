// Bundle adjustment that believes a track as a whole or not at all: where one photo shows another thing than the
// others (an edge before something farther, what moves), the point lies wrong for all of them, and what is seen where
// it seems to be is no truer than what is not. The fewer photos, the less does the false one stand out.
#pragma once

#include "bundle.h"
#include "job.h"

namespace ldp {

// From where adjusting observation by observation ended. A track weighs by what its point leaves of it, squared, for
// each number that is not the point's own, against `scale_px` at weight 1 (Geman and McClure 1985). The bundle's own
// weights stay as they are; options.loss_px and options.most_iterations do not count.
void adjust_whole_tracks(Bundle& bundle, BundleOptions options, double scale_px, const Job& job);

}  // namespace ldp
