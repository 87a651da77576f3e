// One round of reconstruction after another: what agrees with the cameras is placed and all is adjusted to it, with
// tolerances that narrow.
#pragma once

#include <algorithm>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp {

constexpr double kMatched[] = {12, 5, 3};            // tolerances of the rounds on matches, pixels of 800
constexpr double kFollowed[] = {4, 2};               // and on followed points
constexpr double kNearArc = 0.02, kAboutArc = 0.05;  // sigma of the arc prior at first and later: what walks by is told
                                                     // from what stands as long as cameras are kept near their circle
constexpr double kFarArc = 0.2;                      // for hands that leave it
constexpr double kNoArc = 1e3;                       // for paths that are none
constexpr int kHeld = 150;                           // followed observations that a frame is content with

class Rounds {
 public:
  Rounds(const MatchedSweep& sweep, const std::optional<FocalPrior>& focal, const Job& job);

  void set_model(Model model) { options_.model = model; }
  void forget_the_arc() { least_sigma_ = kNoArc; }
  void leave_the_arc() { least_sigma_ = kFarArc; }
  void stay_on_the_arc() { least_sigma_ = 0; }
  bool on_an_arc() const { return least_sigma_ < kNoArc && options_.model != Model::rotation; }
  void keep_the_bend() { options_.refine_distortion = false; }  // that the lens has
  bool bent() const { return options_.refine_distortion; }
  void use_threads(int threads) { job_.threads = std::max(1, threads); }  // as when several are at work
  void let_pairs_count() { pairs_count_ = true; }
  void end_thoroughly() { thorough_ = true; }  // the last round weighs tracks as a whole, and believes the scatter

  // Places what agrees and adjusts everything to it.
  void round(const std::vector<Track>& tracks, double tolerance, double arc_sigma, Reconstruction& r);

  // Whether the lens bends lines, by the observations of the last round.
  void decide_distortion(Reconstruction& r);

  void place(const std::vector<Track>& tracks, double tolerance, Reconstruction& r) const;

 private:
  void leave_out_loners(Reconstruction& r) const;
  double noise_px(const Reconstruction& r) const;

  const MatchedSweep* sweep_;
  Job job_;
  BundleOptions options_;
  bool pairs_count_ = false;  // as much as points that a third photo confirms
  bool thorough_ = false;
  double least_sigma_ = 0;
  double cost_ = 0;
  double believed_sigma_ = 0;  // of the arc prior in a thorough last round: the scatter about the circle that the round
                               // before found, over the noise of observations, because the prior's deviations are added
                               // to those of the data, which are in pixels
};

// How far cameras that observations hold are from their places on the sphere: deviation of a coordinate, radii.
double scatter_about_arc(const Reconstruction& r);

std::vector<int> observations_by_frame(const Reconstruction& r);

}  // namespace ldp
