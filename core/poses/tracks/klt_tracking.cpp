#include "core/poses/tracks/klt_tracking.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/photos/halved.h"
#include "core/poses/features/patch_alignment.h"
#include "core/poses/tracks/track_tuning.h"

namespace ldp::sfm {
namespace {

constexpr int kChunk = 64;  // tracks per task

struct PyramidLevels {
  GreyImage half;
  const GreyImage* full = nullptr;
};

// Where the point of a track is predicted in a frame, and how the anchor's surroundings are warped there.
struct Prediction {
  Eigen::Vector2d position_px;  // from the principal point
  Eigen::Matrix2d warp;
};

class KltTracker {
 public:
  KltTracker(const std::vector<GreyPhoto>& pictures, const Bundle& bundle, const KltOptions& options)
      : pictures_(pictures), bundle_(bundle), options_(options) {
    for (const GreyPhoto& picture : pictures) levels_.push_back({halved(picture.grey), &picture.grey});
  }

  Track track(const Track& matched, const InversePoint& point) const {
    const Observation& anchor = matched[matched.size() / 2];
    const size_t anchor_frame = static_cast<size_t>(anchor.frame);
    const Eigen::Vector2d in_picture = to_picture(anchor.position_px, anchor_frame);
    const auto fine = make_template<kSmallPatchRadius_px>(pictures_[anchor_frame].grey, in_picture);
    if (!fine) return {};
    const auto coarse = make_template<kSmallPatchRadius_px>(levels_[anchor_frame].half, 0.5 * in_picture);
    const InversePoint shown = move_to_ray(anchor, point);
    std::vector<PatchInFrame<kSmallPatchRadius_px>> found;
    for (size_t frame = 0; frame < bundle_.cameras.size(); ++frame) {
      if (frame == anchor_frame) {
        found.push_back({anchor_frame, Eigen::Matrix2d::Identity(), {in_picture, fine->patch, 1, 0}});
        continue;
      }
      const auto prediction = predict(anchor_frame, frame, shown);
      if (!prediction) continue;
      const Eigen::Vector2d start = to_picture(prediction->position_px, frame);
      Eigen::Vector2d position = start;
      if (coarse) {
        const auto near = align(*coarse, levels_[frame].half, 0.5 * position, prediction->warp);
        if (near && near->correlation > kMinCoarseCorrelation) position = 2 * near->position;
      }
      const auto aligned = align(*fine, pictures_[frame].grey, position, prediction->warp);
      if (!aligned || aligned->correlation < options_.min_correlation) continue;
      if ((aligned->position - start).norm() > options_.reach) continue;
      found.push_back({frame, prediction->warp, *aligned});
    }
    return observations(*fine, found, anchor_frame);
  }

 private:
  template <int kRadius>
  struct PatchInFrame {
    size_t frame;
    Eigen::Matrix2d warp;  // from the anchor's surroundings
    Aligned<kRadius> aligned;
  };

  // The anchor's noise is in all that was aligned with it. What all frames show on the average has less, and the anchor
  // is aligned with it as the others are.
  Track observations(const Template<kSmallPatchRadius_px>& of_anchor,
                     std::vector<PatchInFrame<kSmallPatchRadius_px>> found, size_t anchor_frame) const {
    Template<kSmallPatchRadius_px> t = of_anchor;
    const bool averaged = found.size() >= kMinAveragedFrames;
    for (int i = 0; averaged && i < kTemplateUpdates; ++i) {
      const auto mean = make_template<kSmallPatchRadius_px>(average<kSmallPatchRadius_px>(found));
      if (!mean) return {};
      t = *mean;
      std::vector<PatchInFrame<kSmallPatchRadius_px>> again;
      for (const auto& shown : found) {
        const auto aligned = align(t, pictures_[shown.frame].grey, shown.aligned.position, shown.warp);
        if (aligned && aligned->correlation >= options_.min_correlation)
          again.push_back({shown.frame, shown.warp, *aligned});
      }
      if (again.size() < kMinAveragedFrames) return {};
      found = std::move(again);
    }
    Track wide = with_large_patch(found, averaged, anchor_frame);
    if (!wide.empty()) return wide;
    Track track;
    for (const auto& shown : found) {
      const double sigma = averaged || shown.frame != anchor_frame ? position_sigma(t, shown.aligned.correlation) : 0;
      track.push_back({static_cast<int>(shown.frame), -1, from_picture(shown.aligned.position, shown.frame),
                       weight(sigma, shown.frame)});
    }
    return track;
  }

  // The same with more of the surroundings, which tells more where they lie in one plane: where they are as alike from
  // frame to frame. Empty if not.
  Track with_large_patch(const std::vector<PatchInFrame<kSmallPatchRadius_px>>& found, bool averaged,
                         size_t anchor_frame) const {
    if (found.size() < 2) return {};
    std::vector<PatchInFrame<kLargePatchRadius_px>> wide;
    for (const auto& shown : found) {
      Patch<kLargePatchRadius_px> patch;
      if (!sample<kLargePatchRadius_px>(pictures_[shown.frame].grey, shown.aligned.position, shown.warp, patch) ||
          !normalise(patch))
        return {};
      wide.push_back({shown.frame, shown.warp, {shown.aligned.position, patch}});
    }
    const auto anchor = std::find_if(wide.begin(), wide.end(), [&](const auto& w) { return w.frame == anchor_frame; });
    if (!averaged && anchor == wide.end()) return {};
    const auto t =
        make_template<kLargePatchRadius_px>(averaged ? average<kLargePatchRadius_px>(wide) : anchor->aligned.patch);
    if (!t) return {};
    double unlike_before = 0, unlike = 0;
    Track track;
    for (const auto& shown : found) {
      const int frame = static_cast<int>(shown.frame);
      if (!averaged && shown.frame == anchor_frame) {
        track.push_back({frame, -1, from_picture(shown.aligned.position, anchor_frame), weight(0, anchor_frame)});
        continue;
      }
      const auto there =
          align<kLargePatchRadius_px>(*t, pictures_[shown.frame].grey, shown.aligned.position, shown.warp);
      if (!there || (there->position - shown.aligned.position).norm() > kMaxPatchShift_px) return {};
      unlike_before += shown.aligned.residual_variance();
      unlike += there->residual_variance();
      track.push_back({frame, -1, from_picture(there->position, shown.frame),
                       weight(position_sigma(*t, there->correlation), shown.frame)});
    }
    return unlike <= kMaxResidualGrowth * unlike_before ? track : Track{};
  }

  template <int kRadius>
  static Patch<kRadius> average(const std::vector<PatchInFrame<kRadius>>& found) {
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
    return kFeatureSigma_px / std::hypot(kMinKltSigma_px, sigma * 800 / std::max(grey.width, grey.height));
  }

  // The point moved onto the line of sight of the anchor's own observation, at the same distance from the origin's
  // view.
  InversePoint move_to_ray(const Observation& anchor, const InversePoint& point) const {
    const Pose& pose = bundle_.cameras[static_cast<size_t>(anchor.frame)];
    const Eigen::Vector3d ray =
        pose.world_from_camera * undistorted_ray(anchor.position_px, bundle_.lens).homogeneous().normalized();
    const Eigen::Vector3d seen = point.seen_from(pose.centre);
    const Eigen::Vector3d m = seen.norm() * ray + point.inverse_distance * pose.centre;
    return {m.normalized(), point.inverse_distance / m.norm()};
  }

  std::optional<Prediction> predict(size_t anchor_frame, size_t frame, const InversePoint& point) const {
    const Eigen::Vector3d e1 = point.direction.unitOrthogonal(), e2 = point.direction.cross(e1);
    constexpr double kStep = 1e-4;
    std::array<Eigen::Vector2d, 3> at_home, there;
    for (size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = point.direction + kStep * (i == 1   ? e1
                                                           : i == 2 ? e2
                                                                    : Eigen::Vector3d(Eigen::Vector3d::Zero()));
      const Projection a = project_point(bundle_.cameras[anchor_frame], bundle_.lens, {d, point.inverse_distance});
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
    if (!warp.allFinite() || warp.determinant() < kMinWarpArea || warp.determinant() > kMaxWarpArea)
      return std::nullopt;
    return Prediction{there[0], warp};
  }

  const std::vector<GreyPhoto>& pictures_;
  const Bundle& bundle_;
  KltOptions options_;
  std::vector<PyramidLevels> levels_;
};

}  // namespace

std::vector<Track> track_points(const std::vector<GreyPhoto>& pictures, const std::vector<Track>& tracks,
                                const Bundle& bundle, const KltOptions& options, const Job& job) {
  const KltTracker tracker(pictures, bundle, options);
  std::vector<Track> tracked(tracks.size());
  parallel_for(job, (static_cast<int>(tracks.size()) + kChunk - 1) / kChunk, [&](int chunk) {
    for (size_t i = static_cast<size_t>(chunk) * kChunk;
         i < std::min(tracks.size(), static_cast<size_t>(chunk + 1) * kChunk); ++i) {
      tracked[i] = tracker.track(tracks[i], bundle.points[i]);
    }
  });
  return tracked;
}

}  // namespace ldp::sfm
