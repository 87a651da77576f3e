// Depth of a place in one photo by a search along its epipolar lines: the patch around it is correlated with the two
// photos nearest to it, over all the distances that anything is known to have.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "core/poses/features/patch_alignment.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {

class EpipolarSearch {
 public:
  // Points of tracks are the bundle's; what is given must outlive this.
  EpipolarSearch(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& bundle);

  // Whether the frame sees anything whose distance is known.
  bool sees_known_points(size_t frame) const { return !inverse_distances_[frame].empty(); }

  struct Found {
    bool compared = false;              // two photos may show it
    std::optional<InversePoint> point;  // it looks the same in both at one distance, and clearly less so at others
  };
  // A place in pixels from the photo's middle.
  Found search(size_t frame, const Eigen::Vector2d& position_px) const;

  Eigen::Vector2d from_picture(const Eigen::Vector2d& in_picture, size_t frame) const;

 private:
  using ViewPair = std::array<size_t, 2>;

  struct ViewingRay {
    size_t frame = 0;
    Eigen::Vector2d position_px;
    Eigen::Vector3d origin, direction;  // in the world, the direction of length 1
    InversePoint at(double inverse_distance) const;
  };
  struct InverseDistanceRange {
    double min = 0, median = 0, max = 0;  // inverse, from the camera
  };

  ViewingRay viewing_ray(size_t frame, const Eigen::Vector2d& position_px) const;
  InverseDistanceRange inverse_distance_range(size_t frame) const;
  Eigen::Vector2d middle(size_t frame) const;
  std::optional<Eigen::Vector2d> project_to_half(size_t frame, const InversePoint& point) const;
  std::optional<ViewPair> nearest_views(const ViewingRay& ray, double inverse_distance) const;
  Eigen::Matrix2d warp(const ViewingRay& ray, size_t frame, double inverse_distance) const;
  int step_count(const ViewingRay& ray, const ViewPair& others, const InverseDistanceRange& range) const;
  std::vector<double> correlations(const ViewingRay& ray, const Patch<kSearchPatchRadius_px>& here,
                                   const ViewPair& others, const InverseDistanceRange& range) const;

  const MatchedSweep& sweep_;
  const Bundle& bundle_;
  std::vector<GreyImage> halves_;                       // of the pictures
  std::vector<std::vector<double>> inverse_distances_;  // of what each frame sees, sorted
};

}  // namespace ldp::sfm
