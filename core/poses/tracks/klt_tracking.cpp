#include "core/poses/tracks/klt_tracking.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/photos/halved.h"
#include "core/poses/features/patch_alignment.h"

namespace ldp {
namespace {

constexpr int kSmall = 5;              // a patch is 11 x 11 samples
constexpr int kLarge = 9;              // or 19 x 19, where as much lies in one plane:
constexpr double kAsAlike = 1.2;       // what is left of differences, squared, may be so many times that of the small,
constexpr double kSamePlace_px = 0.5;  // and it is found no farther from where the small one was
constexpr int kChunk = 64;             // tracks per task
constexpr size_t kLeastAveraged = 3;   // frames whose average is less noisy than the anchor
constexpr int kAverages = 2;           // each of what was aligned with the one before
constexpr double kFeatureSigma = 0.3;  // of where a feature is found, pixels of a photo 800 long: weight 1
constexpr double kFinestSigma = 0.06;  // of the best that is followed

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
    const auto fine = make_template<kSmall>(pictures_[home].grey, in_picture);
    if (!fine) return {};
    const auto coarse = make_template<kSmall>(levels_[home].half, 0.5 * in_picture);
    const InversePoint shown = on_ray(anchor, point);
    std::vector<Shown<kSmall>> found;
    for (size_t frame = 0; frame < bundle_.cameras.size(); ++frame) {
      if (frame == home) {
        found.push_back({home, Eigen::Matrix2d::Identity(), {in_picture, fine->patch, 1, 0}});
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
  template <int kRadius>
  struct Shown {
    size_t frame;
    Eigen::Matrix2d warp;  // from the anchor's surroundings
    Aligned<kRadius> aligned;
  };

  // The anchor's noise is in all that was aligned with it. What all frames show on the average has less, and the anchor
  // is aligned with it as the others are.
  Track observations(const Template<kSmall>& of_anchor, std::vector<Shown<kSmall>> found, size_t home) const {
    Template<kSmall> t = of_anchor;
    const bool averaged = found.size() >= kLeastAveraged;
    for (int i = 0; averaged && i < kAverages; ++i) {
      const auto mean = make_template<kSmall>(average<kSmall>(found));
      if (!mean) return {};
      t = *mean;
      std::vector<Shown<kSmall>> again;
      for (const auto& shown : found) {
        const auto aligned = align(t, pictures_[shown.frame].grey, shown.aligned.position, shown.warp);
        if (aligned && aligned->correlation >= options_.least_correlation)
          again.push_back({shown.frame, shown.warp, *aligned});
      }
      if (again.size() < kLeastAveraged) return {};
      found = std::move(again);
    }
    Track wide = widened(found, averaged, home);
    if (!wide.empty()) return wide;
    Track track;
    for (const auto& shown : found) {
      const double sigma = averaged || shown.frame != home ? position_sigma(t, shown.aligned.correlation) : 0;
      track.push_back({static_cast<int>(shown.frame), -1, from_picture(shown.aligned.position, shown.frame),
                       weight(sigma, shown.frame)});
    }
    return track;
  }

  // The same with more of the surroundings, which tells more where they lie in one plane: where they are as alike from
  // frame to frame. Empty if not.
  Track widened(const std::vector<Shown<kSmall>>& found, bool averaged, size_t home) const {
    if (found.size() < 2) return {};
    std::vector<Shown<kLarge>> wide;
    for (const auto& shown : found) {
      Patch<kLarge> patch;
      if (!sample<kLarge>(pictures_[shown.frame].grey, shown.aligned.position, shown.warp, patch) || !normalise(patch))
        return {};
      wide.push_back({shown.frame, shown.warp, {shown.aligned.position, patch}});
    }
    const auto anchor = std::find_if(wide.begin(), wide.end(), [&](const auto& w) { return w.frame == home; });
    if (!averaged && anchor == wide.end()) return {};
    const auto t = make_template<kLarge>(averaged ? average<kLarge>(wide) : anchor->aligned.patch);
    if (!t) return {};
    double unlike_before = 0, unlike = 0;
    Track track;
    for (const auto& shown : found) {
      const int frame = static_cast<int>(shown.frame);
      if (!averaged && shown.frame == home) {
        track.push_back({frame, -1, from_picture(shown.aligned.position, home), weight(0, home)});
        continue;
      }
      const auto there = align<kLarge>(*t, pictures_[shown.frame].grey, shown.aligned.position, shown.warp);
      if (!there || (there->position - shown.aligned.position).norm() > kSamePlace_px) return {};
      unlike_before += shown.aligned.unlike();
      unlike += there->unlike();
      track.push_back({frame, -1, from_picture(there->position, shown.frame),
                       weight(position_sigma(*t, there->correlation), shown.frame)});
    }
    return unlike <= kAsAlike * unlike_before ? track : Track{};
  }

  template <int kRadius>
  static Patch<kRadius> average(const std::vector<Shown<kRadius>>& found) {
    Patch<kRadius> mean{};
    for (const auto& shown : found) {
      for (size_t i = 0; i < mean.size(); ++i) mean[i] += shown.aligned.patch[i];
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
