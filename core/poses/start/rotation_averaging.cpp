#include "core/poses/start/rotation_averaging.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/poses/start/start_tuning.h"
#include "core/poses/tracks/geometric_verification.h"

namespace ldp::sfm {
namespace {

std::vector<RayPair> ray_pairs(const MatchedSweep& sweep, const PairMatches& pair, double focal) {
  std::vector<RayPair> rays;
  const size_t step = std::max<size_t>(1, pair.matches.size() / kMatchesPerRotation);
  for (size_t i = 0; i < pair.matches.size(); i += step) {
    const Match& m = pair.matches[i];
    rays.push_back({sweep.features[static_cast<size_t>(pair.a)].centred(m.a) / focal,
                    sweep.features[static_cast<size_t>(pair.b)].centred(m.b) / focal});
  }
  return rays;
}

// Photos are taken one after the other, so those next to each other show the same things; those farther apart may show
// things that only look the same.
std::vector<RotationEdge> rotation_edges(const MatchedSweep& sweep, double focal, TwoViewMotion motion) {
  std::vector<RotationEdge> edges;
  for (const PairMatches& pair : sweep.pairs) {
    const RelativeRotation r = relative_rotation(sweep, pair, focal, motion);
    const double trust = static_cast<double>(pair.matches.size()) / std::pow(pair.b - pair.a, kSequenceDistancePower);
    edges.push_back({pair.a, pair.b, r.b_from_a, trust * trust * std::exp(-r.cost)});
  }
  return edges;
}

// World-from-camera of all. A group of frames that nothing connects with those before goes on from the frame before it:
// a photo of nothing may stand anywhere, also in the middle, where averaging begins.
std::vector<Eigen::Matrix3d> chained_rotations(int frames, const std::vector<RotationEdge>& edges) {
  std::vector<bool> reached;
  std::vector<Eigen::Matrix3d> world = average_rotations(frames, frames / 2, edges, reached);
  for (int first = 0; first < frames; ++first) {
    if (reached[static_cast<size_t>(first)]) continue;
    std::vector<bool> of_group;
    const std::vector<Eigen::Matrix3d> group = average_rotations(frames, first, edges, of_group);
    const Eigen::Matrix3d before = first > 0 ? world[static_cast<size_t>(first) - 1] : Eigen::Matrix3d::Identity();
    for (size_t i = 0; i < group.size(); ++i) {
      if (!of_group[i]) continue;
      world[i] = before * group[i];
      reached[i] = true;
    }
  }
  return world;
}

std::vector<double> focal_hypotheses(const MatchedSweep& sweep, const std::optional<FocalPrior>& prior) {
  std::vector<double> focals;
  if (prior) {
    for (const double factor : {0.8, 0.9, 1.0, 1.1, 1.25}) focals.push_back(factor * prior->focal_px);
    return focals;
  }
  const double longer = std::max(sweep.features[0].width, sweep.features[0].height);
  const double shortest = 0.5 * longer / std::tan(0.5 * kWidestHypothesis_rad),
               longest = 0.5 * longer / std::tan(0.5 * kNarrowestHypothesis_rad);
  for (int i = 0; i < kFocalHypotheses; ++i)
    focals.push_back(shortest * std::pow(longest / shortest, i / (kFocalHypotheses - 1.0)));
  return focals;
}

double angle_between(const Eigen::Matrix3d& r, const Eigen::Matrix3d& s) {
  return Eigen::AngleAxisd(r * s.transpose()).angle();
}

// How far the cameras have turned along the sequence.
std::vector<double> cumulative_angles(const std::vector<Eigen::Matrix3d>& cameras) {
  std::vector<double> turned{0};
  for (size_t i = 1; i < cameras.size(); ++i)
    turned.push_back(turned.back() + angle_between(cameras[i], cameras[i - 1]));
  return turned;
}

// How surely each match of a pair agrees that the cameras turn like that; none do where too few do. Of photos near each
// other in the sequence the matches are asked: cameras that turn otherwise see them inside the circle, or not in one
// place. Those farther apart may not fit because errors add up along the sequence: of them only the turn is asked, and
// unless it closes the circle, one focal length at which it fits may be chance.
std::vector<uint8_t> match_votes(const MatchedSweep& sweep, const PairMatches& pair, const RotationEdge& edge,
                                 const Bundle& bundle, const std::vector<double>& turned) {
  const size_t count = pair.matches.size();
  if (pair.b - pair.a <= TwoViewOptions{}.sequential_window) {
    const std::vector<bool> agrees = inlier_matches(sweep, bundle, pair, kPairTolerance_rad * bundle.lens.focal_px,
                                                    false, kMaxSphericalInverseDistance);
    const auto agreeing = static_cast<double>(std::count(agrees.begin(), agrees.end(), true));
    std::vector<uint8_t> votes(count, 0);
    if (agreeing >= kMinPairInlierRatio * static_cast<double>(count))
      std::transform(agrees.begin(), agrees.end(), votes.begin(), [](bool a) { return a ? kCertainVote : uint8_t{0}; });
    return votes;
  }
  const auto camera = [&](int i) { return bundle.cameras[static_cast<size_t>(i)].world_from_camera; };
  const double between = turned[static_cast<size_t>(pair.b)] - turned[static_cast<size_t>(pair.a)];
  const bool agrees =
      angle_between(edge.b_from_a, camera(pair.b).transpose() * camera(pair.a)) <
      kMaxPairAngle_steps * turned.back() / static_cast<double>(turned.size()) + kMaxPairAngleShare * between;
  return std::vector<uint8_t>(count, !agrees                         ? uint8_t{0}
                                     : between > kMinLoopClosure_rad ? kCertainVote
                                                                     : kPossibleVote);
}

}  // namespace

FocalPrior generic_focal_prior(const MatchedSweep& sweep) {
  return {kGenericFocal * std::max(sweep.features[0].width, sweep.features[0].height), kGenericFocalLogSigma};
}

RelativeRotation relative_rotation(const MatchedSweep& sweep, const PairMatches& pair, double focal_px,
                                   TwoViewMotion motion) {
  const std::vector<RayPair> rays = ray_pairs(sweep, pair, focal_px);
  return motion == TwoViewMotion::rotation ? pure_rotation(rays)
                                           : spherical_rotation(rays, sweep.pixels(kSphereTolerance_px) / focal_px);
}

std::vector<StepPrior> step_priors(const MatchedSweep& sweep, double focal_px) {
  std::vector<StepPrior> priors;
  for (const PairMatches& pair : sweep.pairs) {
    if (pair.b - pair.a != 1) continue;
    const RelativeRotation step = relative_rotation(sweep, pair, focal_px, TwoViewMotion::spherical);
    if (step.cost > kMaxStepCost) continue;
    const double angle = Eigen::AngleAxisd(step.b_from_a).angle();
    priors.push_back({pair.a, pair.b, step.b_from_a, kStepSigmaShare * std::max(angle, kLeastStep_rad)});
  }
  return priors;
}

double view_of_longer_side(const MatchedSweep& sweep, double focal_px) {
  return 2 * std::atan2(0.5 * std::max(sweep.features[0].width, sweep.features[0].height), focal_px);
}

std::vector<RotationHypothesis> rotation_hypotheses(const MatchedSweep& sweep, const std::optional<FocalPrior>& prior,
                                                    TwoViewMotion motion, const Job& job) {
  std::vector<RotationHypothesis> all;
  for (const double focal : focal_hypotheses(sweep, prior)) all.push_back({focal, {}, {}});
  parallel_for(job, static_cast<int>(all.size()), [&](int i) {
    RotationHypothesis& one = all[static_cast<size_t>(i)];
    const std::vector<RotationEdge> edges = rotation_edges(sweep, one.focal_px, motion);
    one.world_from_camera = chained_rotations(sweep.frames(), edges);
    Bundle spherical;
    spherical.lens.focal_px = one.focal_px;
    for (const Eigen::Matrix3d& r : one.world_from_camera) spherical.cameras.push_back({r, r.col(2)});
    const std::vector<double> turned = cumulative_angles(one.world_from_camera);
    for (size_t p = 0; p < edges.size(); ++p)
      one.votes.push_back(match_votes(sweep, sweep.pairs[p], edges[p], spherical, turned));
  });
  const auto turned = [](const RotationHypothesis& one) { return cumulative_angles(one.world_from_camera).back(); };
  const double least =
      turned(*std::min_element(all.begin(), all.end(), [&](const RotationHypothesis& a, const RotationHypothesis& b) {
        return turned(a) < turned(b);
      }));
  std::erase_if(all, [&](const RotationHypothesis& one) { return turned(one) > std::max(kMaxSweep_rad, least); });
  return all;
}

std::vector<PairMatches> reject_inconsistent_matches(std::vector<PairMatches> pairs,
                                                     const std::vector<RotationHypothesis>& hypotheses) {
  for (size_t p = 0; p < pairs.size(); ++p) {
    std::vector<Match> kept;
    for (size_t m = 0; m < pairs[p].matches.size(); ++m) {
      int votes = 0;
      for (const RotationHypothesis& one : hypotheses) votes += one.votes[p][m];
      if (votes >= kCertainVote) kept.push_back(pairs[p].matches[m]);
    }
    pairs[p].matches = std::move(kept);
  }
  std::erase_if(pairs, [](const PairMatches& pair) { return pair.matches.empty(); });
  return pairs;
}

}  // namespace ldp::sfm
