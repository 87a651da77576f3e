// What a build will take, told before it: processor time, memory, bytes of the file.
//
// How: the photographs are posed as they are, and the rest is built of them scaled down to some 80,000 pixels each. So
// the sweep's own motion, depths and layers, and the speed of the machine at the moment, are in the figures; what a
// photograph's pixels do to each part of them is in estimate_tuning.h. Memory is what the build itself compares
// with what it may take (core/pipeline/memory_budget.h), for the grid that the small one tells.
#pragma once

#include <cstddef>
#include <optional>

#include "core/base/job.h"
#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"
#include "core/pipeline/build.h"

namespace ldp {

struct BuildEstimate {
  double processor_seconds = 0;  // of all threads together, on this machine
  size_t memory_bytes = 0;       // of the process, at its peak
  size_t scratch_bytes = 0;      // of files without names beside the output, where memory is not enough
  size_t file_bytes = 0;         // of the .ldp file
  int width = 0, height = 0;     // of the panorama
  double spent_seconds = 0;      // of the processors, on the estimate itself
};

// Of the frames as the build would load them, with its options; without a quality of that which the small panorama asks
// for. Throws as build() does.
BuildEstimate estimate_build(const FrameSource& frames, const BuildOptions& options, std::optional<int> colour_quality,
                             const Job& job);

}  // namespace ldp
