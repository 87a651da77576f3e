// Alternation of triangulation with outlier rejection and bundle adjustment, with tolerances that narrow.
#pragma once

#include <algorithm>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/refine/refine_tuning.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

class IterativeRefinement {
 public:
  IterativeRefinement(const MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job);

  void set_model(MotionModel model) { options_.model = model; }
  void set_min_arc_sigma(double sigma) { min_arc_sigma_ = sigma; }  // of the arc prior whatever an iteration asks for
  void enforce_cheirality() { options_.enforce_cheirality = true; }
  bool has_arc_prior() const { return min_arc_sigma_ < kNoArcSigma && options_.model != MotionModel::rotation; }
  void forget_focal_prior() { options_.focal_prior.reset(); }
  void fix_distortion() { options_.refine_distortion = false; }
  bool refines_distortion() const { return options_.refine_distortion; }
  void use_threads(int threads) { job_.threads = std::max(1, threads); }  // as when several are at work
  void trust_two_view_points() { trusts_two_view_points_ = true; }
  void reweight_tracks_at_end() { reweights_at_end_ = true; }

  // Triangulates tracks with outlier rejection and adjusts everything to what is left.
  void iterate(const std::vector<Track>& tracks, double tolerance, double arc_sigma, Reconstruction& r);

  // Whether the lens distorts, by the observations of the last iteration. True if that is new.
  bool select_distortion_model(Reconstruction& r);

  void triangulate(const std::vector<Track>& tracks, double tolerance, Reconstruction& r) const;

 private:
  void reject_depth_outliers(Reconstruction& r) const;
  double noise_px(const Reconstruction& r) const;

  const MatchedSweep* sweep_;
  Job job_;
  BundleAdjustmentOptions options_;
  bool on_klt_tracks_ = false;           // the last iteration
  bool trusts_two_view_points_ = false;  // as much as points that a third photo confirms
  bool reweights_at_end_ = false;
  double min_arc_sigma_ = 0;
  double cost_ = 0;
  double estimated_arc_sigma_ = 0;  // for iterations on tracks by KLT: the scatter about the circle that the one
                                    // before found, over the noise of observations, because the prior's deviations
                                    // are added to those of the data, which are in pixels
};

// How far cameras that observations hold are from their places on the sphere: deviation of a coordinate, radii.
double scatter_about_arc(const Reconstruction& r);
// Of its points. Too long a focal length passes for a world that lies a little beyond infinity, as an arc whose steps
// turn too little: left to themselves, tracks lengthen it until nothing is left.
double share_beyond_infinity(const Bundle& bundle);

std::vector<int> observations_by_frame(const Reconstruction& r);

}  // namespace ldp::sfm
