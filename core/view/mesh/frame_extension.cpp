#include "core/view/mesh/frame_extension.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/exact_math.h"
#include "core/view/view_tuning.h"

namespace ldp::view {
namespace {

// How many photographs could show a place.
class Frames {
 public:
  explicit Frames(const std::vector<Camera>& cameras) : cameras_(cameras) {}
  // Whether at least so many could.
  bool showing(const Eigen::Vector3d& place, int least) const {
    for (const Camera& camera : cameras_)
      if (inside(camera, place) && --least == 0) return true;
    return false;
  }

 private:
  static bool inside(const Camera& camera, const Eigen::Vector3d& place) {
    const Eigen::Vector3d x = exact_transposed_product(camera.pose.world_from_camera, place - camera.pose.centre);
    if (x.z() <= 0) return false;
    const Intrinsics& k = camera.intrinsics;
    const Eigen::Vector2d at = project(k, x);
    return at.x() >= kInsidePx && at.y() >= kInsidePx && at.x() <= k.width - kInsidePx &&
           at.y() <= k.height - kInsidePx;
  }

  const std::vector<Camera>& cameras_;
};

// Places of one column of the panorama.
class Column {
 public:
  Column(const PanoramaGrid& grid, int x)
      : grid_(grid), origin_(grid.origin(grid.theta(x + 0.5))), outward_(grid.arc.outward(grid.theta(x + 0.5))) {}
  Eigen::Vector3d place(int y, double w) const {
    return origin_ + (outward_ + grid_.v(y + 0.5) * grid_.arc.axis()) / w;
  }

 private:
  const PanoramaGrid& grid_;
  Eigen::Vector3d origin_, outward_;
};

// One end of the columns: `step` is -1 upwards, 1 downwards.
class End {
 public:
  End(const PreparedLayer& front, const CodedDepths& depths, const LayeredPanorama& panorama, float parallax, int step)
      : front_(front),
        depths_(depths),
        grid_(panorama.grid),
        frames_(panorama.cameras),
        parallax_(parallax),
        step_(step) {
    const ViewingLimits& limits = panorama.limits;
    back_ = std::max(0.0, grid_.ray_radius() - limits.inner_radius);
    height_ = limits.height;
  }

  SparseColumns extended() {
    for (const auto& [x, y] : ends()) extend(x, y);
    drop_unwitnessed();
    return layer();
  }

 private:
  struct Piece {
    int x = 0, from = 0, rows = 0;  // from: the surface's own last row; rows beyond it
    bool witnessed = false;
  };

  // Rows by which a camera within the viewing limits sees farther up (or down) at inverse depth w than one on the arc.
  int most_rows(double w) const {
    const double half = 0.5 * grid_.v_pitch * grid_.height;
    const double rows = w * (half * back_ + height_) / grid_.v_pitch;
    return static_cast<int>(std::min(rows, kMostOfRows * grid_.height));
  }

  // Column by column; looked for row by row, as they lie in memory.
  std::vector<std::pair<int, int>> ends() const {
    std::vector<std::pair<int, int>> found;
    for (int y = 0; y < grid_.height; ++y)
      for (int x = 0; x < front_.w.width; ++x)
        if (ends(x, y)) found.emplace_back(x, y);
    std::sort(found.begin(), found.end());
    return found;
  }

  void extend(int x, int y) {
    const Column column(grid_, x);
    if (const int rows = rows_beyond(column, x, y); rows > 0) pieces_.push_back({x, y, rows, witnessed(column, x, y)});
  }

  bool ends(int x, int y) const {
    const float own = front_.w.at(x, y);
    if (own <= 0) return false;
    const int next = y + step_;
    if (next < 0 || next >= grid_.height || front_.w.at(x, next) < 0) return true;
    // (Smoothing moves depths within what codes leave unknown: what is no farther is of the same surface.)
    return front_.w.at(x, next) < own - parallax_ && !same_surface(x, y, next);
  }

  bool same_surface(int x, int y, int other) const {
    if (other < 0 || other >= grid_.height) return false;
    const auto w = [&](int row) { return depths_.w(front_.code.at(x, row)); };
    const auto step = [&](int row) { return depths_.step(front_.step.at(x, row)); };
    return connected(w(y), step(y), w(other), step(other), parallax_);
  }

  // Of the surface that ends here, up to kMostMirrored.
  int own_rows(int x, int y) const {
    int rows = 1;
    while (rows < kMostMirrored && same_surface(x, y - step_ * (rows - 1), y - step_ * rows)) ++rows;
    return rows;
  }

  // Whether two photographs could show this surface, not only its end: what one alone shows may have any depth.
  bool witnessed(const Column& column, int x, int y) const {
    const double w = front_.w.at(x, y);
    for (int i = 0, own = own_rows(x, y), rows = 0; i < own; i += kRowStep) {
      if (frames_.showing(column.place(y - step_ * i, w), 2)) rows += kRowStep;
      if (rows >= kWitnessedRows) return true;
    }
    return false;
  }

  int rows_beyond(const Column& column, int x, int y) const {
    const double w = front_.w.at(x, y);
    const int most = most_rows(w);
    int rows = 0;
    while (rows < most && !frames_.showing(column.place(y + step_ * (rows + 1), w), 1)) ++rows;
    return rows;
  }

  // What no two photographs show stays where it stands between two parts, on one surface, that they do.
  void drop_unwitnessed() {
    std::vector<Piece> kept;
    for (size_t i = 0; i < pieces_.size(); ++i)
      if (pieces_[i].witnessed || (has_witness(i, -1) && has_witness(i, 1))) kept.push_back(pieces_[i]);
    pieces_ = std::move(kept);
  }

  // Whether pieces to one side of a piece, within kBridge columns, have one on its surface that is witnessed.
  bool has_witness(size_t own, int side) const {
    const float w = front_.w.at(pieces_[own].x, pieces_[own].from);
    const auto count = static_cast<std::ptrdiff_t>(pieces_.size());
    for (auto i = static_cast<std::ptrdiff_t>(own) + side; i >= 0 && i < count; i += side) {
      const Piece& other = pieces_[static_cast<size_t>(i)];
      const int columns = side * (other.x - pieces_[own].x);
      if (columns > kBridge) return false;
      const float there = front_.w.at(other.x, other.from);
      if (columns > 0 && other.witnessed && std::abs(there - w) < kBridgeShare * w) return true;
    }
    return false;
  }

  SparseColumns layer() const {
    std::vector<SparseColumns::Rows> rows(static_cast<size_t>(front_.w.width));
    for (const Piece& p : pieces_) {
      rows[static_cast<size_t>(p.x)].include(p.from);
      rows[static_cast<size_t>(p.x)].include(p.from + step_ * p.rows);
    }
    SparseColumns made(std::move(rows));
    for (const Piece& p : pieces_) fill(p, made);
    return made;
  }

  void fill(const Piece& p, SparseColumns& made) const {
    const float w = front_.w.at(p.x, p.from);
    const int own = own_rows(p.x, p.from);
    for (int i = 0; i <= p.rows; ++i) {
      SparsePixel& pixel = made.slot(p.x, p.from + step_ * i);
      if (pixel.w >= w) continue;
      const int phase = i % (2 * own), mirrored = p.from - step_ * std::min(phase, 2 * own - 1 - phase);
      pixel = {w, front_.colour.at(p.x, mirrored), front_.code.at(p.x, p.from), front_.step.at(p.x, p.from)};
    }
  }

  const PreparedLayer& front_;
  const CodedDepths& depths_;
  const PanoramaGrid& grid_;
  const Frames frames_;
  const float parallax_;
  const int step_;
  double back_ = 0, height_ = 0;
  std::vector<Piece> pieces_;
};

}  // namespace

std::vector<SparseColumns> extend_beyond_frames(const PreparedLayer& front, const CodedDepths& depths,
                                                const LayeredPanorama& panorama, float parallax) {
  std::vector<SparseColumns> made;
  if (panorama.cameras.empty()) return made;
  for (const int step : {-1, 1}) {
    SparseColumns end = End(front, depths, panorama, parallax, step).extended();
    if (!end.empty()) made.push_back(std::move(end));
  }
  return made;
}

}  // namespace ldp::view
