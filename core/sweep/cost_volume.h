// The cylinder sweep's cost volume: matching cost phi and median grey mu of each (theta, v, label); paper 3.2, integer.
//
// Takes upright frames, the grid, and optionally what hides voxels from cameras and feature points that tell of plain
// parts (points_prior.h); gives a CostSource that computes any window when asked. Integer from samples to costs, and
// coarsely rounded from points: same bytes on every machine. Does not choose labels.
#pragma once

#include <memory>
#include <vector>

#include "core/base/cost_source.h"
#include "core/base/job.h"
#include "core/geometry/disparity.h"
#include "core/geometry/geometry.h"
#include "core/geometry/visibility_map.h"
#include "core/photos/upright_frame.h"

namespace ldp::sweep {
struct SweepScratch;
}

namespace ldp {

struct SweepOptions {
  int labels = kLabels;
  int substeps = 8;     // depths tried inside each label's interval, the best kept
  int prior_cost = 36;  // phi of a voxel that one camera sees, in 1/kCostScale grey levels
  // A label that fewer than two cameras see costs at most `margin` more than the ray's best match, and at most
  // `unmatched_cost`, which is what a good match costs.
  int margin = 2, unmatched_cost = 8;
  // Feature points that tell of plain parts of the front layer (points_prior.h); nullptr = none. Not kept.
  const std::vector<ScenePoint>* points = nullptr;
};

class CostVolume final : public CostSource {
 public:
  // `visibility` is empty (everything is visible) or has one map per frame. `behind` is empty, or gives for each pixel
  // the disparity of the layers in front: labels at or in front of it get cost 255 (at disparity 0 all of them: such
  // pixels cost no time). What is referred to and not empty must outlive the sweep.
  CostVolume(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid,
             const std::vector<VisibilityMap>& visibility, const DisparityMap& behind, const SweepOptions& options);
  ~CostVolume() override;
  int width() const override;
  int height() const override;
  int labels() const override;
  bool wraps() const override;
  void read(const Window& window, uint8_t* cost, uint8_t* median) const override;

  // See the free function.
  DisparityMap refine(const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Job& job) const;

 private:
  std::vector<int8_t> labels_behind(const Window& window) const;
  static Window part_with_label(const Window& window, const std::vector<int8_t>& nearest, int label);
  void forbid_front(const std::vector<int8_t>& nearest, uint8_t* cost, uint8_t* median) const;
  void rate_unmatched(const Window& window, uint8_t* cost) const;
  void equal_where_plain(const sweep::SweepScratch& found, size_t pixels, uint8_t* cost) const;
  void draw_to_points(const sweep::SweepScratch& found, const Window& window, uint8_t* cost) const;
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

// Disparity to sub-label precision: for every pixel of `labels` the best of the fine steps inside its label's interval
// (and up to half an interval into its neighbours' where the cost is lower), then smoothed within surfaces, with
// outlines moved to the image's edges. Pixels where `mask` is 0 get kNoDisparity (empty mask: none).
DisparityMap refine(const CostVolume& sweep, const Plane<uint8_t>& labels, const Plane<uint8_t>& mask, const Job& job);

// How near things come that no feature point told of (leaves, chair backs, sleeves): the inverse depth that holds what,
// in a part of the grid's columns, matches nearer than its range and nowhere within it. grid.w_near where hardly
// anything does; at most 1.5 times it, since labels are so few.
double matched_near(const std::vector<UprightFrame>& frames, const PanoramaGrid& grid, const Job& job);

}  // namespace ldp
