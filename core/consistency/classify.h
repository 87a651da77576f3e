// What each pixel of one photograph says of the panorama, asked of the photographs beside it.
#pragma once

#include <array>
#include <vector>

#include "core/base/plane.h"
#include "core/consistency/consistency.h"
#include "core/consistency/held.h"
#include "core/consistency/surroundings.h"
#include "core/geometry/geometry.h"

namespace ldp::consistency {

constexpr int kCellPx = 32;         // statistics are gathered by cells of the photograph
constexpr size_t kPatchPixels = 5;  // what is looked for at other depths
constexpr size_t kMostBeside = 2;   // photographs that are asked

// Median absolute difference in grey where the photograph is plain.
double plain_noise(const RgbImage& photo, const Rendering& rendering);

class Classifier {
 public:
  // `beside` are the photographs that are asked, at most kMostBeside. `most_inverse_z`: of the depths that are tried.
  Classifier(const Held& own, const Rendering& rendering, const std::vector<const Held*>& beside, double most_inverse_z,
             int tolerance, int most_depths);

  // Of one cell: its statistics, and every second of its pixels in `map`, which is half as large as the photograph.
  ResidualStatistics cell(int x0, int y0, Plane<uint8_t>& map) const;

 private:
  // Where another camera sees what lies along a ray of this one at an inverse z.
  struct Seen {
    bool inside = false;
    int x = 0, y = 0;
    double z = 0;  // times inverse z, as is what follows it
  };
  struct View {
    const Held* held;
    std::array<double, 9> turn;  // this camera's axes to the other's
    std::array<double, 3> step;  // own centre in the other's axes
  };
  struct Offset {
    std::array<int, 3> median{};
  };
  using Patch = std::array<Surroundings, kPatchPixels>;
  using Rays = std::array<Eigen::Vector3d, kMostBeside>;  // one (z = 1), in the axes of each of the others

  // `first`: what was found in the first pixel of its square, which what differs too takes over; or null.
  Agreement classify(int x, int y, const Offset& brightness, const Agreement* first) const;
  int depths_to_try() const;
  Agreement ask_others(int x, int y, const Surroundings& own) const;
  // Whether either pixel's colour occurs around the other: half a pixel's shift is no disagreement.
  bool agree(const Surroundings& a, const Surroundings& b) const;
  Offset median_difference(int x0, int y0) const;
  Eigen::Vector3d turned(const View& view, const Eigen::Vector3d& ray) const;
  Seen look(const View& view, const Eigen::Vector3d& turned_ray, double inverse_z) const;
  bool visible(const View& view, const Seen& seen, double inverse_z) const;
  bool patches_agree(const Patch& patch, const Rays& rays, double inverse_z) const;

  const Held& own_;
  const Rendering& rendering_;
  std::vector<View> views_;
  double most_inverse_z_;
  int tolerance_, most_depths_;
};

}  // namespace ldp::consistency
