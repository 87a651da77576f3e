#include "core/photos/exposure/overlap_samples.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/exact_math.h"
#include "core/photos/exposure_tuning.h"

namespace ldp::exposure {
namespace {

using Levels = std::array<double, 3>;

// The thumbnail's colour at a position of the photo, bilinear; nothing near clipped or missing blocks.
std::optional<Levels> read_colour(const Thumbnail& thumbnail, const Eigen::Vector2d& position_px) {
  const double x = position_px.x() / thumbnail.block_px - 0.5, y = position_px.y() / thumbnail.block_px - 0.5;
  const double x_floor = std::floor(x), y_floor = std::floor(y);
  if (!(x_floor >= 0 && y_floor >= 0 && x_floor + 1 < thumbnail.mean.width && y_floor + 1 < thumbnail.mean.height))
    return {};
  const int x0 = static_cast<int>(x_floor), y0 = static_cast<int>(y_floor);
  const double fx = x - x_floor, fy = y - y_floor;
  Levels levels{};
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      if (!thumbnail.usable.at(x0 + i, y0 + j)) return {};
      const double weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
      for (size_t c = 0; c < 3; ++c) levels[c] += weight * static_cast<double>(thumbnail.mean.at(x0 + i, y0 + j)[c]);
    }
  }
  return levels;
}

std::optional<Levels> read_at(const Camera& camera, const Thumbnail& thumbnail, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d d = exact_transposed_product(camera.pose.world_from_camera, ray);
  if (d.z() <= kLeastForward * std::sqrt(exact_dot(d, d))) return {};
  return read_colour(thumbnail, project(camera.intrinsics, d));
}

// What two photos see of scene points that they share, or of directions in space.
class Comparison {
 public:
  Comparison(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails, int a, int b)
      : camera_a_(cameras[static_cast<size_t>(a)]),
        camera_b_(cameras[static_cast<size_t>(b)]),
        thumbnail_a_(thumbnails[static_cast<size_t>(a)]),
        thumbnail_b_(thumbnails[static_cast<size_t>(b)]) {}

  void add_points(const std::vector<const ScenePoint*>& points) {
    for (const ScenePoint* point : points) {
      add(read_at(camera_a_, thumbnail_a_, point->position - camera_a_.pose.centre),
          point->position - camera_b_.pose.centre);
    }
  }

  void add_directions() {
    const int block = thumbnail_a_.block_px;
    for (int y = 1; y + 1 < thumbnail_a_.mean.height; ++y) {
      for (int x = 1; x + 1 < thumbnail_a_.mean.width; ++x) {
        const Eigen::Vector2d centre((x + 0.5) * block, (y + 0.5) * block);
        const Eigen::Vector3d ray =
            exact_product(camera_a_.pose.world_from_camera, unproject(camera_a_.intrinsics, centre));
        add(read_colour(thumbnail_a_, centre), ray);
      }
    }
  }

  std::vector<PairedColours> take() { return std::move(colours_); }

 private:
  void add(const std::optional<Levels>& a, const Eigen::Vector3d& ray_from_b) {
    if (!a) return;
    if (const auto b = read_at(camera_b_, thumbnail_b_, ray_from_b)) colours_.push_back({*a, *b});
  }

  const Camera &camera_a_, &camera_b_;
  const Thumbnail &thumbnail_a_, &thumbnail_b_;
  std::vector<PairedColours> colours_;
};

// The points that cameras a < b share, at [a * n + b].
std::vector<std::vector<const ScenePoint*>> shared_points(const std::vector<ScenePoint>& points, size_t n) {
  std::vector<std::vector<const ScenePoint*>> shared(n * n);
  for (const ScenePoint& point : points) {
    for (const int a : point.cameras) {
      for (const int b : point.cameras) {
        if (a < b) shared[static_cast<size_t>(a) * n + static_cast<size_t>(b)].push_back(&point);
      }
    }
  }
  return shared;
}

bool may_overlap(const Camera& a, const Camera& b) {
  return exact_dot(a.pose.world_from_camera.col(2), b.pose.world_from_camera.col(2)) > 0.5;
}

// Photos in groups that links join.
class Groups {
 public:
  explicit Groups(size_t n) : group_(n) { std::iota(group_.begin(), group_.end(), size_t{0}); }

  bool joined(size_t a, size_t b) const { return group_[a] == group_[b]; }
  void join(size_t a, size_t b) { std::replace(group_.begin(), group_.end(), size_t{group_[b]}, size_t{group_[a]}); }

 private:
  std::vector<size_t> group_;
};

}  // namespace

std::vector<Overlap> overlaps(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
                              const std::vector<ScenePoint>& points) {
  const size_t n = cameras.size();
  const auto shared = shared_points(points, n);
  std::vector<Overlap> found;
  Groups by_points(n);
  const auto each_pair = [&](const auto& compare) {
    for (size_t a = 0; a < n; ++a) {
      for (size_t b = a + 1; b < n; ++b) {
        if (!may_overlap(cameras[a], cameras[b])) continue;
        Comparison comparison(cameras, thumbnails, static_cast<int>(a), static_cast<int>(b));
        compare(comparison, a, b);
      }
    }
  };
  const auto add = [&](Comparison& comparison, size_t a, size_t b) {
    std::vector<PairedColours> colours = comparison.take();
    if (colours.size() < kLeastSamples) return false;
    found.push_back({static_cast<int>(a), static_cast<int>(b), std::move(colours)});
    return true;
  };
  each_pair([&](Comparison& comparison, size_t a, size_t b) {
    if (shared[a * n + b].size() < kLeastSamples) return;
    comparison.add_points(shared[a * n + b]);
    if (add(comparison, a, b)) by_points.join(a, b);
  });
  each_pair([&](Comparison& comparison, size_t a, size_t b) {
    if (by_points.joined(a, b)) return;
    comparison.add_directions();
    add(comparison, a, b);
  });
  return found;
}

}  // namespace ldp::exposure

namespace ldp {

using namespace exposure;

Thumbnail make_thumbnail(const RgbImage& photo) {
  Thumbnail thumbnail;
  thumbnail.block_px = std::max(1, std::max(photo.width, photo.height) / kBlocksAcross);
  const int block = thumbnail.block_px;
  thumbnail.mean = Plane<std::array<float, 3>>(photo.width / block, photo.height / block);
  thumbnail.usable = Plane<uint8_t>(photo.width / block, photo.height / block);
  for (int by = 0; by < thumbnail.mean.height; ++by) {
    for (int bx = 0; bx < thumbnail.mean.width; ++bx) {
      std::array<int64_t, 3> sum{};
      int clipped = 0;
      for (int y = by * block; y < (by + 1) * block; ++y) {
        for (int x = bx * block; x < (bx + 1) * block; ++x) {
          const Rgb p = photo.at(x, y);
          clipped += std::min({p.r, p.g, p.b}) < kLowest || std::max({p.r, p.g, p.b}) > kHighest;
          sum[0] += p.r;
          sum[1] += p.g;
          sum[2] += p.b;
        }
      }
      thumbnail.usable.at(bx, by) = 8 * clipped <= block * block;
      for (size_t c = 0; c < 3; ++c) {
        thumbnail.mean.at(bx, by)[c] =
            static_cast<float>(static_cast<double>(std::max<int64_t>(sum[c], 1)) / (block * block));
      }
    }
  }
  return thumbnail;
}

}  // namespace ldp
