// From a capture to a layered depth panorama: the one function that states the order of the stages.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/arc/arc.h"
#include "core/base/job.h"
#include "core/base/scratch_space.h"
#include "core/consistency/consistency.h"
#include "core/geometry/geometry.h"
#include "core/panorama/panorama.h"
#include "core/photos/frame_source.h"
#include "core/poses/poses.h"
#include "core/solve/solve.h"
#include "core/verdict/evidence.h"
#include "core/verdict/sweep_quality.h"

namespace ldp {

constexpr size_t kEasyMemory = 128 << 20;  // bytes that every board has to spare

struct BuildOptions {
  int layers = 3;   // 1 .. 8
  int labels = 16;  // 2 .. 16
  // 1 .. 4. From the second on, what the one before found hides voxels from cameras; of the last two, the photographs
  // choose place by place.
  int iterations = 2;
  Rays rays = Rays::pushbroom;
  int block_px = 16;                     // of the depth codes; 0 = uniform codes
  double near_depth = 0, far_depth = 0;  // capture's unit; 0 = from the points
  // Of the whole process from the poses on; what is beyond it goes to scratch_directory or, where even that is not
  // enough, the panorama is coarser. 0: never coarser, but beyond kEasyMemory large arrays go to scratch_directory.
  size_t memory_bytes = 0;
  std::string scratch_directory;  // a writable folder; empty = everything stays in memory
  PosesOptions poses;
  std::vector<Camera> cameras;  // empty = estimate
  std::string debug_directory;  // empty = no pictures
};

struct SolveEntry {
  std::string name;  // "depth layer 1 iteration 2", "colour layer 1"
  SolveReport report;
};

struct BuildReport {
  std::vector<std::pair<std::string, double>> seconds;  // per stage, in order
  std::vector<SolveEntry> solves;
  PosesReport poses;
  ArcFit arc;
  std::vector<double> coverage;  // share of present pixels per layer
  // By photo: what its R, G, B were multiplied by to match the others.
  std::map<std::string, std::array<float, 3>> gains;
  ConsistencyReport consistency;  // the panorama against its photos
  SweepEvidence evidence;
  SweepQuality quality;            // the verdict; also in the panorama's figures
  std::vector<std::string> notes;  // one line each, e.g. "no parallax was found: one far layer"
};

struct BuildResult {
  std::unique_ptr<ScratchSpace> scratch;  // where the panorama's arrays may live; nullptr: in memory
  LayeredPanorama panorama;
  BuildReport report;
};

// Throws Impossible (too few frames connected, too little memory), Cancelled, std::runtime_error (unreadable frame),
// std::logic_error, also where large arrays of an earlier result are still in their files.
BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job);

// The same, to the byte, with poses that were begun while the photos were still being taken.
BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job, PoseEstimator begun);

}  // namespace ldp
