#include "core/estimate/estimate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/processor_time.h"
#include "core/estimate/estimate_tuning.h"
#include "core/estimate/small_frames.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

using namespace estimate;  // tuned constants

struct SmallBuild {
  std::unique_ptr<SmallFrames> frames;
  BuildResult result;
  size_t file_bytes = 0;
  double loading_s = 0, encoding_s = 0;
};

double lap(double& last) {
  const double now = processor_seconds();
  return now - std::exchange(last, now);
}

SmallBuild build_small(const FrameSource& frames, const BuildOptions& options, const LdpEncodeOptions& encoding,
                       int64_t pixels, const Job& job) {
  SmallBuild small;
  double last = processor_seconds();
  small.frames = std::make_unique<SmallFrames>(frames, pixels, job);
  small.loading_s = lap(last);
  BuildOptions smaller = options;
  smaller.cameras = fitted(options.cameras, *small.frames);
  smaller.memory_bytes = 0;
  smaller.scratch_directory.clear();
  small.result = build(*small.frames, smaller, job);
  lap(last);
  small.file_bytes = encode_ldp(small.result.panorama, encoding, job).size();
  small.encoding_s = lap(last);
  return small;
}

// With photos as small as can be posed.
SmallBuild build_as_small_as_possible(const FrameSource& frames, const BuildOptions& options,
                                      const LdpEncodeOptions& encoding, const Job& job) {
  for (int64_t pixels = kSmallPixels;; pixels *= kMorePixels) {
    const RgbImage first = frames.load(0);
    try {
      return build_small(frames, options, encoding, pixels, job);
    } catch (const Impossible&) {
      if (pixels >= int64_t{first.width} * first.height) throw;
    }
  }
}

// Seconds of the build proper, from those of its parts in the small one.
double processor_seconds_of(const SmallBuild& small, double scale) {
  const SmallFrames& frames = *small.frames;
  const double working = std::min(1.0, 1.0 * kPosesSide_px / std::max(frames.full_width(), frames.full_height()));
  const double pixels = scale * scale, poses_pixels = std::max(1.0, pixels * working * working);
  double seconds = kLoads * small.loading_s + small.encoding_s * pixels;
  for (const auto& [stage, worked] : small.result.report.processor_seconds)
    seconds += worked * (stage == "poses" ? std::pow(poses_pixels, kPosesGrowth) : pixels);
  return seconds;
}

// What the build would hold, on a grid whose rows span `pitch` of those it would have without a limit of memory.
ExpectedMemory memory_of(const SmallBuild& small, double scale, double pitch, int layers) {
  const LaidGrid& laid = small.result.report.laid;
  PanoramaGrid grid;
  grid.width = static_cast<int>(laid.width * scale / pitch),
  grid.height = static_cast<int>(laid.height * scale / pitch);
  const double upright_px = static_cast<double>(laid.upright_px) * (scale / pitch) * (scale / pitch);
  const auto photo_px =
      static_cast<size_t>(small.frames->full_width()) * static_cast<size_t>(small.frames->full_height());
  return expected_memory(grid, laid.columns_of_colour, photo_px, static_cast<size_t>(upright_px), layers);
}

}  // namespace

BuildEstimate estimate_build(const FrameSource& frames, const BuildOptions& options, const LdpEncodeOptions& encoding,
                             const Job& job) {
  const double begun = processor_seconds();
  const SmallBuild small = build_as_small_as_possible(frames, options, encoding, job);
  const size_t allowed = options.memory_bytes > 0 ? options.memory_bytes : kEasyMemory;
  double pitch = 1;
  ExpectedMemory needed = memory_of(small, small.frames->scale(), pitch, options.layers);
  while (options.memory_bytes > 0 && needed.least > allowed && pitch < pipeline::kCoarsest) {
    pitch *= pipeline::kCoarser;
    needed = memory_of(small, small.frames->scale(), pitch, options.layers);
  }
  const double scale = small.frames->scale() / pitch;
  BuildEstimate estimate;
  estimate.processor_seconds = processor_seconds_of(small, scale);
  const bool in_files = needed.all > allowed && !options.scratch_directory.empty();
  estimate.memory_bytes = in_files ? std::max(needed.least, allowed) : needed.all;
  estimate.scratch_bytes = in_files ? needed.all - needed.least : 0;
  estimate.file_bytes =
      static_cast<size_t>(static_cast<double>(small.file_bytes) * std::pow(scale * scale, kFileGrowth));
  estimate.width = static_cast<int>(std::lround(small.result.panorama.grid.width * scale));
  estimate.height = static_cast<int>(std::lround(small.result.panorama.grid.height * scale));
  estimate.spent_seconds = processor_seconds() - begun;
  return estimate;
}

}  // namespace ldp
