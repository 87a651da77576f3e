#include "core/estimate/estimate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/processor_time.h"
#include "core/estimate/estimate_tuning.h"
#include "core/estimate/small_frames.h"
#include "core/panorama/file/ldp_file.h"
#include "core/pipeline/grid_layout.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/pipeline_tuning.h"

namespace ldp {
namespace {

using namespace estimate;  // tuned constants

// What is asked for, and the poses of the photos as they are: scaled down they would be posed otherwise where steps are
// wide, or show parallax where there is none.
struct Posed {
  const FrameSource& frames;
  const BuildOptions& options;
  std::optional<int> colour_quality;
  Poses poses;
  double worked_s = 0;
};

struct SmallBuild {
  std::unique_ptr<SmallFrames> frames;
  BuildResult result;
  std::vector<LdpChunk> chunks;  // of its file
  double loading_s = 0, encoding_s = 0;
};

double lap(double& last) {
  const double now = processor_seconds();
  return now - std::exchange(last, now);
}

Posed pose(const FrameSource& frames, const BuildOptions& options, std::optional<int> colour_quality, const Job& job) {
  double last = processor_seconds();
  Posed posed{frames, options, colour_quality, {}};
  posed.poses = options.cameras.empty() ? estimate_poses(frames, options.poses, job)
                                        : triangulate(frames, options.cameras, options.poses, job);
  posed.worked_s = lap(last);
  return posed;
}

SmallBuild build_small(const Posed& posed, int64_t pixels, const Job& job) {
  SmallBuild small;
  double last = processor_seconds();
  small.frames = std::make_unique<SmallFrames>(posed.frames, posed.poses.frame_of_camera.front(), pixels, job);
  small.loading_s = lap(last);
  BuildOptions smaller = posed.options;
  smaller.memory_bytes = 0;
  smaller.scratch_directory.clear();
  small.result = build(*small.frames, smaller, job, fitted(posed.poses, *small.frames));
  lap(last);
  const int quality = posed.colour_quality.value_or(small.result.colour_quality);
  small.chunks = describe_ldp(encode_ldp(small.result.panorama, {quality}, job)).chunks;
  small.encoding_s = lap(last);
  return small;
}

// With photos as small as can be built of.
SmallBuild build_as_small_as_possible(const Posed& posed, const Job& job) {
  const Intrinsics& whole = posed.poses.cameras.front().intrinsics;
  for (int64_t pixels = kSmallPixels;; pixels *= kMorePixels) {
    try {
      return build_small(posed, pixels, job);
    } catch (const Impossible&) {
      if (pixels >= int64_t{whole.width} * whole.height) throw;
    }
  }
}

// Seconds of the build proper, from those of its parts after the poses in the small one.
double processor_seconds_of(const SmallBuild& small, double posing_s, double scale) {
  const double pixels = scale * scale;
  double seconds = posing_s + kLoads * small.loading_s + small.encoding_s * pixels;
  for (const auto& [stage, worked] : small.result.report.processor_seconds) seconds += worked * pixels;
  return seconds;
}

// Cameras, figures and thumbnail are as large in the small file.
size_t file_bytes_of(const SmallBuild& small, double scale) {
  const double pixels = scale * scale;
  double bytes = 0;
  for (const LdpChunk& chunk : small.chunks) {
    const double growth = chunk.type == "COLR" ? kColourGrowth : chunk.strip >= 0 ? kDepthGrowth : 0;
    bytes += static_cast<double>(chunk.length) * std::pow(pixels, growth);
  }
  return static_cast<size_t>(bytes);
}

// What the build would ask for, on a grid whose rows span `pitch` of those it would have without a limit.
GridNeeds needs_of(const SmallBuild& small, double pitch, const BuildOptions& options) {
  const double scale = small.frames->scale();
  const LaidGrid& laid = small.result.report.laid;
  PanoramaGrid grid;
  grid.width = static_cast<int>(laid.width * scale / pitch),
  grid.height = static_cast<int>(laid.height * scale / pitch);
  const double upright_px = static_cast<double>(laid.upright_px) * (scale / pitch) * (scale / pitch);
  const auto photo_px =
      static_cast<size_t>(small.frames->full_width()) * static_cast<size_t>(small.frames->full_height());
  const auto with = [&](int columns) {
    return GridNeeds{grid.width * columns, grid.height,
                     expected_memory(grid, columns, photo_px, static_cast<size_t>(upright_px), options.layers),
                     !options.scratch_directory.empty()};
  };
  const GridNeeds needs = with(laid.columns_of_colour);
  return fit_of(needs, options.memory_bytes) == GridFit::fits ? needs : with(1);
}

// By how much the build would lay its grid coarser.
double pitch_of(const SmallBuild& small, const BuildOptions& options) {
  double pitch = 1;
  for (GridNeeds needs = needs_of(small, pitch, options); fit_of(needs, options.memory_bytes) != GridFit::fits;
       needs = needs_of(small, pitch, options)) {
    if (pitch * options_of(options.effort).pitch_px > pipeline::kCoarsest)
      throw Impossible(why_impossible(needs, options.memory_bytes));
    pitch *= pipeline::kCoarser;
  }
  return pitch;
}

}  // namespace

BuildEstimate estimate_build(const FrameSource& frames, const BuildOptions& options, std::optional<int> colour_quality,
                             const Job& job) {
  const double begun = processor_seconds();
  const Posed posed = pose(frames, options, colour_quality, job);
  const SmallBuild small = build_as_small_as_possible(posed, job);
  const size_t allowed = options.memory_bytes > 0 ? options.memory_bytes : kEasyMemory;
  const double pitch = pitch_of(small, options);
  const ExpectedMemory needed = needs_of(small, pitch, options).memory;
  const double scale = small.frames->scale() / pitch;
  BuildEstimate estimate;
  estimate.processor_seconds = processor_seconds_of(small, posed.worked_s, scale);
  const bool in_files = needed.all > allowed && !options.scratch_directory.empty();
  estimate.memory_bytes = in_files ? std::max(needed.least, allowed) : needed.all;
  estimate.scratch_bytes = in_files ? needed.all - needed.least : 0;
  estimate.file_bytes = file_bytes_of(small, scale);
  estimate.width = static_cast<int>(std::lround(small.result.panorama.grid.width * scale));
  estimate.height = static_cast<int>(std::lround(small.result.panorama.grid.height * scale));
  estimate.spent_seconds = processor_seconds() - begun;
  return estimate;
}

}  // namespace ldp
