// Positions taken in one photo, to tell at once whether another is near any of them (non-maximum suppression, duplicate
// tracks).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace ldp::sfm {

// Places are in pixels from the photo's middle. Cells are as wide as places are near, with one more all around, so that
// all that is near lies in nine of them.
class OccupancyGrid {
 public:
  OccupancyGrid(int width, int height, double near_px)
      : near_px_(near_px),
        width_(width),
        height_(height),
        columns_(static_cast<size_t>(width / near_px) + 3),
        cells_(columns_ * (static_cast<size_t>(height / near_px) + 3)) {}

  void add(const Eigen::Vector2d& p) { cells_[cell(p)].push_back(p); }

  bool near(const Eigen::Vector2d& p) const {
    const size_t at = cell(p);
    for (const size_t row : {at - columns_, at, at + columns_}) {
      for (size_t i = row - 1; i <= row + 1; ++i) {
        for (const Eigen::Vector2d& q : cells_[i]) {
          if ((p - q).squaredNorm() < near_px_ * near_px_) return true;
        }
      }
    }
    return false;
  }

 private:
  size_t cell(const Eigen::Vector2d& p) const {
    const double x = std::clamp(p.x() + 0.5 * width_, 0.0, width_), y = std::clamp(p.y() + 0.5 * height_, 0.0, height_);
    return (static_cast<size_t>(y / near_px_) + 1) * columns_ + static_cast<size_t>(x / near_px_) + 1;
  }

  double near_px_, width_, height_;
  size_t columns_;
  std::vector<std::vector<Eigen::Vector2d>> cells_;
};

}  // namespace ldp::sfm
