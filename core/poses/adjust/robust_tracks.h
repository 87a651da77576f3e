// Bundle adjustment by iteratively reweighted least squares, one weight per track: where one photo shows another thing
// than the others (an edge before something farther, what moves), the point lies wrong for all of them, and what is
// seen where it seems to be is no truer than what is not. The fewer photos, the less does the false one stand out.
#pragma once

#include "core/base/job.h"
#include "core/poses/adjust/bundle_adjustment.h"

namespace ldp::sfm {

// From where adjusting observation by observation ended. A track weighs by what its point leaves of it, squared, for
// each number that is not the point's own, against `scale_px` at weight 1 (Geman and McClure 1985). The bundle's own
// weights stay as they are; options.loss_px and options.max_iterations do not count.
void adjust_with_track_weights(Bundle& bundle, BundleAdjustmentOptions options, double scale_px, const Job& job);

// The same from there with a scale as narrow as the noise, until the cameras have settled: where few points tie two
// steps together, what moves or lies at an edge may still hold a photo in a wrong place at a wider one. Weights that
// narrow also give up much of what is true, and cameras that all points hold loosely come out no truer. So the new
// cameras are kept only where tracks say clearly, at a scale between the two, that they explain more; gives whether.
// `pixel`: one of 800 in these photos.
bool adjust_with_narrow_track_weights(Bundle& bundle, BundleAdjustmentOptions options, double pixel, const Job& job);

}  // namespace ldp::sfm
