#include "core/view/mesh/frame_extension.h"

#include <algorithm>
#include <cmath>

#include "core/base/exact_math.h"

namespace ldp::view {
namespace {

constexpr double kInsidePx = 10;   // nearer to a photograph's border depths are unsure
constexpr int kWitnessedRows = 4;  // of a surface that goes on, which two photographs could show
constexpr int kRowStep = 4;        // of the rows that are asked for that
constexpr int kBridge = 64;        // columns to either side within which a surface that they do show stands by others
constexpr float kBridgeShare = 0.1F;  // of its inverse depth by which the other may differ
constexpr int kMostMirrored = 160;    // rows of a surface that its continuation shows again, there and back
constexpr double kMostOfRows = 0.5;   // of the panorama's, that are made up at either end

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

  PreparedLayer extended() {
    for (int x = 0; x < front_.w.width; ++x) extend_column(x);
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

  void extend_column(int x) {
    for (int y = 0; y < grid_.height; ++y)
      if (ends(x, y))
        if (const int rows = rows_beyond(x, y); rows > 0) pieces_.push_back({x, y, rows, witnessed(x, y)});
  }

  bool ends(int x, int y) const {
    const float own = front_.w.at(x, y);
    if (own <= 0) return false;
    const int next = y + step_;
    if (next < 0 || next >= grid_.height || front_.w.at(x, next) < 0) return true;
    return front_.w.at(x, next) < own && !same_surface(x, y, next);
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
  bool witnessed(int x, int y) const {
    const double w = front_.w.at(x, y);
    for (int i = 0, own = own_rows(x, y), rows = 0; i < own; i += kRowStep) {
      if (frames_.showing(grid_.point(grid_.theta(x + 0.5), grid_.v(y - step_ * i + 0.5), w), 2)) rows += kRowStep;
      if (rows >= kWitnessedRows) return true;
    }
    return false;
  }

  int rows_beyond(int x, int y) const {
    const double w = front_.w.at(x, y);
    const int most = most_rows(w);
    int rows = 0;
    while (rows < most &&
           !frames_.showing(grid_.point(grid_.theta(x + 0.5), grid_.v(y + step_ * (rows + 1) + 0.5), w), 1))
      ++rows;
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
  bool has_witness(size_t own, std::ptrdiff_t side) const {
    const float w = front_.w.at(pieces_[own].x, pieces_[own].from);
    for (size_t i = own + static_cast<size_t>(side); i < pieces_.size(); i += static_cast<size_t>(side)) {
      const Piece& other = pieces_[i];
      if (std::abs(other.x - pieces_[own].x) > kBridge) return false;
      const float there = front_.w.at(other.x, other.from);
      if (other.witnessed && std::abs(there - w) < kBridgeShare * w) return true;
    }
    return false;
  }

  PreparedLayer layer() const {
    PreparedLayer made;
    if (pieces_.empty()) return made;
    int first = grid_.height, last = 0;
    for (const Piece& p : pieces_) {
      const int end = p.from + step_ * p.rows;
      first = std::min({first, p.from, end});
      last = std::max({last, p.from, end});
    }
    const int rows = last - first + 1, columns = front_.w.width;
    made = {Plane<float>(columns, rows, kAbsent), Plane<Rgba>(columns, rows),
            Plane<uint16_t>(columns, rows, kNoDisparity), Plane<uint8_t>(columns, rows), first};
    for (const Piece& p : pieces_) fill(p, made);
    return made;
  }

  void fill(const Piece& p, PreparedLayer& made) const {
    const float w = front_.w.at(p.x, p.from);
    const int own = own_rows(p.x, p.from);
    for (int i = 0; i <= p.rows; ++i) {
      const int row = p.from + step_ * i - made.top, phase = i % (2 * own),
                mirrored = p.from - step_ * std::min(phase, 2 * own - 1 - phase);
      if (made.w.at(p.x, row) >= w) continue;
      made.w.at(p.x, row) = w;
      made.code.at(p.x, row) = front_.code.at(p.x, p.from);
      made.step.at(p.x, row) = front_.step.at(p.x, p.from);
      made.colour.at(p.x, row) = front_.colour.at(p.x, mirrored);
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

std::vector<PreparedLayer> extend_beyond_frames(const PreparedLayer& front, const CodedDepths& depths,
                                                const LayeredPanorama& panorama, float parallax) {
  std::vector<PreparedLayer> made;
  if (panorama.cameras.empty()) return made;
  for (const int step : {-1, 1}) {
    PreparedLayer end = End(front, depths, panorama, parallax, step).extended();
    if (!end.w.empty()) made.push_back(std::move(end));
  }
  return made;
}

}  // namespace ldp::view
