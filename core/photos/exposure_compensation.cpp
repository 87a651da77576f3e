#include "core/photos/exposure_compensation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/base/exact_math.h"
#include "core/photos/exposure_tuning.h"

namespace ldp {

using namespace exposure;

namespace {

struct Link {
  int a = 0, b = 0;
  double log_ratio = 0;  // what log gain a - log gain b should be
  double sigma = 0;
};

struct Reading {
  std::array<double, 3> log_value{};
};

// Logarithm of the thumbnail's colour at a position of the photo, bilinear; nothing near clipped or missing blocks.
std::optional<Reading> read_colour(const Thumbnail& thumbnail, const Eigen::Vector2d& position_px) {
  const double x = position_px.x() / thumbnail.block_px - 0.5, y = position_px.y() / thumbnail.block_px - 0.5;
  const double x_floor = std::floor(x), y_floor = std::floor(y);
  if (!(x_floor >= 0 && y_floor >= 0 && x_floor + 1 < thumbnail.mean.width && y_floor + 1 < thumbnail.mean.height))
    return {};
  const int x0 = static_cast<int>(x_floor), y0 = static_cast<int>(y_floor);
  const double fx = x - x_floor, fy = y - y_floor;
  Reading reading;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      if (!thumbnail.usable.at(x0 + i, y0 + j)) return {};
      const double weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
      for (size_t c = 0; c < 3; ++c)
        reading.log_value[c] += weight * static_cast<double>(thumbnail.mean.at(x0 + i, y0 + j)[c]);
    }
  }
  for (double& value : reading.log_value) value = exact_log(value);
  return reading;
}

std::optional<Reading> read_at(const Camera& camera, const Thumbnail& thumbnail, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d d = exact_transposed_product(camera.pose.world_from_camera, ray);
  if (d.z() <= kLeastForward * std::sqrt(exact_dot(d, d))) return {};
  return read_colour(thumbnail, project(camera.intrinsics, d));
}

// What is known of two photos' gains: their common factor, then each channel's over that. Tints differ much less than
// exposures, and what misplaces samples tells little of them.
constexpr size_t kFactors = 4;

// Log ratios b / a of what two photos see, per factor: of scene points that they share, or of directions in space.
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

  size_t samples() const { return ratios_[0].size(); }
  std::vector<double>& ratios(size_t factor) { return ratios_[factor]; }

 private:
  void add(const std::optional<Reading>& a, const Eigen::Vector3d& ray_from_b) {
    if (!a) return;
    const auto b = read_at(camera_b_, thumbnail_b_, ray_from_b);
    if (!b) return;
    std::array<double, 3> ratio{};
    for (size_t c = 0; c < 3; ++c) ratio[c] = b->log_value[c] - a->log_value[c];
    const double common = (ratio[0] + ratio[1] + ratio[2]) / 3;
    ratios_[0].push_back(common);
    for (size_t c = 0; c < 3; ++c) ratios_[c + 1].push_back(ratio[c] - common);
  }

  const Camera &camera_a_, &camera_b_;
  const Thumbnail &thumbnail_a_, &thumbnail_b_;
  std::array<std::vector<double>, kFactors> ratios_;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Link link_of(std::vector<double>& ratios, int a, int b) {
  Link link{a, b, median(ratios), 0};
  for (double& ratio : ratios) ratio = std::abs(ratio - link.log_ratio);
  const double deviation = median(ratios);
  link.sigma = std::max(kLeastLinkSigma, 3 * deviation / std::sqrt(static_cast<double>(ratios.size())));
  return link;
}

using Links = std::array<std::vector<Link>, kFactors>;

bool add_links(Comparison& comparison, int a, int b, Links& links) {
  if (comparison.samples() < kLeastSamples) return false;
  for (size_t f = 0; f < kFactors; ++f) links[f].push_back(link_of(comparison.ratios(f), a, b));
  return true;
}

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

// Photos are compared by the points that they share. Two that look in the same direction from afar see different things
// in it: directions are asked only of photos that no chain of points joins.
Links compare_all(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
                  const std::vector<ScenePoint>& points) {
  const size_t n = cameras.size();
  const auto shared = shared_points(points, n);
  Links links;
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
  each_pair([&](Comparison& comparison, size_t a, size_t b) {
    if (shared[a * n + b].size() < kLeastSamples) return;
    comparison.add_points(shared[a * n + b]);
    if (add_links(comparison, static_cast<int>(a), static_cast<int>(b), links)) by_points.join(a, b);
  });
  each_pair([&](Comparison& comparison, size_t a, size_t b) {
    if (by_points.joined(a, b)) return;
    comparison.add_directions();
    add_links(comparison, static_cast<int>(a), static_cast<int>(b), links);
  });
  return links;
}

// Least squares of differences, in a fixed order of plain sums (Gauss, no pivots: symmetric and positive definite).
class NormalEquations {
 public:
  explicit NormalEquations(size_t n) : n_(n), left_(n * n, 0), right_(n, 0) {
    for (size_t i = 0; i < n; ++i) left_[i * n + i] = kAnchor;
  }

  void add(const Link& link, double difference, double weight) {
    const auto a = static_cast<size_t>(link.a), b = static_cast<size_t>(link.b);
    left_[a * n_ + a] += weight, left_[b * n_ + b] += weight;
    left_[a * n_ + b] -= weight, left_[b * n_ + a] -= weight;
    right_[a] += weight * difference, right_[b] -= weight * difference;
  }

  std::vector<double> solution() {
    for (size_t i = 0; i < n_; ++i)
      for (size_t row = i + 1; row < n_; ++row) {
        const double share = left_[row * n_ + i] / left_[i * n_ + i];
        if (share == 0) continue;
        for (size_t k = i; k < n_; ++k) left_[row * n_ + k] -= share * left_[i * n_ + k];
        right_[row] -= share * right_[i];
      }
    std::vector<double> x(right_);
    for (size_t i = n_; i-- > 0;) {
      for (size_t k = i + 1; k < n_; ++k) x[i] -= left_[i * n_ + k] * x[k];
      x[i] /= left_[i * n_ + i];
    }
    return x;
  }

 private:
  size_t n_;
  std::vector<double> left_, right_;
};

// Log factors that fit the links best; links that contradict the others lose weight.
std::vector<double> solve_links(const std::vector<Link>& links, double prior_sigma, size_t n) {
  std::vector<double> x(n, 0), weight(links.size());
  for (int round = 0; round < kReweightings; ++round) {
    for (size_t i = 0; i < links.size(); ++i) {
      const Link& link = links[i];
      const double error = x[static_cast<size_t>(link.a)] - x[static_cast<size_t>(link.b)] - link.log_ratio;
      const double spread = error / (3 * link.sigma);
      weight[i] = (round == 0 ? 1 : 1 / (1 + spread * spread)) / (link.sigma * link.sigma);
    }
    const double prior = 1 / (prior_sigma * prior_sigma);
    NormalEquations equations(n);
    for (size_t i = 0; i < links.size(); ++i) {
      equations.add(links[i], links[i].log_ratio, weight[i]);
      equations.add(links[i], 0, prior);
    }
    x = equations.solution();
  }
  double mean = 0;
  for (const double value : x) mean += value / static_cast<double>(n);
  for (double& value : x) value -= mean;
  return x;
}

}  // namespace

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

std::vector<Gain> exposure_gains(const std::vector<Camera>& cameras, const std::vector<Thumbnail>& thumbnails,
                                 const std::vector<ScenePoint>& points) {
  const size_t n = cameras.size();
  const Links links = compare_all(cameras, thumbnails, points);
  std::vector<Gain> gains(n);
  const auto exposure = solve_links(links[0], kExposureSigma, n);
  for (size_t c = 0; c < 3; ++c) {
    const auto tint = solve_links(links[c + 1], kTintSigma, n);
    for (size_t i = 0; i < n; ++i) {
      const double gain = std::clamp(exact_exp(exposure[i] + tint[i]), 1 / kLargestGain, kLargestGain);
      gains[i][c] = static_cast<float>(std::floor(gain * 1024 + 0.5) / 1024);
    }
  }
  return gains;
}

}  // namespace ldp
