// How well the cameras beside one confirm the surface that it sees.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/geometry/visibility_map.h"
#include "core/layers/painting/view_kernels.h"
#include "core/photos/upright_frame.h"

namespace ldp::layers {

// Asks of every camera's pixel the cameras next to it that see the same surface, what hides it from them taken into
// account. Frames must outlive it.
class PhotoConsistency {
 public:
  // Every map holds the camera's columns 0, columns_apart, 2 columns_apart ...
  PhotoConsistency(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, int columns_apart);

  // The cameras that are asked about what camera k sees.
  std::vector<size_t> witnesses(size_t k) const;

  struct Range {
    int low = 0, high = 0;
    // By how much a value lies outside.
    int outside(int value) const { return std::max({0, value - high, low - value}); }
  };

  // What a photograph shows within a part of a pixel (kWitnessPartOfPx) of a sample, by the 3x3 around it.
  struct Around {
    bool inside = false;  // are those of the photograph? Of others nothing else is told.
    Range greys, tints;
  };

  // Pixels of one column that maps hold.
  struct Pixels {
    int x = 0;
    std::vector<int32_t> rows;
    std::vector<Around> samples;  // of the rows, see look()
  };

  // What camera k's photograph shows at the rows, whatever the surfaces.
  void look(size_t k, Pixels& pixels) const;

  // Mean difference [1/kDifferenceSteps grey levels] of each of camera k's pixels that were looked at, where it sees
  // the surface of maps[k], from what cameras that see it there too show, between their pixels; what a part of a pixel
  // may change is none.
  // kUnknownDifference where no other does, or no surface is. Maps of other cameras than k and its witnesses may be
  // null.
  void differences(size_t k, const Pixels& pixels, const std::vector<const VisibilityMap*>& maps,
                   std::vector<int>& found) const;

 private:
  // From one upright camera's axes to another's; both stand upright on the arc's plane.
  struct Witness {
    size_t frame;
    double right_of_right, right_of_forward, forward_of_right, forward_of_forward;
    double step_right, step_down, step_forward;  // from the other's centre to this one's, in the other's axes
    Witness(size_t frame, const UprightCamera& from, const UprightCamera& to, const Eigen::Vector3d& down);
    kernels::ToWitness from_column(const UprightCamera& from, const UprightCamera& to, int x, const VisibilityMap& own,
                                   const VisibilityMap& other) const;
  };

  const std::vector<UprightFrame>& frames_;
  int columns_apart_;
  std::vector<std::vector<Witness>> witnesses_;  // of each frame, nearest first
};

}  // namespace ldp::layers
