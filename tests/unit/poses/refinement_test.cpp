#include "core/poses/pose_doubt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/poses/coverage.h"
#include "core/poses/refine/arc_conditioning.h"
#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/refine/resection.h"
#include "core/poses/refine/smooth_motion.h"
#include "core/poses/start/rotation_averaging.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

using testing::HasSubstr;

// What photo b - 2 shows, found in photo b: something that stands there twice.
PairMatches seen_twice(const KnownSweep& known, int a, int b) {
  const auto& there = known.sweep.features[static_cast<size_t>(b) - 2].positions;
  const auto& here = known.sweep.features[static_cast<size_t>(b)].positions;
  PairMatches pair{a, b, {}};
  for (const Match& m : known.matches(a, b - 2)) {
    const auto near = [&](const Eigen::Vector2d& p) { return (p - there[static_cast<size_t>(m.b)]).norm() < 30; };
    const auto found = std::find_if(here.begin(), here.end(), near);
    if (found != here.end()) pair.matches.push_back({m.a, static_cast<int>(found - here.begin()), 0});
  }
  return pair;
}

TEST(RejectInconsistentMatches, KeepsTheMatchesOfATrueSweep) {
  const KnownSweep known;
  const std::vector<PairMatches> kept = reject_inconsistent_matches(
      known.sweep.pairs, rotation_hypotheses(known.sweep, {}, TwoViewMotion::spherical, Job{}));
  ASSERT_EQ(kept.size(), known.sweep.pairs.size());
  for (size_t i = 0; i < kept.size(); ++i)
    EXPECT_GT(kept[i].matches.size(), 0.95 * static_cast<double>(known.sweep.pairs[i].matches.size())) << i;
}

TEST(RejectInconsistentMatches, LeavesOutThingsThatOnlyLookTheSame) {
  KnownSweep known;
  const size_t true_pairs = known.sweep.pairs.size();
  known.sweep.pairs.push_back(seen_twice(known, 1, 4));
  ASSERT_GE(known.sweep.pairs.back().matches.size(), 16U);
  const FocalPrior told{known.found.bundle.lens.focal_px, 0.1};
  const std::vector<PairMatches> kept = reject_inconsistent_matches(
      known.sweep.pairs, rotation_hypotheses(known.sweep, told, TwoViewMotion::spherical, Job{}));
  EXPECT_EQ(kept.size(), true_pairs);
}

// What the photos of a full turn show of a world far away, each observation up to two pixels off.
KnownSweep far_away() {
  Bundle bundle = full_turn_bundle();
  for (InversePoint& point : bundle.points) point.inverse_distance *= 0.01;
  std::mt19937 random(9);
  for (BundleObservation& o : bundle.observations) {
    const Projection seen = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens,
                                          bundle.points[static_cast<size_t>(o.point)]);
    const double x = uniform(random, -2, 2), y = uniform(random, -2, 2);
    o.position_px = seen.position_px + Eigen::Vector2d(x, y);
  }
  return KnownSweep(std::move(bundle));
}

TEST(IterativeRefinement, KeepsPointsOnThisSideOfInfinityWhereAsked) {
  const KnownSweep known = far_away();
  for (const bool asked : {false, true}) {
    Reconstruction found = known.found;
    IterativeRefinement refinement(known.sweep, FocalPrior{700, 0.1}, Job{});
    if (asked) refinement.enforce_cheirality();
    refinement.iterate(known.found.tracks, 12, 0.02, found);
    const auto beyond = [](const InversePoint& point) { return point.inverse_distance < -1e-9; };
    EXPECT_EQ(std::any_of(found.bundle.points.begin(), found.bundle.points.end(), beyond), !asked);
  }
}

TEST(ShareBeyondInfinity, IsOfPointsThatNoiseHardlyPutsThere) {
  Bundle bundle = full_turn_bundle();
  EXPECT_EQ(share_beyond_infinity(bundle), 0);
  for (size_t i = 0; i < bundle.points.size(); ++i)
    bundle.points[i].inverse_distance = i % 4 == 0 ? -0.05 : i % 2 == 0 ? -0.01 : 0.1;
  EXPECT_NEAR(share_beyond_infinity(bundle), 0.25, 1e-3);
  EXPECT_EQ(share_beyond_infinity(Bundle{}), 0);
}

TEST(Doubt, IsSilentAboutTruePoses) { EXPECT_EQ(KnownSweep().doubted(), ""); }

TEST(Doubt, NamesPhotosWhoseMatchesContradictTheirPoses) {
  KnownSweep known;
  Pose& pose = known.found.bundle.cameras[0];
  pose.world_from_camera = pose.world_from_camera * turn(3, 0, 0);
  EXPECT_THAT(known.doubted(), HasSubstr("matches in photo 0 and photo 1 agrees"));
}

TEST(Doubt, NamesThePlaceThatFewPointsBridge) {
  KnownSweep known;
  int left = 0;
  for (Track& track : known.found.tracks) {
    const bool bridges = track.size() > 1 && track.front().frame < 4 && track.back().frame >= 4;
    if (bridges && ++left > 5) std::erase_if(track, [](const Observation& o) { return o.frame < 4; });
  }
  EXPECT_THAT(known.doubted(), HasSubstr("points tie photo 3 and photo 4 together, 28 degrees from the first"));
}

TEST(Doubt, NamesTheSeamOfAFullTurnThatFewPointsClose) {
  KnownSweep known(full_turn_bundle());
  EXPECT_EQ(known.doubted(), "");
  int left = 0;
  for (Track& track : known.found.tracks) {
    const bool bridges = track.front().frame <= 4 && track.back().frame >= 11;
    if (bridges && ++left > 3) std::erase_if(track, [](const Observation& o) { return o.frame <= 4; });
  }
  EXPECT_THAT(known.doubted(), HasSubstr("only 3 points tie photo 15 and photo 0 together, where the turn closes "
                                         "(338 degrees"));
  EXPECT_EQ(doubt(known.sweep, known.found, known.names, false).kind, PoseDoubt::loose);
}

TEST(Doubt, TellsOfStepsThatNoThirdPhotoCompares) {
  KnownSweep known;
  std::vector<Track> pairs;
  for (const Track& track : known.found.tracks) {  // each point is seen by two neighbours only
    for (size_t i = 0; i + 1 < track.size(); ++i) pairs.push_back({track[i], track[i + 1]});
  }
  known.found.tracks = pairs;
  EXPECT_THAT(known.doubted(), HasSubstr("hardly a point is seen in three photos"));
  EXPECT_THAT(known.doubted(), HasSubstr("field of view"));
  EXPECT_THAT(doubt(known.sweep, known.found, known.names, true).text, testing::Not(HasSubstr("field of view")));
}

TEST(Doubt, TellsOfALensThatNoCameraHas) {
  KnownSweep known;
  known.sweep.pairs.clear();
  known.found.bundle.lens.focal_px = 1e4;
  EXPECT_THAT(known.doubted(), HasSubstr("a camera that sees 5 degrees"));
  EXPECT_THAT(known.doubted(), HasSubstr("field of view"));
  EXPECT_EQ(doubt(known.sweep, known.found, known.names, true).text, "");
  EXPECT_EQ(doubt(known.sweep, known.found, known.names, false).kind, PoseDoubt::lens);
}

// Matches in all of a row of ten cells, most of them in one; points in that one and its neighbour.
TEST(Coverage, IsOfCellsAndNotOfPoints) {
  MatchedSweep sweep;
  Reconstruction r;
  sweep.features.resize(3);
  r.left_out.resize(3);
  sweep.pairs = {{0, 1, {}}, {1, 2, {}}};
  for (Features& photo : sweep.features) photo.width = 1000, photo.height = 500;
  for (int i = 0; i < 30; ++i) {
    const double x = i < 10 ? 50 + 100 * i : 20 + i;
    for (Features& photo : sweep.features) photo.positions.emplace_back(x, 25);
    for (PairMatches& pair : sweep.pairs) pair.matches.push_back({i, i, 0});
    if (x > 200) continue;
    const Eigen::Vector2d from_middle(x - 500, 25 - 250);
    r.tracks.push_back({{0, i, from_middle}, {1, i, from_middle}});
  }
  EXPECT_EQ(coverage(sweep, r).explained, 2 * 2);
  EXPECT_EQ(coverage(sweep, r).matched, 3 * 10);
  r.left_out[2].cause = LeftOutCause::few_inliers;
  EXPECT_EQ(coverage(sweep, r).matched, 2 * 10);
  EXPECT_DOUBLE_EQ(coverage(sweep, r).share(), 0.2);
  EXPECT_DOUBLE_EQ(coverage(MatchedSweep{}, Reconstruction{}).share(), 1);
}

TEST(IsIllConditioned, IsAnOpenArcOfWhichNoThirdPhotoComparesSteps) {
  KnownSweep known;
  EXPECT_FALSE(is_ill_conditioned(known.found));
  for (Track& track : known.found.tracks) track.resize(std::min<size_t>(track.size(), 2));
  EXPECT_TRUE(is_ill_conditioned(known.found));
  known.found.closed = true;
  EXPECT_FALSE(is_ill_conditioned(known.found));
  known.found.closed = false;
  known.found.motion = Motion::straight;
  EXPECT_FALSE(is_ill_conditioned(known.found));
}

TEST(IsIllConditioned, IsAnArcThatOnePhotoHoldsLoosely) {
  for (const int loose : {1, 4, 6}) {
    KnownSweep known;
    for (Track& track : known.found.tracks)
      std::erase_if(track, [&](const Observation& o) { return o.frame == loose; });
    EXPECT_TRUE(is_ill_conditioned(known.found)) << loose;
    known.found.left_out[static_cast<size_t>(loose)].cause = LeftOutCause::few_inliers;
    EXPECT_FALSE(is_ill_conditioned(known.found)) << loose;
  }
}

TEST(BreaksConnectivity, IsToLoseHalfOfWhatOthersExplainAcrossAStep) {
  EXPECT_EQ(tracks_across_steps({{{0}, {1}, {3}}, {{1}, {2}}, {{0}, {1}}}, 4), (std::vector<int>{2, 1, 0, 0}));
  EXPECT_FALSE(breaks_connectivity({200, 51, 0}, {200, 100, 0}));
  EXPECT_TRUE(breaks_connectivity({200, 49, 0}, {200, 100, 0}));
  EXPECT_FALSE(breaks_connectivity({200, 3, 0}, {200, 10, 0}));
}

TEST(ResectLostFrames, PutsAFrameWhereItsMatchesWantIt) {
  KnownSweep known;
  const std::vector<Pose> truth = known.found.bundle.cameras;
  std::vector<Pose>& cameras = known.found.bundle.cameras;
  for (const size_t lost : {size_t{0}, size_t{5}, size_t{7}}) {
    cameras[lost].world_from_camera = turn(2, 20, 0) * cameras[lost].world_from_camera;
    cameras[lost].centre = cameras[lost].world_from_camera.col(2);
    EXPECT_TRUE(resect_lost_frames(known.sweep, known.found));
    for (size_t i = 0; i < cameras.size(); ++i) {
      EXPECT_LT(angle_deg(cameras[i].world_from_camera, truth[i].world_from_camera), i == lost ? 1.5 : 1e-5);
    }
    cameras[lost] = truth[lost];
  }
}

TEST(ResectLostFrames, LeavesThoseThatAgreeAndThoseWithoutAPose) {
  KnownSweep known;
  EXPECT_FALSE(resect_lost_frames(known.sweep, known.found));
  Pose& pose = known.found.bundle.cameras[5];
  pose.world_from_camera = turn(2, 20, 0) * pose.world_from_camera;
  known.found.left_out[5].cause = LeftOutCause::few_inliers;
  EXPECT_FALSE(resect_lost_frames(known.sweep, known.found));
}

// Cameras of a hand that leaves its circle by a tenth of it, seen sharply by points that are far.
KnownSweep wandering() {
  KnownSweep known;
  std::mt19937 random(12);
  Bundle& bundle = known.found.bundle;
  bundle.lens.k1 = bundle.lens.k2 = 0;
  for (Pose& pose : bundle.cameras) {
    const double x = uniform(random, -0.15, 0.15), y = uniform(random, -0.15, 0.15), z = uniform(random, -0.15, 0.15);
    pose.centre = pose.world_from_camera.col(2) + Eigen::Vector3d(x, y, z);
  }
  for (InversePoint& point : bundle.points) point.inverse_distance *= 0.1;
  for (Track& track : known.found.tracks) track.clear();
  for (BundleObservation& o : bundle.observations) {
    const size_t point = static_cast<size_t>(o.point);
    const Projection p =
        project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens, bundle.points[point]);
    o.position_px = p.position_px + Eigen::Vector2d(uniform(random, -0.05, 0.05), uniform(random, -0.05, 0.05));
    known.found.tracks[point].push_back({o.camera, -1, o.position_px});
  }
  return known;
}

TEST(IterativeRefinement, BelievesThatAHandLeavesItsCircleAsFarAsItSeemed) {
  KnownSweep known = wandering();
  const std::vector<Track> tracks = known.found.tracks;
  IterativeRefinement refinement(known.sweep, {}, Job{}), free = refinement;
  free.set_min_arc_sigma(kWideArcSigma);
  Reconstruction unheld = known.found;
  for (const double tolerance : kKltTolerances_px) free.iterate(tracks, tolerance, kArcSigma, unheld);
  const double scatter = scatter_about_arc(unheld);
  refinement.iterate(tracks, kKltTolerances_px[0], kArcSigma, known.found);
  const double held_back = scatter - scatter_about_arc(known.found);
  refinement.iterate(tracks, kKltTolerances_px[1], kArcSigma, known.found);
  EXPECT_GT(held_back, 0.05 * scatter);
  EXPECT_LT(std::abs(scatter - scatter_about_arc(known.found)), 0.3 * held_back);
}

TEST(IterativeRefinement, KeepTheBendOfTheLensWhereAsked) {
  KnownSweep known;
  const std::vector<Track> tracks = known.found.tracks;
  const Lens truth = known.found.bundle.lens;
  known.found.bundle.lens.k1 = 0.04;
  IterativeRefinement refinement(known.sweep, {}, Job{});
  refinement.iterate(tracks, kMatchTolerances_px[2], kWideArcSigma, known.found);
  refinement.select_distortion_model(known.found);
  ASSERT_TRUE(refinement.refines_distortion());
  EXPECT_NEAR(known.found.bundle.lens.k1, truth.k1, 0.005);
  known.found.bundle.lens.k1 = 0.05;
  IterativeRefinement keeping = refinement;
  keeping.fix_distortion();
  Reconstruction kept = known.found;
  keeping.iterate(tracks, kMatchTolerances_px[2], kWideArcSigma, kept);
  EXPECT_EQ(kept.bundle.lens.k1, 0.05);
  refinement.iterate(tracks, kMatchTolerances_px[2], kWideArcSigma, known.found);
  EXPECT_NEAR(known.found.bundle.lens.k1, truth.k1, 0.005);
}

TEST(Doubt, NamesPhotosOfOneViewThatShareNothing) {
  KnownSweep known;
  known.found.bundle.cameras[7] = known.found.bundle.cameras[0];
  known.sweep.pairs.pop_back();
  for (Track& track : known.found.tracks) {
    if (!track.empty() && track.front().frame == 0)
      std::erase_if(track, [](const Observation& o) { return o.frame == 7; });
  }
  EXPECT_THAT(known.doubted(), HasSubstr("photo 0 and photo 7 look the same way"));
}

}  // namespace
}  // namespace ldp::sfm
