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
#include "core/base/memory/scratch_space.h"
#include "core/consistency/consistency.h"
#include "core/geometry/geometry.h"
#include "core/panorama/panorama.h"
#include "core/photos/frame_source.h"
#include "core/pipeline/effort.h"
#include "core/poses/poses.h"
#include "core/solve/solve.h"
#include "core/verdict/evidence.h"
#include "core/verdict/sweep_quality.h"

namespace ldp {

constexpr size_t kEasyMemory = 128 << 20;  // bytes that every board has to spare

struct BuildOptions {
  int layers = 3;   // 1 .. 8
  int labels = 16;  // 2 .. 16
  Effort effort = Effort::standard;
  // 1 .. 4, or 0 = as many as the effort says. From the second on, what the one before found hides voxels from cameras;
  // of the last two, the photographs choose place by place.
  int iterations = 0;
  Rays rays = Rays::pushbroom;
  int block_px = 8;                      // of the depth codes; 0 = uniform codes
  double near_depth = 0, far_depth = 0;  // capture's unit; 0 = from the points
  // Of the whole process from the poses on; what is beyond it goes to scratch_directory or, where even that is not
  // enough, the panorama is coarser. 0: no coarser than the effort and a file ask for, but beyond kEasyMemory large
  // arrays go to scratch_directory.
  size_t memory_bytes = 0;
  std::string scratch_directory;  // a writable folder; empty = everything stays in memory
  PosesOptions poses;
  std::vector<Camera> cameras;  // empty = estimate
  std::string debug_directory;  // empty = no pictures
};

int iterations_of(const BuildOptions& options);

struct SolveEntry {
  std::string name;  // "depth layer 1 iteration 2", "colour layer 1"
  SolveReport report;
};

// What memory is needed for (memory_budget.h): the grid on which depths are found, before what no photo sees is cut.
struct LaidGrid {
  int width = 0, height = 0, columns_of_colour = 1;  // the last to each of its columns
  size_t upright_px = 0;                             // of all upright photos together
};

struct BuildReport {
  std::vector<std::pair<std::string, double>> seconds;            // per stage, in order
  std::vector<std::pair<std::string, double>> processor_seconds;  // the same, over all threads
  std::vector<SolveEntry> solves;
  PosesReport poses;
  ArcFit arc;
  LaidGrid laid;
  std::vector<double> coverage;  // share of present pixels per layer
  // By photo: what its R, G, B were multiplied by to match the others; where exposure is local, of light.
  std::map<std::string, std::array<float, 3>> gains;
  ConsistencyReport consistency;  // the panorama against its photos
  SweepEvidence evidence;
  SweepQuality quality;            // the verdict; also in the panorama's figures
  std::vector<std::string> notes;  // one line each, e.g. "no parallax was found: one far layer"
};

struct BuildResult {
  std::unique_ptr<ScratchSpace> scratch;  // where the panorama's arrays may live; nullptr: in memory
  LayeredPanorama panorama;
  int colour_quality = 90;  // to encode it with: colours as exact as the photographs bear it out
  BuildReport report;
};

// Throws Impossible (too few frames connected, too little memory), Cancelled, std::runtime_error (unreadable frame),
// std::logic_error, also where large arrays of an earlier result are still in their files.
BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job);

// The same, to the byte, with poses that were begun while the photos were still being taken.
BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job, PoseEstimator begun);

// With poses that were found before, whatever cameras the options have; of at least 3 frames, in pixels of these
// frames.
BuildResult build(const FrameSource& frames, const BuildOptions& options, const Job& job, Poses found);

}  // namespace ldp
