// Epipolar search for how far a place of one photo is: what is around it is compared with the two photos nearest to it,
// along its line of sight, over all the distances that anything is known to have.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "core/poses/features/patch_alignment.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/match_graph.h"

namespace ldp {

constexpr int kSightMargin = 12;  // pixels of the picture between a place that is compared and the border

class AlongSight {
 public:
  // Points of tracks are the bundle's; what is given must outlive this.
  AlongSight(const MatchedSweep& sweep, const std::vector<Track>& tracks, const Bundle& bundle);

  // Whether the frame sees anything whose distance is known.
  bool knows(size_t frame) const { return !inverse_distances_[frame].empty(); }

  struct Found {
    bool compared = false;              // two photos may show it
    std::optional<InversePoint> point;  // it looks the same in both at one distance, and clearly less so at others
  };
  // A place in pixels from the photo's middle.
  Found find(size_t frame, const Eigen::Vector2d& position_px) const;

  Eigen::Vector2d from_picture(const Eigen::Vector2d& in_picture, size_t frame) const;

 private:
  static constexpr int kPatch = 5;  // 11 x 11 pixels of half the picture's size are compared
  using Others = std::array<size_t, 2>;

  struct Sight {
    size_t frame = 0;
    Eigen::Vector2d position_px;
    Eigen::Vector3d start, ray;  // in the world, the ray of length 1
    InversePoint at(double inverse_distance) const;
  };
  struct Distances {
    double least = 0, usual = 0, most = 0;  // inverse, from the camera
  };

  Sight sight_through(size_t frame, const Eigen::Vector2d& position_px) const;
  Distances distances(size_t frame) const;
  Eigen::Vector2d middle(size_t frame) const;
  std::optional<Eigen::Vector2d> in_half(size_t frame, const InversePoint& point) const;
  std::optional<Others> beside(const Sight& sight, double inverse_distance) const;
  Eigen::Matrix2d warp(const Sight& sight, size_t frame, double inverse_distance) const;
  int steps(const Sight& sight, const Others& others, const Distances& range) const;
  std::vector<double> likeness(const Sight& sight, const Patch<kPatch>& here, const Others& others,
                               const Distances& range) const;

  const MatchedSweep& sweep_;
  const Bundle& bundle_;
  std::vector<GreyImage> halves_;                       // of the pictures
  std::vector<std::vector<double>> inverse_distances_;  // of what each frame sees, sorted
};

}  // namespace ldp
