#include "follow.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace ldp {
namespace {

constexpr int kRadius = 5;  // the patch is 11 x 11 samples
constexpr int kSide = 2 * kRadius + 1, kSamples = kSide * kSide;
constexpr int kRounds = 12;            // of alignment per level
constexpr double kSettled = 0.02;      // pixels; smaller steps end it
constexpr double kLeastContrast = 3;   // grey levels, standard deviation
constexpr double kFlattest = 0.15;     // contrast gradients of the weaker direction, against the stronger, squared
constexpr int kChunk = 64;             // tracks per task
constexpr size_t kLeastAveraged = 3;   // frames whose average is less noisy than the anchor
constexpr int kAverages = 2;           // each of what was aligned with the one before
constexpr double kFeatureSigma = 0.3;  // of where a feature is found, pixels of a photo 800 long: weight 1
constexpr double kFinestSigma = 0.06;  // of the best that is followed

using Patch = std::array<float, kSamples>;

GreyImage halved(const GreyImage& image) {
  GreyImage half(image.width / 2, image.height / 2);
  for (int y = 0; y < half.height; ++y) {
    const uint8_t *p = image.row(2 * y), *q = image.row(2 * y + 1);
    for (int x = 0; x < half.width; ++x) {
      half.at(x, y) = static_cast<uint8_t>((p[2 * x] + p[2 * x + 1] + q[2 * x] + q[2 * x + 1] + 2) / 4);
    }
  }
  return half;
}

// Bilinear samples at centre + warp * (integer offsets); false when part of it is outside. Pixel centres at .5.
bool sample(const GreyImage& image, const Eigen::Vector2d& centre, const Eigen::Matrix2d& warp, Patch& patch) {
  const double reach_x = kRadius * (std::abs(warp(0, 0)) + std::abs(warp(0, 1)));
  const double reach_y = kRadius * (std::abs(warp(1, 0)) + std::abs(warp(1, 1)));
  if (!(centre.x() - reach_x > 1 && centre.x() + reach_x < image.width - 1)) return false;
  if (!(centre.y() - reach_y > 1 && centre.y() + reach_y < image.height - 1)) return false;
  const Eigen::Matrix2f w = warp.cast<float>();
  size_t i = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    float x = static_cast<float>(centre.x()) - 0.5F - kRadius * w(0, 0) + static_cast<float>(dy) * w(0, 1);
    float y = static_cast<float>(centre.y()) - 0.5F - kRadius * w(1, 0) + static_cast<float>(dy) * w(1, 1);
    for (int dx = 0; dx < kSide; ++dx, x += w(0, 0), y += w(1, 0)) {
      const int column = static_cast<int>(x), row = static_cast<int>(y);
      const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
      const uint8_t *p = image.row(row) + column, *q = p + image.width;
      const float top = static_cast<float>(p[0]) + fx * static_cast<float>(p[1] - p[0]);
      const float bottom = static_cast<float>(q[0]) + fx * static_cast<float>(q[1] - q[0]);
      patch[i++] = top + fy * (bottom - top);
    }
  }
  return true;
}

// To mean 0 and length 1; false when there is next to nothing to see.
bool normalise(Patch& patch) {
  float sum = 0, squares = 0;
  for (const float s : patch) sum += s;
  for (float& s : patch) {
    s -= sum / kSamples;
    squares += s * s;
  }
  if (squares < kLeastContrast * kLeastContrast * kSamples) return false;
  const float scale = 1 / std::sqrt(squares);
  for (float& s : patch) s *= scale;
  return true;
}

// What is looked for: the anchor's patch, its gradients, and their inverse normal matrix.
struct Template {
  Patch patch;
  std::array<float, kSamples> gradient_x, gradient_y;
  Eigen::Matrix2d inverse;
};

// Of a patch of mean 0 and length 1. None of an edge, which slides along itself.
std::optional<Template> make_template(const Patch& patch) {
  Template t;
  t.patch = patch;
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto at = [&](int i, int j) {
        return t.patch[static_cast<size_t>(std::clamp(j, 0, kSide - 1) * kSide + std::clamp(i, 0, kSide - 1))];
      };
      const size_t i = static_cast<size_t>(y * kSide + x);
      t.gradient_x[i] = 0.5F * (at(x + 1, y) - at(x - 1, y));
      t.gradient_y[i] = 0.5F * (at(x, y + 1) - at(x, y - 1));
      const Eigen::Vector2d g(static_cast<double>(t.gradient_x[i]), static_cast<double>(t.gradient_y[i]));
      h += g * g.transpose();
    }
  }
  const double trace = h.trace(), determinant = h.determinant();
  if (determinant < kFlattest * (1 - kFlattest) * 0.25 * trace * trace) return std::nullopt;
  t.inverse = h.inverse();
  return t;
}

std::optional<Template> make_template(const GreyImage& image, const Eigen::Vector2d& centre) {
  Patch patch;
  if (!sample(image, centre, Eigen::Matrix2d::Identity(), patch) || !normalise(patch)) return std::nullopt;
  return make_template(patch);
}

struct Aligned {
  Eigen::Vector2d position;
  Patch patch;  // there, but for a step too small to count
  double correlation = 0;
};

// What is left of the difference of two patches of length 1, taken for noise, moves the position by so much, pixels of
// the picture. Where near and far things cross, the patch changes from frame to frame; that shows here.
double position_sigma(const Template& t, double correlation) {
  const double noise = std::sqrt(2 * std::max(0.0, 1 - correlation) / kSamples);
  return noise * std::sqrt(0.5 * t.inverse.trace());
}

std::optional<Aligned> align(const Template& t, const GreyImage& image, const Eigen::Vector2d& position,
                             const Eigen::Matrix2d& warp) {
  Aligned there{position, {}};
  for (int round = 0; round < kRounds; ++round) {
    Patch& patch = there.patch;
    if (!sample(image, there.position, warp, patch) || !normalise(patch)) return std::nullopt;
    float gx = 0, gy = 0, product = 0;
    for (size_t i = 0; i < kSamples; ++i) {
      const float difference = t.patch[i] - patch[i];
      gx += t.gradient_x[i] * difference;
      gy += t.gradient_y[i] * difference;
      product += t.patch[i] * patch[i];
    }
    there.correlation = static_cast<double>(product);
    const Eigen::Vector2d step = warp * (t.inverse * Eigen::Vector2d(static_cast<double>(gx), static_cast<double>(gy)));
    if (step.norm() > 3) return std::nullopt;
    there.position += step;
    if (step.norm() < kSettled) return there;
  }
  return std::nullopt;
}

struct Levels {
  GreyImage half;
  const GreyImage* full = nullptr;
};

// Where the point of a track is predicted in a frame, and how the anchor's surroundings are warped there.
struct Prediction {
  Eigen::Vector2d position_px;  // from the principal point
  Eigen::Matrix2d warp;
};

class Follower {
 public:
  Follower(const std::vector<GreyPhoto>& pictures, const Bundle& bundle, const FollowOptions& options)
      : pictures_(pictures), bundle_(bundle), options_(options) {
    for (const GreyPhoto& picture : pictures) levels_.push_back({halved(picture.grey), &picture.grey});
  }

  Track follow(const Track& track, const InversePoint& point) const {
    const Observation& anchor = track[track.size() / 2];
    const size_t home = static_cast<size_t>(anchor.frame);
    const Eigen::Vector2d in_picture = to_picture(anchor.position_px, home);
    const auto fine = make_template(pictures_[home].grey, in_picture);
    if (!fine) return {};
    const auto coarse = make_template(levels_[home].half, 0.5 * in_picture);
    const InversePoint shown = on_ray(anchor, point);
    std::vector<Shown> found;
    for (size_t frame = 0; frame < bundle_.cameras.size(); ++frame) {
      if (frame == home) {
        found.push_back({home, Eigen::Matrix2d::Identity(), {in_picture, fine->patch, 1}});
        continue;
      }
      const auto prediction = predict(home, frame, shown);
      if (!prediction) continue;
      const Eigen::Vector2d start = to_picture(prediction->position_px, frame);
      Eigen::Vector2d position = start;
      if (coarse) {
        const auto near = align(*coarse, levels_[frame].half, 0.5 * position, prediction->warp);
        if (near && near->correlation > 0.5) position = 2 * near->position;
      }
      const auto aligned = align(*fine, pictures_[frame].grey, position, prediction->warp);
      if (!aligned || aligned->correlation < options_.least_correlation) continue;
      if ((aligned->position - start).norm() > options_.reach) continue;
      found.push_back({frame, prediction->warp, *aligned});
    }
    return observations(*fine, found, home);
  }

 private:
  struct Shown {
    size_t frame;
    Eigen::Matrix2d warp;  // from the anchor's surroundings
    Aligned aligned;
  };

  // The anchor's noise is in all that was aligned with it. What all frames show on the average has less, and the anchor
  // is aligned with it as the others are.
  Track observations(const Template& of_anchor, std::vector<Shown> found, size_t home) const {
    Template t = of_anchor;
    const bool averaged = found.size() >= kLeastAveraged;
    for (int i = 0; averaged && i < kAverages; ++i) {
      const auto mean = make_template(average(found));
      if (!mean) return {};
      t = *mean;
      std::vector<Shown> again;
      for (const Shown& shown : found) {
        const auto aligned = align(t, pictures_[shown.frame].grey, shown.aligned.position, shown.warp);
        if (aligned && aligned->correlation >= options_.least_correlation)
          again.push_back({shown.frame, shown.warp, *aligned});
      }
      if (again.size() < kLeastAveraged) return {};
      found = std::move(again);
    }
    Track track;
    for (const Shown& shown : found) {
      const double sigma = averaged || shown.frame != home ? position_sigma(t, shown.aligned.correlation) : 0;
      track.push_back({static_cast<int>(shown.frame), -1, from_picture(shown.aligned.position, shown.frame),
                       weight(sigma, shown.frame)});
    }
    return track;
  }

  static Patch average(const std::vector<Shown>& found) {
    Patch mean{};
    for (const Shown& shown : found) {
      for (size_t i = 0; i < kSamples; ++i) mean[i] += shown.aligned.patch[i];
    }
    float squares = 0;
    for (const float s : mean) squares += s * s;
    const float scale = 1 / std::sqrt(squares);
    for (float& s : mean) s *= scale;
    return mean;
  }

  Eigen::Vector2d middle(size_t frame) const {
    return 0.5 * Eigen::Vector2d(pictures_[frame].grey.width, pictures_[frame].grey.height);
  }
  Eigen::Vector2d to_picture(const Eigen::Vector2d& p, size_t frame) const {
    return pictures_[frame].scale.cwiseProduct(p) + middle(frame);
  }
  Eigen::Vector2d from_picture(const Eigen::Vector2d& p, size_t frame) const {
    return (p - middle(frame)).cwiseQuotient(pictures_[frame].scale);
  }

  double weight(double sigma, size_t frame) const {
    const GreyImage& grey = pictures_[frame].grey;
    return kFeatureSigma / std::hypot(kFinestSigma, sigma * 800 / std::max(grey.width, grey.height));
  }

  // The point moved onto the line of sight of the anchor's own observation, at the same distance from the origin's
  // view.
  InversePoint on_ray(const Observation& anchor, const InversePoint& point) const {
    const Pose& pose = bundle_.cameras[static_cast<size_t>(anchor.frame)];
    const Eigen::Vector3d ray =
        pose.world_from_camera * ray_of(anchor.position_px, bundle_.lens).homogeneous().normalized();
    const Eigen::Vector3d seen = point.seen_from(pose.centre);
    const Eigen::Vector3d m = seen.norm() * ray + point.inverse_distance * pose.centre;
    return {m.normalized(), point.inverse_distance / m.norm()};
  }

  std::optional<Prediction> predict(size_t home, size_t frame, const InversePoint& point) const {
    const Eigen::Vector3d e1 = point.direction.unitOrthogonal(), e2 = point.direction.cross(e1);
    constexpr double kStep = 1e-4;
    std::array<Eigen::Vector2d, 3> at_home, there;
    for (size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = point.direction + kStep * (i == 1   ? e1
                                                           : i == 2 ? e2
                                                                    : Eigen::Vector3d(Eigen::Vector3d::Zero()));
      const Projection a = project_point(bundle_.cameras[home], bundle_.lens, {d, point.inverse_distance});
      const Projection b = project_point(bundle_.cameras[frame], bundle_.lens, {d, point.inverse_distance});
      if (!a.in_front || !b.in_front) return std::nullopt;
      at_home[i] = a.position_px, there[i] = b.position_px;
    }
    const Eigen::Vector2d limit = middle(frame).cwiseQuotient(pictures_[frame].scale);
    if (std::abs(there[0].x()) > limit.x() || std::abs(there[0].y()) > limit.y()) return std::nullopt;
    Eigen::Matrix2d a, b;
    a << at_home[1] - at_home[0], at_home[2] - at_home[0];
    b << there[1] - there[0], there[2] - there[0];
    const Eigen::Matrix2d warp = b * a.inverse();
    if (!warp.allFinite() || warp.determinant() < 0.3 || warp.determinant() > 3) return std::nullopt;
    return Prediction{there[0], warp};
  }

  const std::vector<GreyPhoto>& pictures_;
  const Bundle& bundle_;
  FollowOptions options_;
  std::vector<Levels> levels_;
};

}  // namespace

std::vector<Track> follow_points(const std::vector<GreyPhoto>& pictures, const std::vector<Track>& tracks,
                                 const Bundle& bundle, const FollowOptions& options, const Job& job) {
  const Follower follower(pictures, bundle, options);
  std::vector<Track> followed(tracks.size());
  parallel_for(job, (static_cast<int>(tracks.size()) + kChunk - 1) / kChunk, [&](int chunk) {
    for (size_t i = static_cast<size_t>(chunk) * kChunk;
         i < std::min(tracks.size(), static_cast<size_t>(chunk + 1) * kChunk); ++i) {
      followed[i] = follower.follow(tracks[i], bundle.points[i]);
    }
  });
  return followed;
}

}  // namespace ldp
