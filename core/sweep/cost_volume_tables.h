// What a CostVolume keeps between calls.
#pragma once

#include <optional>
#include <vector>

#include "core/base/scratch_pool.h"
#include "core/sweep/cost_slab.h"
#include "core/sweep/cost_volume.h"
#include "core/sweep/points_prior.h"
#include "core/sweep/voxel_lines.h"

namespace ldp::sweep {

// Buffers of one thread inside read or refine.
struct SweepScratch {
  SlabScratch slab;
  std::vector<uint8_t> best, best_median, contrast;  // of the label at hand
  std::vector<uint8_t> least, contrast_at_least;     // of all labels
};

}  // namespace ldp::sweep

namespace ldp {

struct CostVolume::Tables {
  const std::vector<UprightFrame>& frames;
  PanoramaGrid grid;
  const DisparityMap* behind = nullptr;  // null = nothing is in front
  SweepOptions options;
  sweep::LineTable lines;
  std::optional<sweep::PointsPrior> points;
  int longest_column = 0;

  ScratchPool<sweep::SweepScratch> pool;

  // Per row from y_begin on, a bit for each label whose middle at least two cameras have inside their photos.
  void labels_seen_twice(int column, int y_begin, std::vector<uint16_t>& labels) const;

  double disparity(double label) const { return label * kDisparitySteps / (options.labels - 1); }
};

}  // namespace ldp
