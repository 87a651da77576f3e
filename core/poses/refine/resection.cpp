#include "core/poses/refine/resection.h"

#include "core/poses/refine/refine_tuning.h"
#include "core/poses/start/rotation_averaging.h"

namespace ldp::sfm {
namespace {

using Pairs = std::vector<const PairMatches*>;

Pairs pairs_of(const MatchedSweep& sweep, const Reconstruction& r, int frame) {
  Pairs pairs;
  for (const PairMatches& pair : sweep.pairs) {
    const int other = pair.a == frame ? pair.b : pair.b == frame ? pair.a : -1;
    if (other >= 0 && !r.left_out[static_cast<size_t>(other)]) pairs.push_back(&pair);
  }
  return pairs;
}

double inlier_ratio(const MatchedSweep& sweep, const Bundle& bundle, const Pairs& pairs) {
  double agree = 0, all = 0;
  for (const PairMatches* pair : pairs) {
    const double count = static_cast<double>(pair->matches.size());
    agree += count * inlier_ratio(sweep, bundle, *pair, sweep.pixels(kResectionTolerance_px));
    all += count;
  }
  return agree / all;
}

// Where the pair's matches want the frame beside the other one.
Pose beside(const MatchedSweep& sweep, const Bundle& bundle, const PairMatches& pair, int frame) {
  const Eigen::Matrix3d b_from_a =
      relative_rotation(sweep, pair, bundle.lens.focal_px, TwoViewMotion::spherical).b_from_a;
  const int other = pair.a == frame ? pair.b : pair.a;
  const Eigen::Matrix3d& of_other = bundle.cameras[static_cast<size_t>(other)].world_from_camera;
  const Eigen::Matrix3d other_from_frame = pair.a == frame ? b_from_a : Eigen::Matrix3d(b_from_a.transpose());
  const Eigen::Matrix3d world_from_frame = of_other * other_from_frame;
  return {world_from_frame, world_from_frame.col(2)};
}

bool resect(const MatchedSweep& sweep, Reconstruction& r, int frame) {
  const Pairs pairs = pairs_of(sweep, r, frame);
  Pose& pose = r.bundle.cameras[static_cast<size_t>(frame)];
  Pose best = pose;
  const double now = inlier_ratio(sweep, r.bundle, pairs);
  double most = std::max(kLostInlierRatio, now);
  for (const PairMatches* pair : pairs) {
    pose = beside(sweep, r.bundle, *pair, frame);
    const double share = inlier_ratio(sweep, r.bundle, pairs);
    if (share > most) most = share, best = pose;
  }
  pose = best;
  return most > std::max(kLostInlierRatio, now);
}

}  // namespace

bool resect_lost_frames(const MatchedSweep& sweep, Reconstruction& r) {
  std::vector<double> of_matches(r.left_out.size(), 0), agree = of_matches;
  for (const PairMatches& pair : sweep.pairs) {
    const size_t a = static_cast<size_t>(pair.a), b = static_cast<size_t>(pair.b);
    if (r.left_out[a] || r.left_out[b]) continue;
    const double count = static_cast<double>(pair.matches.size());
    const double agreeing = count * inlier_ratio(sweep, r.bundle, pair, sweep.pixels(kResectionTolerance_px));
    for (const size_t frame : {a, b}) of_matches[frame] += count, agree[frame] += agreeing;
  }
  bool any = false;
  for (size_t frame = 0; frame < agree.size(); ++frame) {
    if (of_matches[frame] >= kMinResectionMatches && agree[frame] < kLostInlierRatio * of_matches[frame])
      any = resect(sweep, r, static_cast<int>(frame)) || any;
  }
  return any;
}

}  // namespace ldp::sfm
