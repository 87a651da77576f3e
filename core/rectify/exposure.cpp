#include "exposure.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "exact_math.h"

namespace ldp {
namespace {

constexpr int kBlocksAcross = 64;            // blocks along the longer side of a photo
constexpr int kLowest = 16, kHighest = 240;  // channel values between which a pixel is trusted
constexpr size_t kLeastSamples = 12;         // of a link
constexpr double kDriftSigma = 0.1;          // prior: log gain of neighbouring photos differs by so much
constexpr double kLeastLinkSigma = 0.003;    // a link is never trusted more than this
constexpr double kLargestGain = 4;
constexpr int kSweeps = 400, kRounds = 5;  // Gauss-Seidel sweeps in each round of re-weighting

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
  if (d.z() <= 0.1 * std::sqrt(exact_dot(d, d))) return {};
  return read_colour(thumbnail, project(camera.intrinsics, d));
}

// Log ratios b / a of what two photos see, per channel: of shared scene points, or of directions where points lack.
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
  std::vector<double>& ratios(size_t channel) { return ratios_[channel]; }

 private:
  void add(const std::optional<Reading>& a, const Eigen::Vector3d& ray_from_b) {
    if (!a) return;
    const auto b = read_at(camera_b_, thumbnail_b_, ray_from_b);
    if (!b) return;
    for (size_t c = 0; c < 3; ++c) ratios_[c].push_back(b->log_value[c] - a->log_value[c]);
  }

  const Camera &camera_a_, &camera_b_;
  const Thumbnail &thumbnail_a_, &thumbnail_b_;
  std::array<std::vector<double>, 3> ratios_;
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

using Links = std::array<std::vector<Link>, 3>;

void compare(Comparison& comparison, const std::vector<const ScenePoint*>& shared, int a, int b, Links& links) {
  if (shared.size() >= kLeastSamples) comparison.add_points(shared);
  if (comparison.samples() < kLeastSamples) comparison.add_directions();
  if (comparison.samples() < kLeastSamples) return;
  for (size_t c = 0; c < 3; ++c) links[c].push_back(link_of(comparison.ratios(c), a, b));
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

// Log gains that fit the links best; links that contradict the others lose weight.
std::vector<double> solve_links(const std::vector<Link>& links, size_t n) {
  std::vector<double> x(n, 0), weight(links.size());
  for (int round = 0; round < kRounds; ++round) {
    for (size_t i = 0; i < links.size(); ++i) {
      const Link& link = links[i];
      const double error = x[static_cast<size_t>(link.a)] - x[static_cast<size_t>(link.b)] - link.log_ratio;
      const double spread = error / (3 * link.sigma);
      weight[i] = (round == 0 ? 1 : 1 / (1 + spread * spread)) / (link.sigma * link.sigma);
    }
    constexpr double kPrior = 1 / (kDriftSigma * kDriftSigma);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      std::vector<double> sum(n, 0), total(n, 1e-3);
      for (size_t i = 0; i < links.size(); ++i) {
        const auto a = static_cast<size_t>(links[i].a), b = static_cast<size_t>(links[i].b);
        sum[a] += weight[i] * (x[b] + links[i].log_ratio) + kPrior * x[b];
        sum[b] += weight[i] * (x[a] - links[i].log_ratio) + kPrior * x[a];
        total[a] += weight[i] + kPrior;
        total[b] += weight[i] + kPrior;
      }
      for (size_t k = 0; k < n; ++k) x[k] = 0.5 * x[k] + 0.5 * sum[k] / total[k];
    }
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
  const auto shared = shared_points(points, n);
  Links links;
  for (size_t a = 0; a < n; ++a) {
    for (size_t b = a + 1; b < n; ++b) {
      if (!may_overlap(cameras[a], cameras[b])) continue;
      Comparison comparison(cameras, thumbnails, static_cast<int>(a), static_cast<int>(b));
      compare(comparison, shared[a * n + b], static_cast<int>(a), static_cast<int>(b), links);
    }
  }
  std::vector<Gain> gains(n);
  for (size_t c = 0; c < 3; ++c) {
    const auto log_gain = solve_links(links[c], n);
    for (size_t i = 0; i < n; ++i) {
      const double gain = std::clamp(exact_exp(log_gain[i]), 1 / kLargestGain, kLargestGain);
      gains[i][c] = static_cast<float>(std::floor(gain * 1024 + 0.5) / 1024);
    }
  }
  return gains;
}

}  // namespace ldp
