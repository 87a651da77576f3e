// Windows of matching make near surfaces a few pixels too wide: within them the strong edge decides. Here single
// pixels ask the photographs again, from the outline inwards.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/geometry/same_surface.h"
#include "core/geometry/voxel_projection.h"
#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"

namespace ldp::layers {
namespace {

using namespace tuning;

constexpr int kUnknown = -1;

struct Tone {
  int grey, tint;
};

int difference(const Tone& a, const Tone& b) {
  const int differ =
      std::max(0, std::abs(a.grey - b.grey) - kGreyNoise) + std::max(0, std::abs(a.tint - b.tint) - kTintNoise);
  return std::min(differ, kMostDiffer);
}

class OutlineFitter {
 public:
  OutlineFitter(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, DisparityMap& layer)
      : grid_(grid), frames_(frames), layer_(layer), one_surface_{static_cast<int>(parallax_steps(grid, kApartPx))} {
    for (const UprightFrame& frame : frames) projections_.emplace_back(grid, frame.camera);
    for (int x = 0; x < grid.width; ++x) {
      headings_.push_back(heading(grid.theta(x + 0.5)));
      facing_.push_back(cameras_at(headings_.back()));
    }
  }

  void run(const Job& job) {
    Plane<uint8_t> asked(layer_.width, layer_.height, 1);
    for (int round = 0; round < kReachPx; ++round) {
      const std::vector<Change> changes = find_changes(asked, job);
      if (changes.empty()) return;
      std::fill(asked.samples.begin(), asked.samples.end(), uint8_t{0});
      for (const Change& c : changes) {
        layer_.at(c.x, c.y) = c.disparity;
        for_window(c.x, c.y, [&](int x, int y) { asked.at(x, y) = 1; });
      }
    }
  }

 private:
  struct Change {
    int x, y;
    uint16_t disparity;
  };

  // Nearest to the rays first.
  std::vector<uint16_t> cameras_at(Heading h) const {
    std::vector<std::pair<double, uint16_t>> sorted;
    for (size_t i = 0; i < projections_.size(); ++i)
      if (projections_[i].column(h).forward > kLeastForward)
        sorted.emplace_back(std::abs(projections_[i].aside(h)), static_cast<uint16_t>(i));
    std::sort(sorted.begin(), sorted.end());
    std::vector<uint16_t> cameras;
    for (size_t i = 0; i < std::min<size_t>(kMostViews, sorted.size()); ++i) cameras.push_back(sorted[i].second);
    return cameras;
  }

  // The pixel and its neighbours, as far as they exist.
  template <class Use>
  void for_window(int x, int y, Use use) const {
    for (int dx = -1; dx <= 1; ++dx) {
      const int nx = neighbour_column(grid_, x + dx);
      if (nx < 0) continue;
      for (int ny = std::max(0, y - 1); ny <= std::min(y + 1, layer_.height - 1); ++ny) use(nx, ny);
    }
  }

  // All from the same state of the layer, so that threads do not matter.
  std::vector<Change> find_changes(const Plane<uint8_t>& asked, const Job& job) const {
    std::vector<std::vector<Change>> of_row(static_cast<size_t>(layer_.height));
    parallel_for(job, layer_.height, [&](int y) {
      for (int x = 0; x < layer_.width; ++x) {
        if (!asked.at(x, y) || layer_.at(x, y) == kNoDisparity) continue;
        const uint16_t farther = farther_neighbour(x, y);
        if (!one_surface_.same_surface(layer_.at(x, y), farther) && belongs_to(farther, x, y))
          of_row[static_cast<size_t>(y)].push_back({x, y, farther});
      }
    });
    std::vector<Change> changes;
    for (const auto& row : of_row) changes.insert(changes.end(), row.begin(), row.end());
    return changes;
  }

  uint16_t farther_neighbour(int x, int y) const {
    uint16_t farthest = layer_.at(x, y);
    for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
      const int nx = neighbour_column(grid_, x + dx), ny = y + dy;
      if (nx >= 0 && ny >= 0 && ny < layer_.height) farthest = std::min(farthest, layer_.at(nx, ny));
    }
    return farthest;
  }

  bool belongs_to(uint16_t farther, int x, int y) const {
    const int own = layer_.at(x, y);
    int balance = 1;  // the pixel itself is among its own kind
    for_window(x, y, [&](int nx, int ny) {
      const int d = layer_.at(nx, ny);
      if (d == kNoDisparity) return;
      balance += std::abs(d - own) < std::abs(d - farther) ? -1 : 1;
    });
    const int near_cost = cost_of_window(x, y, own);
    const int most = near_cost + kSmoothness * balance - kMargin;  // below this the farther surface must cost
    if (near_cost == kUnknown || most <= 0) return false;
    const int far_cost = cost_of_window(x, y, farther);
    return far_cost != kUnknown && far_cost < most;
  }

  // Mean over the window, all of it at one disparity.
  int cost_of_window(int x, int y, int disparity) const {
    const double w = grid_.inverse_depth(disparity);
    int sum = 0, count = 0;
    for (int dx = -1; dx <= 1; ++dx) {
      const int nx = neighbour_column(grid_, x + dx);
      if (nx >= 0) add_costs_of_column(nx, y, w, sum, count);
    }
    return count == 0 ? kUnknown : sum / count;
  }

  void add_costs_of_column(int x, int y, double w, int& sum, int& count) const {
    std::array<std::array<Tone, kMostViews>, 3> tones;
    std::array<int, 3> views{};
    for (const uint16_t camera : facing_[static_cast<size_t>(x)]) {
      const Line line = line_of(camera, x, w);
      if (!line.seen) continue;
      for (int j = 0; j < 3; ++j) {
        auto& seen = views[static_cast<size_t>(j)];
        if (layer_.contains(x, y - 1 + j) &&
            look(frames_[camera], line, y - 1 + j, tones[static_cast<size_t>(j)][static_cast<size_t>(seen)]))
          ++seen;
      }
    }
    for (size_t j = 0; j < 3; ++j) {
      if (views[j] < 2) continue;
      sum += cost(tones[j].data(), views[j]);
      ++count;
    }
  }

  // How well the two views that agree best with the first do so: of more than three some may be hidden.
  static int cost(const Tone* tones, int views) {
    int best = 2 * kMostDiffer, second = 2 * kMostDiffer;
    for (int i = 1; i < views; ++i) {
      const int d = difference(tones[0], tones[i]);
      second = std::min(second, std::max(best, d));
      best = std::min(best, d);
    }
    return views == 2 ? 2 * best : best + second;
  }

  // Where a camera sees the voxels of a column at one inverse depth: between two image columns.
  struct Line {
    bool seen = false;
    int column = 0, weight = 0;  // of the right one, in 1/64
    double slope = 0, offset = 0;
  };
  Line line_of(size_t camera, int x, double w) const {
    const VoxelProjection& projection = projections_[camera];
    const auto u = projection.column(headings_[static_cast<size_t>(x)]);
    const double forward = projection.forward(u, w);
    if (forward < kLeastForward) return {};
    const double x_px = projection.x_px(u, w) - 0.5;
    if (!(x_px >= 0 && x_px < frames_[camera].camera.width - 1)) return {};
    const int x64 = static_cast<int>(x_px * 64);
    return {true, x64 >> 6, x64 & 63, projection.row_slope(forward), projection.row_offset(w, forward)};
  }

  bool look(const UprightFrame& frame, const Line& line, int y, Tone& out) const {
    const double y_px = line.offset + line.slope * grid_.v(y + 0.5) - 0.5;
    if (!(y_px >= 0 && y_px < frame.camera.height - 1)) return false;
    const int y64 = static_cast<int>(y_px * 64), row = y64 >> 6, weight = y64 & 63;
    const auto left = static_cast<size_t>(line.column), right = left + 1;
    if (row < std::max(frame.valid_begin[left], frame.valid_begin[right]) ||
        row + 1 >= std::min(frame.valid_end[left], frame.valid_end[right]))
      return false;
    const auto mix = [&](const GreyImage& image) {
      const uint8_t *a = image.row(line.column) + row, *b = image.row(line.column + 1) + row;
      const int above = a[0] * (64 - line.weight) + b[0] * line.weight;
      const int below = a[1] * (64 - line.weight) + b[1] * line.weight;
      return (above * (64 - weight) + below * weight) / (64 * 64 / kGreySteps);
    };
    out = {mix(frame.columns), mix(frame.tint)};
    return true;
  }

  const PanoramaGrid& grid_;
  const std::vector<UprightFrame>& frames_;
  DisparityMap& layer_;
  SurfaceTolerance<int> one_surface_;  // in disparity steps
  std::vector<VoxelProjection> projections_;
  std::vector<Heading> headings_;              // of column centres
  std::vector<std::vector<uint16_t>> facing_;  // of each column
};

}  // namespace
}  // namespace ldp::layers

namespace ldp {

using namespace layers;

void fit_outlines(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames, const Job& job,
                  DisparityMap& layer) {
  OutlineFitter(grid, frames, layer).run(job);
}

}  // namespace ldp
