// Evidence of a finished panorama's quality: how the panorama rendered into each photograph, and the photograph beside
// it, compare with it (virtual rephotography, Waechter et al. 2017).
//
// Made before there is a panorama; looks on while that is held against its photographs, so that each is rendered once.
#pragma once

#include <memory>
#include <vector>

#include "core/base/job.h"
#include "core/consistency/held.h"
#include "core/panorama/panorama.h"
#include "core/photos/exposure_gain.h"
#include "core/verdict/evidence.h"

namespace ldp {

class Rephotography : public consistency::Observer {
 public:
  // Sets `evidence.photos`, one for each of the cameras, which are in the order of the sweep, and where directions
  // begin; what poses tell otherwise is left as it is. Gains are those of the cameras. Refers to `job` and `evidence`.
  Rephotography(const PanoramaGrid& grid, const std::vector<Camera>& cameras, const std::vector<Gain>& gains,
                const Job& job, SweepEvidence& evidence);
  ~Rephotography() override;

  void rendered(size_t camera, const consistency::Held& own, const consistency::Rendering& rendering,
                const consistency::Held* before) override;

 private:
  class Columns;

  const Job& job_;
  SweepEvidence& evidence_;
  std::unique_ptr<Columns> columns_;
};

}  // namespace ldp
