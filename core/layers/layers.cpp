#include "layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "voxel_projection.h"

namespace ldp {
namespace {

constexpr uint16_t kUncovered = 0;
constexpr int kColumnsAtOnce = 64;  // between two looks at the stop token

double inverse_depth(const PanoramaGrid& grid, double disparity) { return grid.inverse_depth(disparity); }

int neighbour_column(const PanoramaGrid& grid, int x) {
  if (x >= 0 && x < grid.width) return x;
  return grid.wraps ? (x + grid.width) % grid.width : -1;
}

std::vector<Heading> edge_headings(const PanoramaGrid& grid) {
  std::vector<Heading> edges(static_cast<size_t>(grid.width) + 1);
  for (int x = 0; x <= grid.width; ++x) edges[static_cast<size_t>(x)] = heading(grid.theta(x));
  return edges;
}

// First map pixel whose centre lies at or after a position in upright pixels.
int first_pixel(double position_px, int shrink, int limit) {
  const double pixel = (shrink == 1 ? position_px : position_px / shrink) - 0.5;
  if (!(pixel > 0)) return 0;
  if (pixel >= limit) return limit;
  const int whole = static_cast<int>(pixel);
  return whole + (whole < pixel ? 1 : 0);
}

// Disparity steps that shift a voxel by so many pixels when the eye moves by one arc radius.
double parallax_steps(const PanoramaGrid& grid, double px) {
  const double range = grid.w_near - grid.w_far;
  return range <= 0 ? kLabelSteps : px * grid.v_pitch / (std::max(grid.arc.radius, 1e-9) * range) * kDisparitySteps;
}

// What painting a layer into any camera's map needs.
struct Brush {
  const PanoramaGrid& grid;
  std::vector<Heading> edges;
  std::vector<double> edges_v;
  std::vector<double> inverse_depths;  // of half disparity steps
  Plane<uint16_t> columns;             // the layer's

  Brush(const PanoramaGrid& on, const DisparityMap& layer)
      : grid(on), edges(edge_headings(on)), columns(layer.height, layer.width) {
    for (int y = 0; y <= grid.height; ++y) edges_v.push_back(grid.v(y));
    for (int i = 0; i <= 2 * kDisparitySteps; ++i) inverse_depths.push_back(inverse_depth(grid, 0.5 * i));
    for (int y = 0; y < layer.height; ++y)
      for (int x = 0; x < layer.width; ++x) columns.at(y, x) = layer.at(x, y);
  }
};

// Draws layers into one camera's map.
class MapPainter {
 public:
  MapPainter(const Brush& brush, const UprightCamera& camera, const LayersOptions& options, VisibilityMap& map)
      : grid_(brush.grid),
        brush_(brush),
        projection_(grid_, camera),
        connect_steps_(parallax_steps(grid_, options.connect_px)),
        connect_share_(options.connect_share),
        far_steps_(grid_.w_far / std::max(1e-9, grid_.w_near - grid_.w_far) * kDisparitySteps),
        map_(map) {}

  // One column of the layer.
  void paint(int x) {
    const Heading left = brush_.edges[static_cast<size_t>(x)], right = brush_.edges[static_cast<size_t>(x) + 1];
    if (!in_view(left) && !in_view(right)) return;
    const Sides sides{projection_.column(left), projection_.column(right)};
    if (beside_view(sides)) return;
    const int before = neighbour_column(grid_, x - 1), after = neighbour_column(grid_, x + 1);
    const uint16_t *here = brush_.columns.row(x), *to_left = brush_.columns.row(before < 0 ? x : before),
                   *to_right = brush_.columns.row(after < 0 ? x : after);
    for (int y = 0; y < grid_.height; ++y)
      if (const int d = here[y]; d != kNoDisparity)
        paint_pixel(sides, y, shared_edge(d, to_left[y]), d, shared_edge(d, to_right[y]));
  }

 private:
  struct Sides {  // of a column
    VoxelProjection::Column left, right;
  };

  // In half steps.
  int shared_edge(int d, int neighbour) const {
    if (neighbour == kNoDisparity) return 2 * d;
    const double limit = connect_steps_ + connect_share_ * (far_steps_ + std::max(d, neighbour));
    return std::abs(d - neighbour) > limit ? 2 * d : d + neighbour;
  }

  // May any voxel of this heading appear in the map?
  bool in_view(Heading h) const {
    const auto u = projection_.column(h);
    return u.forward > 0.2 || projection_.forward(u, grid_.w_near) > 0.2;
  }

  // Does the column stay outside the map at every disparity? Its place in the image is monotonic in inverse depth.
  bool beside_view(const Sides& sides) const {
    const double end_px = 1.0 * map_.shrink * map_.inverse_z.height, w_far = inverse_depth(grid_, 0),
                 w_near = inverse_depth(grid_, kDisparitySteps);
    const auto always = [&](const VoxelProjection::Column& u, const auto& outside) {
      return projection_.forward(u, w_far) > 0.1 && projection_.forward(u, w_near) > 0.1 &&
             outside(projection_.x_px(u, w_far)) && outside(projection_.x_px(u, w_near));
    };
    return always(sides.left, [&](double x_px) { return x_px > end_px + 1; }) ||
           always(sides.right, [](double x_px) { return x_px < -1; });
  }

  // Its disparity, and those of its sides in half steps.
  void paint_pixel(const Sides& sides, int y, int left_half_steps, int d, int right_half_steps) {
    const auto& [left, right] = sides;
    const VoxelProjection::Column middle{0.5 * (left.right + right.right), 0.5 * (left.forward + right.forward)};
    const std::vector<double>& depths = brush_.inverse_depths;
    const double w_left = depths[static_cast<size_t>(left_half_steps)], w = depths[static_cast<size_t>(2 * d)],
                 w_right = depths[static_cast<size_t>(right_half_steps)];
    const double forward = projection_.forward(middle, w);
    if (forward < 0.1 || projection_.forward(left, w_left) < 0.1 || projection_.forward(right, w_right) < 0.1) return;
    const int shrink = map_.shrink;
    const int x0 = first_pixel(projection_.x_px(left, w_left), shrink, map_.inverse_z.height);
    const int x1 = first_pixel(projection_.x_px(right, w_right), shrink, map_.inverse_z.height);
    if (x0 >= x1) return;
    const double slope = projection_.row_slope(forward), offset = projection_.row_offset(w, forward);
    const auto row = static_cast<size_t>(y);
    const int y0 = first_pixel(offset + slope * brush_.edges_v[row], shrink, map_.inverse_z.width);
    const int y1 = first_pixel(offset + slope * brush_.edges_v[row + 1], shrink, map_.inverse_z.width);
    const auto depth = static_cast<uint16_t>(std::clamp(w / forward / map_.scale, 1.0, 65535.0));
    for (int column = x0; column < x1; ++column) {
      uint16_t* out = map_.inverse_z.row(column);
      for (int at = y0; at < y1; ++at) out[at] = std::max(out[at], depth);
    }
  }

  const PanoramaGrid& grid_;
  const Brush& brush_;
  VoxelProjection projection_;
  double connect_steps_, connect_share_, far_steps_;  // disparity steps; far_steps_ + disparity is the inverse depth
  VisibilityMap& map_;
};

VisibilityMap empty_map(const PanoramaGrid& grid, const UprightCamera& camera, const LayersOptions& options) {
  VisibilityMap map;
  const int columns = (camera.width + options.shrink - 1) / options.shrink;
  const int rows = (camera.height + options.shrink - 1) / options.shrink;
  const double nearest = std::max(grid.w_near, 1e-9) * 4;  // cameras stand off the ray origins: some room
  map.inverse_z = Plane<uint16_t>(rows, columns, kUncovered);
  map.scale = nearest / 65535;
  map.shrink = options.shrink;
  const double label = (grid.w_near - grid.w_far) / (kLabels - 1);
  map.tolerance = static_cast<int>(std::min(65535.0, std::ceil(options.tolerance_labels * label / map.scale)));
  return map;
}

// Gaps one pixel high between rows of one surface come from rounding, not from the scene.
void close_hairlines(VisibilityMap& map) {
  for (int column = 0; column < map.inverse_z.height; ++column) {
    uint16_t* out = map.inverse_z.row(column);
    for (int row = 1; row + 1 < map.inverse_z.width; ++row)
      if (out[row] == kUncovered && out[row - 1] != kUncovered && out[row + 1] != kUncovered &&
          std::abs(out[row - 1] - out[row + 1]) <= map.tolerance)
        out[row] = std::min(out[row - 1], out[row + 1]);
  }
}

// Per frame, by columns: not 0 where no layer covers the pixel or one of its eight neighbours.
using UncoveredMaps = std::vector<Plane<uint8_t>>;

Plane<uint8_t> uncovered(const VisibilityMap& map) {
  const int rows = map.inverse_z.width, columns = map.inverse_z.height;
  Plane<uint8_t> along(rows, columns), near(rows, columns);
  std::vector<uint8_t> open(static_cast<size_t>(rows) + 2);
  for (int column = 0; column < columns; ++column) {
    const uint16_t* surface = map.inverse_z.row(column);
    for (int row = 0; row < rows; ++row) open[static_cast<size_t>(row) + 1] = surface[row] == kUncovered;
    uint8_t* out = along.row(column);
    for (int row = 0; row < rows; ++row) {
      const uint8_t* at = open.data() + row;
      out[row] = at[0] | at[1] | at[2];
    }
  }
  for (int column = 0; column < columns; ++column) {
    const uint8_t *before = along.row(std::max(0, column - 1)), *here = along.row(column),
                  *after = along.row(std::min(columns - 1, column + 1));
    uint8_t* out = near.row(column);
    for (int row = 0; row < rows; ++row) out[row] = before[row] | here[row] | after[row];
  }
  return near;
}

UncoveredMaps uncovered(const std::vector<VisibilityMap>& maps, const Job& job) {
  UncoveredMaps uncovered_maps(maps.size());
  parallel_for(job, static_cast<int>(maps.size()),
               [&](int i) { uncovered_maps[static_cast<size_t>(i)] = uncovered(maps[static_cast<size_t>(i)]); });
  return uncovered_maps;
}

// The voxels of one column at one inverse depth, as one camera's map sees them: one map column, rows affine in v.
struct VoxelColumn {
  const UprightFrame* frame;
  const uint8_t* uncovered;  // the map's column
  int shrink, column;        // of the upright frame
  double slope, offset;      // upright row = offset + slope v
};

// Where voxels are looked at from: all cameras.
struct Eyes {
  const std::vector<UprightFrame>& frames;
  int shrink;
  std::vector<VoxelProjection> projections;
  UncoveredMaps uncovered_maps;

  Eyes(const PanoramaGrid& grid, const std::vector<UprightFrame>& from, const std::vector<VisibilityMap>& maps,
       const Job& job)
      : frames(from), shrink(maps.empty() ? 1 : maps[0].shrink), uncovered_maps(uncovered(maps, job)) {
    projections.reserve(frames.size());
    for (const UprightFrame& frame : frames) projections.emplace_back(grid, frame.camera);
  }
};

// The cameras that may see any voxel of a column.
struct Facing {
  Heading heading;
  std::vector<size_t> frames;

  Facing(const PanoramaGrid& grid, const Eyes& eyes, int x) : heading(ldp::heading(grid.theta(x + 0.5))) {
    const double w[2] = {grid.inverse_depth(0), grid.inverse_depth(kDisparitySteps)};
    for (size_t i = 0; i < eyes.frames.size(); ++i) {
      const VoxelProjection& projection = eyes.projections[i];
      const auto u = projection.column(heading);
      const double forward[2] = {projection.forward(u, w[0]), projection.forward(u, w[1])};
      if (forward[0] < 0.09 && forward[1] < 0.09) continue;
      if (forward[0] > 0.1 && forward[1] > 0.1) {  // then its place is monotonic in inverse depth
        const auto [first, last] = std::minmax({projection.x_px(u, w[0]), projection.x_px(u, w[1])});
        if (last < -1 || first > eyes.frames[i].camera.width + 1) continue;
      }
      frames.push_back(i);
    }
  }
};

// Those of them that see the column's voxels at inverse depth w.
void find_voxel_columns(const Eyes& eyes, const Facing& facing, double w, std::vector<VoxelColumn>& seen) {
  seen.clear();
  for (const size_t i : facing.frames) {
    const VoxelProjection& projection = eyes.projections[i];
    const auto u = projection.column(facing.heading);
    const double forward = projection.forward(u, w);
    if (forward < 0.1) continue;
    const double x_px = projection.x_px(u, w);
    if (!(x_px >= 0 && x_px < eyes.frames[i].camera.width)) continue;
    const int column = static_cast<int>(x_px);
    seen.push_back({&eyes.frames[i], eyes.uncovered_maps[i].row(column / eyes.shrink), eyes.shrink, column,
                    projection.row_slope(forward), projection.row_offset(w, forward)});
  }
}

// Does the voxel fall on a pixel that no layer covers, or beside one?
bool falls_on_uncovered(const VoxelColumn& voxels, double v) {
  const double y_px = voxels.offset + voxels.slope * v;
  const auto column = static_cast<size_t>(voxels.column);
  if (y_px < voxels.frame->valid_begin[column] || y_px >= voxels.frame->valid_end[column]) return false;
  return voxels.uncovered[static_cast<int>(y_px) / voxels.shrink] != 0;
}

void mark_boundary(const PanoramaGrid& grid, const DisparityMap& front, int gap, Plane<uint8_t>& want) {
  const auto behind_wanted = [&](int x, int y, int d) {
    const int column = neighbour_column(grid, x);
    return column >= 0 && y >= 0 && y < grid.height && want.at(column, y) == kWanted && front.at(column, y) >= d + gap;
  };
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const int d = front.at(x, y);
      if (want.at(x, y) == kWanted || d == kNoDisparity) continue;
      if (behind_wanted(x - 1, y, d) || behind_wanted(x + 1, y, d) || behind_wanted(x, y - 1, d) ||
          behind_wanted(x, y + 1, d))
        want.at(x, y) = kBoundary;
    }
}

}  // namespace

void add_layer(const PanoramaGrid& grid, const DisparityMap& layer, const std::vector<UprightFrame>& frames,
               const LayersOptions& options, const Job& job, std::vector<VisibilityMap>& maps) {
  if (options.shrink < 1)
    throw std::logic_error("visibility: shrink is " + std::to_string(options.shrink) + ", must be >= 1");
  if (maps.empty())
    for (const UprightFrame& frame : frames) maps.push_back(empty_map(grid, frame.camera, options));
  const Brush brush(grid, layer);
  parallel_for(job, static_cast<int>(frames.size()), [&](int i) {
    const auto index = static_cast<size_t>(i);
    MapPainter painter(brush, frames[index].camera, options, maps[index]);
    for (int x = 0; x < grid.width; ++x) {
      if (x % kColumnsAtOnce == 0) job.check();
      painter.paint(x);
    }
    close_hairlines(maps[index]);
  });
}

DisparityMap without_silhouettes(const DisparityMap& layer, int reach_px) {
  DisparityMap rows = layer, both = layer;
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const uint16_t* row = layer.row(y);
      rows.at(x, y) = *std::min_element(row + std::max(0, x - reach_px), row + std::min(layer.width, x + reach_px + 1));
    }
  for (int y = 0; y < layer.height; ++y)
    for (int at = std::max(0, y - reach_px); at < std::min(layer.height, y + reach_px + 1); ++at)
      std::transform(both.row(y), both.row(y) + layer.width, rows.row(at), both.row(y),
                     [](uint16_t a, uint16_t b) { return std::min(a, b); });
  return both;
}

Plane<uint8_t> wanted_behind(const PanoramaGrid& grid, const DisparityMap& front,
                             const std::vector<UprightFrame>& frames, const std::vector<VisibilityMap>& maps,
                             const LayersOptions& options, const Job& job) {
  const Eyes eyes(grid, frames, maps, job);
  const int gap = gap_steps(grid, options);
  Plane<uint8_t> want(grid.width, grid.height, kUnwanted);
  parallel_for(job, grid.width, [&](int x) {
    const Facing facing(grid, eyes, x);
    std::vector<int> nearest(static_cast<size_t>(grid.height));  // of the disparities that lie behind; -1 = settled
    for (int y = 0; y < grid.height; ++y)
      nearest[static_cast<size_t>(y)] = front.at(x, y) == kNoDisparity ? -1 : front.at(x, y) - gap;
    std::vector<VoxelColumn> columns;
    for (int d = 0; d <= kDisparitySteps - gap; d += kLabelSteps / 2) {
      find_voxel_columns(eyes, facing, grid.inverse_depth(d), columns);
      for (const VoxelColumn& voxels : columns)
        for (int y = 0; y < grid.height; ++y) {
          int& bound = nearest[static_cast<size_t>(y)];
          if (d > bound || !falls_on_uncovered(voxels, grid.v(y + 0.5))) continue;
          want.at(x, y) = kWanted;
          bound = -1;
        }
    }
  });
  mark_boundary(grid, front, gap, want);
  return want;
}

namespace {

// The voxels of one column at evenly spaced disparities, found when asked for.
class ColumnOfVoxels {
 public:
  static constexpr int kStep = kLabelSteps / 2;

  ColumnOfVoxels(const PanoramaGrid& grid, const Eyes& eyes, int x)
      : grid_(grid), eyes_(eyes), facing_(grid, eyes, x) {}

  bool in_sight(int disparity, double v) {
    auto& columns = at_[static_cast<size_t>(disparity / kStep)];
    if (!columns) find_voxel_columns(eyes_, facing_, grid_.inverse_depth(disparity), columns.emplace());
    return std::any_of(columns->begin(), columns->end(),
                       [&](const VoxelColumn& c) { return falls_on_uncovered(c, v); });
  }

 private:
  const PanoramaGrid& grid_;
  const Eyes& eyes_;
  Facing facing_;
  std::array<std::optional<std::vector<VoxelColumn>>, kDisparitySteps / kStep + 1> at_;
};

}  // namespace

void move_into_sight(const PanoramaGrid& grid, const DisparityMap& front, int gap,
                     const std::vector<UprightFrame>& frames, const std::vector<VisibilityMap>& maps,
                     const Plane<uint8_t>& want, const Job& job, DisparityMap& layer) {
  constexpr int kStep = ColumnOfVoxels::kStep;
  const Eyes eyes(grid, frames, maps, job);
  parallel_for(job, grid.width, [&](int x) {
    ColumnOfVoxels voxels(grid, eyes, x);
    for (int y = 0; y < grid.height; ++y) {
      if (want.at(x, y) != kWanted) continue;
      const int farthest = front.at(x, y) - gap;
      uint16_t& d = layer.at(x, y);
      const int start = (std::min<int>(d == kNoDisparity ? 0 : d, farthest) + kStep / 2) / kStep * kStep;
      const double v = grid.v(y + 0.5);
      if (d <= farthest && voxels.in_sight(start, v)) continue;
      for (int away = 0; away <= kDisparitySteps; away += kStep)
        if (const int behind = start - away; behind >= 0 && behind <= farthest && voxels.in_sight(behind, v)) {
          d = static_cast<uint16_t>(behind);
          break;
        } else if (const int nearer = start + away; nearer <= farthest && voxels.in_sight(nearer, v)) {
          d = static_cast<uint16_t>(nearer);
          break;
        }
    }
  });
}

int drop_unseen(const PanoramaGrid& grid, const std::vector<UprightFrame>& frames,
                const std::vector<VisibilityMap>& maps, const Job& job, DisparityMap& layer) {
  const Eyes eyes(grid, frames, maps, job);
  std::vector<int> kept(static_cast<size_t>(grid.width), 0);
  parallel_for(job, grid.width, [&](int x) {
    const Facing facing(grid, eyes, x);
    int cached = -1;
    std::vector<VoxelColumn> columns;
    for (int y = 0; y < grid.height; ++y) {
      uint16_t& d = layer.at(x, y);
      if (d == kNoDisparity) continue;
      if (d != cached) find_voxel_columns(eyes, facing, grid.inverse_depth(d), columns);
      cached = d;
      const double v = grid.v(y + 0.5);
      const bool seen =
          std::any_of(columns.begin(), columns.end(), [&](const VoxelColumn& c) { return falls_on_uncovered(c, v); });
      if (seen)
        ++kept[static_cast<size_t>(x)];
      else
        d = kNoDisparity;
    }
  });
  int total = 0;
  for (int k : kept) total += k;
  return total;
}

int gap_steps(const PanoramaGrid& grid, const LayersOptions& options) {
  return static_cast<int>(std::clamp(std::ceil(parallax_steps(grid, options.gap_px)), 1.0, 1.0 * kLabelSteps));
}

namespace {

// The background met last while walking along a row through wanted pixels.
struct Continued {
  int disparity = -1, distance = 0;
  void step(uint8_t want, int surface) {
    if (want == kBoundary)
      disparity = surface, distance = 0;
    else if (want == kWanted && disparity >= 0)
      ++distance;
    else
      disparity = -1;
  }
};

// Between the backgrounds of both sides by distance; -1 = there is none.
int between(const Continued& a, const Continued& b) {
  if (a.disparity < 0 || b.disparity < 0) return std::max(a.disparity, b.disparity);
  if (std::abs(a.disparity - b.disparity) > kLabelSteps) return a.distance <= b.distance ? a.disparity : b.disparity;
  return (a.disparity * b.distance + b.disparity * a.distance) / std::max(1, a.distance + b.distance);
}

}  // namespace

void continue_background(const Plane<uint8_t>& want, const DisparityMap& surface, int gap, DisparityMap& layer) {
  std::vector<Continued> from_right(static_cast<size_t>(layer.width));
  for (int y = 0; y < layer.height; ++y) {
    Continued walk;
    for (int x = layer.width - 1; x >= 0; --x) {
      walk.step(want.at(x, y), surface.at(x, y));
      from_right[static_cast<size_t>(x)] = walk;
    }
    walk = {};
    for (int x = 0; x < layer.width; ++x) {
      walk.step(want.at(x, y), surface.at(x, y));
      if (want.at(x, y) != kWanted) continue;
      const int d = between(walk, from_right[static_cast<size_t>(x)]);
      uint16_t& out = layer.at(x, y);
      const bool agrees = out == kNoDisparity || std::abs(out - d) <= kLabelSteps;
      if (d >= 0 && d + gap <= surface.at(x, y) && agrees) out = static_cast<uint16_t>(d);
    }
  }
}

void BoundaryCosts::read(const Window& window, uint8_t* cost, uint8_t* median) const {
  inner_.read(window, cost, median);
  const int labels = inner_.labels();
  for (int i = 0; i < window.width; ++i) {
    const int x = (window.x + i) % inner_.width();
    for (int j = 0; j < window.height; ++j) {
      if (want_.at(x, window.y + j) != kBoundary) continue;
      const int d = surface_.at(x, window.y + j);
      const int held = (d * (labels - 1) + kDisparitySteps / 2) / kDisparitySteps;
      uint8_t* out = cost + (static_cast<size_t>(i) * static_cast<size_t>(window.height) + static_cast<size_t>(j)) *
                                static_cast<size_t>(labels);
      for (int l = 0; l < labels; ++l) out[l] = l == held ? 0 : 255;
    }
  }
}

}  // namespace ldp
