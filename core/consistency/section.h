// Parts of a panorama that are rendered from by themselves: a mesh of all of it takes too much memory.
#pragma once

#include <vector>

#include "core/panorama/panorama.h"

namespace ldp::consistency {

// Neighbouring columns of a panorama; in one that wraps they may go on past its end.
struct Section {
  int begin = 0, columns = 0;
};

// Consecutive cameras, and the columns that they may see.
struct CameraGroup {
  size_t begin = 0, end = 0;
  Section section;
};

// Cameras are together while they see at most `most_share` of the columns; alone, one may see more.
std::vector<CameraGroup> group_cameras(const PanoramaGrid& grid, const std::vector<Camera>& cameras, double most_share);

// A panorama of its own, with the same rays. It wraps when the section is all of one that does.
LayeredPanorama cut_out(const LayeredPanorama& panorama, const Section& section);

}  // namespace ldp::consistency
