// Near surfaces that the photographs' frames cut off, made up beyond them.
//
// A post that fills the photos from top to bottom ends in the panorama where the last photo ends, and a camera that
// steps back sees over that end what lies far behind it. Where a surface of the front layer ends, up or down, at a
// place that no photograph could have shown, it goes on: at its disparity, with its own colours mirrored, until a
// photograph could have shown it or no camera within the viewing limits sees farther. What at most one photograph shows
// may have any depth: it goes on only between parts of its surface that two show.
#pragma once

#include <vector>

#include "core/panorama/panorama.h"
#include "core/view/mesh/prepared_layer.h"
#include "core/view/mesh/sparse_columns.h"

namespace ldp::view {

// A layer for each end of the columns at which anything goes on. `front`: of `panorama`, whose own layers are not
// looked at and which does not wrap; without cameras in it nothing is made up.
std::vector<SparseColumns> extend_beyond_frames(const PreparedLayer& front, const CodedDepths& depths,
                                                const LayeredPanorama& panorama, float parallax);

}  // namespace ldp::view
