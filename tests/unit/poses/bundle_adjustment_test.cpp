#include "core/poses/adjust/bundle_adjustment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "core/poses/adjust/distortion_model.h"
#include "core/poses/adjust/robust_tracks.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

// A truth whose points are seen by all, except some that only the two cameras in the middle see, and that moved between
// them.
Bundle with_movers(const Bundle& truth) {
  Bundle bundle = truth;
  std::erase_if(bundle.observations,
                [](const BundleObservation& o) { return o.point % 2 == 0 && o.camera != 3 && o.camera != 4; });
  for (BundleObservation& o : bundle.observations) {
    if (o.point % 2 == 0 && o.camera == 4) o.position_px.y() += 3;
  }
  return bundle;
}

TEST(Adjust, BelievesPointsThatAThirdCameraConfirmsRatherThanPairsAgainstThem) {
  const Bundle truth = true_bundle(MotionModel::free);
  const auto between = [](const Bundle& b) -> Eigen::Matrix3d {
    return b.cameras[4].world_from_camera.transpose() * b.cameras[3].world_from_camera;
  };
  const auto gap_at_weight = [&](double weight) {
    Bundle bundle = with_movers(truth);
    BundleAdjustmentOptions options;
    options.loss_px = 5;
    options.arc_sigma = 10;
    options.two_view_weight = weight;
    EXPECT_TRUE(adjust_bundle(bundle, options, Job{}).usable);
    return angle_deg(between(bundle), between(truth));
  };
  EXPECT_LT(gap_at_weight(0.05), 0.2 * gap_at_weight(1));
}

// A truth of two halves that no point ties together, the second one turned away.
Bundle in_halves(const Bundle& truth) {
  Bundle bundle = truth;
  std::erase_if(bundle.observations, [](const BundleObservation& o) { return (o.camera < 4) != (o.point % 2 == 0); });
  const Eigen::Matrix3d away = turn(0, 4, 0);
  for (size_t i = 4; i < bundle.cameras.size(); ++i) {
    Pose& pose = bundle.cameras[i];
    pose = {away * pose.world_from_camera, away * pose.centre};
  }
  for (InversePoint& point : bundle.points)
    if ((&point - bundle.points.data()) % 2 == 1) point.direction = away * point.direction;
  return bundle;
}

class StepPriors : public testing::TestWithParam<MotionModel> {};

TEST_P(StepPriors, DecideWhatPointsLeaveOpen) {
  const Bundle truth = true_bundle(GetParam());
  const auto step = [](const Bundle& b) -> Eigen::Matrix3d {
    return b.cameras[4].world_from_camera.transpose() * b.cameras[3].world_from_camera;
  };
  Bundle without = in_halves(truth), with = without;
  BundleAdjustmentOptions options;
  options.model = GetParam();
  options.refine_focal = false;
  options.function_tolerance = 1e-12;
  options.max_iterations = 200;
  EXPECT_TRUE(adjust_bundle(without, options, Job{}).usable);
  EXPECT_GT(angle_deg(step(without), step(truth)), 3);
  options.step_priors = {{3, 4, step(truth), 2 * kDegree}};
  EXPECT_TRUE(adjust_bundle(with, options, Job{}).usable);
  EXPECT_LT(angle_deg(step(with), step(truth)), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Models, StepPriors, testing::Values(MotionModel::spherical, MotionModel::free),
                         [](const auto& model) {
                           return model.param == MotionModel::spherical ? "spherical" : "free";
                         });

// A truth whose points three cameras each see, the last of them another thing of every tenth, beside it along the path,
// as where an edge lies before what is farther: any depth leaves all three observations wrong.
Bundle with_edges(const Bundle& truth) {
  Bundle bundle = truth;
  std::erase_if(bundle.observations,
                [](const BundleObservation& o) { return std::abs(o.camera - o.point % 6 - 1) > 1; });
  for (BundleObservation& o : bundle.observations) {
    if (o.point % 10 == 0 && o.camera == o.point % 6 + 2) o.position_px.x() += 6;
  }
  return bundle;
}

TEST(AdjustWithTrackWeights, BelievesNothingOfATrackThatShowsTwoThings) {
  const Bundle truth = true_bundle(MotionModel::free);
  BundleAdjustmentOptions options;
  options.loss_px = 0.5;
  options.refine_focal = false;
  options.arc_sigma = 10;
  Bundle bundle = with_edges(truth);
  ASSERT_TRUE(adjust_bundle(bundle, options, Job{}).usable);
  const auto gap = [&] {
    const auto between = [](const Bundle& b) -> Eigen::Matrix3d {
      return b.cameras[7].world_from_camera.transpose() * b.cameras[0].world_from_camera;
    };
    return angle_deg(between(bundle), between(truth));
  };
  const double by_observations = gap();
  adjust_with_track_weights(bundle, options, 0.5, Job{});
  EXPECT_LT(gap(), 0.3 * by_observations) << by_observations;
  for (const BundleObservation& o : bundle.observations) EXPECT_EQ(o.weight, 1);
}

// Two fifths of what one camera sees are beside where they should be, all to the same side: too near for a wide scale
// to leave them alone.
TEST(AdjustWithNarrowTrackWeights, PutsACameraWhereMostOfWhatItSeesSaysExactly) {
  const Bundle truth = true_bundle(MotionModel::free);
  Bundle bundle = truth;
  for (BundleObservation& o : bundle.observations) {
    if (o.point % 5 < 2 && o.camera == 4) o.position_px.x() += 3;
  }
  BundleAdjustmentOptions options;
  options.arc_sigma = 10;
  ASSERT_TRUE(adjust_bundle(bundle, options, Job{}).usable);
  adjust_with_track_weights(bundle, options, 1, Job{});
  const auto gap = [&] {
    const auto between = [](const Bundle& b) -> Eigen::Matrix3d {
      return b.cameras[4].world_from_camera.transpose() * b.cameras[3].world_from_camera;
    };
    return angle_deg(between(bundle), between(truth));
  };
  const double before = gap();
  EXPECT_TRUE(adjust_with_narrow_track_weights(bundle, options, 1, Job{}));
  EXPECT_LT(gap(), 0.1 * before) << before;
  for (const BundleObservation& o : bundle.observations) EXPECT_EQ(o.weight, 1);
}

TEST(AdjustWithNarrowTrackWeights, LeavesCamerasWhereNoneAreClearlyBetter) {
  std::mt19937 random(8);
  Bundle bundle = true_bundle(MotionModel::free);
  for (BundleObservation& o : bundle.observations)
    o.position_px += 0.5 * Eigen::Vector2d(uniform(random, -1, 1), uniform(random, -1, 1));
  BundleAdjustmentOptions options;
  options.arc_sigma = 10;
  ASSERT_TRUE(adjust_bundle(bundle, options, Job{}).usable);
  adjust_with_track_weights(bundle, options, 1, Job{});
  const Bundle before = bundle;
  EXPECT_FALSE(adjust_with_narrow_track_weights(bundle, options, 1, Job{}));
  for (size_t i = 0; i < before.cameras.size(); ++i) EXPECT_EQ(bundle.cameras[i].centre, before.cameras[i].centre);
}

class AdjustModel : public testing::TestWithParam<MotionModel> {};

TEST_P(AdjustModel, ReturnsToTheTruthFromADisturbedStart) {
  const Bundle truth = true_bundle(GetParam());
  Bundle bundle = truth;
  bundle.lens = {740, 0, 0};
  for (size_t i = 0; i < bundle.cameras.size(); ++i) {
    Pose& p = bundle.cameras[i];
    p.world_from_camera = p.world_from_camera * turn(0.3, i % 2 == 0 ? 0.5 : -0.5, 0.2);
    p.centre = p.world_from_camera.col(2);
  }
  BundleAdjustmentOptions options;
  options.model = GetParam();
  options.refine_distortion = true;
  options.loss_px = 5;
  options.arc_sigma = 10;
  options.max_iterations = 200;
  const Eigen::Matrix3d held = bundle.cameras[4].world_from_camera;
  EXPECT_TRUE(adjust_bundle(bundle, options, Job{}).usable);
  EXPECT_LT(angle_deg(bundle.cameras[4].world_from_camera, held), 1e-6) << "the world turned, which nothing asks for";
  EXPECT_NEAR(bundle.lens.focal_px, 700, 1);
  for (size_t i = 1; i < bundle.cameras.size(); ++i) {
    const Eigen::Matrix3d found = bundle.cameras[i].world_from_camera.transpose() * bundle.cameras[0].world_from_camera;
    const Eigen::Matrix3d wanted = truth.cameras[i].world_from_camera.transpose() * truth.cameras[0].world_from_camera;
    EXPECT_LT(angle_deg(found, wanted), 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryModel, AdjustModel,
                         testing::Values(MotionModel::rotation, MotionModel::spherical, MotionModel::free),
                         [](const auto& model) {
                           return model.param == MotionModel::rotation    ? "rotation"
                                  : model.param == MotionModel::spherical ? "spherical"
                                                                          : "free";
                         });

TEST(Adjust, GivesTheSameBytesAtAnyThreadCount) {
  const auto adjusted = [](int threads) {
    Bundle bundle = true_bundle(MotionModel::free);
    bundle.lens = {720, 0, 0};
    Job job;
    job.threads = threads;
    BundleAdjustmentOptions options;
    options.refine_distortion = true;
    adjust_bundle(bundle, options, job);
    return bundle;
  };
  const Bundle one = adjusted(1), three = adjusted(3);
  EXPECT_EQ(one.lens.focal_px, three.lens.focal_px);
  for (size_t i = 0; i < one.cameras.size(); ++i) {
    EXPECT_EQ(one.cameras[i].world_from_camera, three.cameras[i].world_from_camera);
    EXPECT_EQ(one.cameras[i].centre, three.cameras[i].centre);
  }
}

TEST(Adjust, KeepsPointsThisSideOfInfinityWhereAsked) {
  const auto farthest = [](bool in_front) {
    Bundle bundle = true_bundle(MotionModel::free);
    for (size_t i = 0; i < bundle.points.size(); i += 2) bundle.points[i].inverse_distance = -0.02;
    for (BundleObservation& o : bundle.observations) {
      o.position_px = project_point(bundle.cameras[static_cast<size_t>(o.camera)], bundle.lens,
                                    bundle.points[static_cast<size_t>(o.point)])
                          .position_px;
    }
    BundleAdjustmentOptions options;
    options.enforce_cheirality = in_front;
    EXPECT_TRUE(adjust_bundle(bundle, options, Job{}).usable);
    double least = 0;
    for (const BundleObservation& o : bundle.observations)
      least = std::min(least, bundle.points[static_cast<size_t>(o.point)].inverse_distance);
    return least;
  };
  EXPECT_EQ(farthest(true), 0);
  EXPECT_LT(farthest(false), -0.01);
}

// Whether a lens is found to bend by so many variances: pictures of one with this k1, points found to a third of a
// pixel.
bool bends(double k1, bool on_klt_tracks) {
  Bundle bundle = true_bundle(MotionModel::free);
  bundle.lens = {700, 0, 0};
  std::mt19937 random(3);
  for (BundleObservation& o : bundle.observations) {
    Lens lens = bundle.lens;
    lens.k1 = k1;
    o.position_px =
        project_point(bundle.cameras[static_cast<size_t>(o.camera)], lens, bundle.points[static_cast<size_t>(o.point)])
            .position_px;
    o.position_px += Eigen::Vector2d(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5));
  }
  BundleAdjustmentOptions options;
  options.arc_sigma = 0.05;
  const BundleAdjustmentSummary straight = adjust_bundle(bundle, options, Job{});
  EXPECT_TRUE(straight.usable);
  const std::optional<Bundle> bent =
      adjust_with_distortion(bundle, options, straight.cost, min_distortion_gain(bundle, on_klt_tracks), Job{});
  if (bent) {
    EXPECT_NEAR(bent->lens.k1, k1, 0.02);
  }
  return bent.has_value();
}

TEST(AdjustWithDistortion, IsFreedWhereItExplainsClearlyMore) {
  for (const bool on_klt_tracks : {false, true}) {
    EXPECT_TRUE(bends(-0.05, on_klt_tracks));
    EXPECT_TRUE(bends(0.05, on_klt_tracks));
  }
}

TEST(AdjustWithDistortion, IsFreedByLessOnTracksThanOnMatches) {
  EXPECT_TRUE(bends(-0.003, true));
  EXPECT_FALSE(bends(-0.003, false));
}

TEST(AdjustWithDistortion, StaysStraightWhereItExplainsTheNoiseALittleBetter) {
  EXPECT_FALSE(bends(0, false));
  EXPECT_FALSE(bends(0, true));
}

}  // namespace
}  // namespace ldp::sfm
