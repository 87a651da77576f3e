// Fuses depth maps: which of two the photographs contradict less, place by place. (Fusion of proposals, Lempitsky et
// al. 2010, chosen by what every camera sees under both instead of by an energy of rays: only so does a surface pay for
// what it hides.)
//
// Takes a dense layer, and other depth maps on its grid as proposals, one after another. Does not make proposals.
#pragma once

#include <vector>

#include "core/base/job.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/layers/painting/map_painter.h"
#include "core/layers/painting/photo_consistency.h"
#include "core/photos/upright_frame.h"

namespace ldp {

class ProposalFusion {
 public:
  // Both must outlive it. Of the cameras' columns 0, columns_apart, 2 columns_apart ... are compared.
  ProposalFusion(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, int columns_apart);

  // Where `proposal` has another surface than the layer, the layer takes it over if the photographs, compared with each
  // other over both, contradict it less, by the more the rougher it is: summed over the pixels within `reach_px` of it,
  // both ways, that would come nearer, or of those that would go farther, as it does.
  void fuse(const DisparityMap& proposal, int reach_px, const Job& job, DisparityMap& layer);

  // The same of a simpler map: the layer takes it over unless the photographs contradict it clearly more.
  void simplify(const DisparityMap& simpler, int reach_px, const Job& job, DisparityMap& layer);

 private:
  void take_over(const DisparityMap& proposal, int reach_px, int least_gain, const Job& job, DisparityMap& layer);
  Plane<uint8_t> changes(const DisparityMap& layer, const DisparityMap& proposal, const Job& job) const;
  Plane<int32_t> gains(const Plane<uint8_t>& changes, const DisparityMap& layer, const DisparityMap& proposal,
                       const Job& job);

  const PanoramaGrid& grid_;
  const std::vector<UprightFrame>& frames_;
  int columns_apart_;
  layers::PhotoConsistency photos_;
  layers::PaintedViews memory_;
};

}  // namespace ldp
