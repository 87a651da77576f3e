// Tracks: one thing seen by several frames, joined from pairwise matches (track merging).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/poses/features/descriptor_matching.h"
#include "core/poses/features/features.h"

namespace ldp::sfm {

struct PairMatches {
  int a = 0, b = 0;  // frames
  std::vector<Match> matches;
};

struct Observation {
  int frame = 0;
  int feature = -1;                                       // -1: not a feature but tracked (klt_tracking.h)
  Eigen::Vector2d position_px = Eigen::Vector2d::Zero();  // in the photograph, from its middle
  double weight = 1;                                      // inverse deviation, against that of a feature
};

using Track = std::vector<Observation>;  // sorted by frame, one observation per frame, at least two

// Joins matches, the most alike first; a match that would put two different places of one frame into a track is left
// out.
std::vector<Track> build_tracks(const std::vector<Features>& features, const std::vector<PairMatches>& pairs);

// Which of grid x grid cells of a photo a place is in, row by row.
size_t grid_cell(const Eigen::Vector2d& from_middle_px, const Features& photo, int grid);

// Longest tracks first, until each of grid x grid cells of every frame has its share of `per_frame`, or all there are.
std::vector<Track> longest_tracks(std::vector<Track> tracks, const std::vector<Features>& frames, int per_frame,
                                  int grid);

}  // namespace ldp::sfm
