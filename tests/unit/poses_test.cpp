#include "core/poses/poses.h"
#include "core/poses/start/rotation_averaging.h"
#include "core/poses/tracks/track_triangulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/adjust/depth_outliers.h"
#include "core/poses/adjust/distortion_model.h"
#include "core/poses/adjust/robust_tracks.h"
#include "core/poses/features/descriptor_distance.h"
#include "core/poses/features/descriptor_matching.h"
#include "core/poses/pose_doubt.h"
#include "core/poses/refine/arc_conditioning.h"
#include "core/poses/refine/iterative_refinement.h"
#include "core/poses/refine/resection.h"
#include "core/poses/refine/smooth_motion.h"
#include "core/poses/start/motion_model.h"
#include "core/poses/start/spherical_motion.h"
#include "core/poses/tracks/guided_matching.h"
#include "core/poses/tracks/tracks.h"
#include "sim/scene/picture.h"
#include "sim/scene/scenes.h"
#include "sim/scene/sweep_path.h"

namespace ldp::sfm {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
using testing::HasSubstr;

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
}

Eigen::Matrix3d turn(double x_deg, double y_deg, double z_deg) {
  return (Eigen::AngleAxisd(y_deg * kDegree, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(x_deg * kDegree, Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(z_deg * kDegree, Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

double angle_deg(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.transpose() * b)).angle() / kDegree;
}

Features features_of(const std::vector<std::vector<int16_t>>& descriptors) {
  Features f{100, 100, {}, {}};
  for (const auto& d : descriptors) {
    f.positions.emplace_back(f.size(), 2 * f.size());
    f.descriptors.insert(f.descriptors.end(), d.begin(), d.end());
  }
  return f;
}

std::vector<int16_t> random_descriptor(std::mt19937& random) {
  std::vector<int16_t> d(kDescriptorLength);
  for (int16_t& value : d) value = static_cast<int16_t>(random() % 90);
  return d;
}

TEST(MatchFeatures, FindsEveryPointAmongItsLikes) {
  std::mt19937 random(1);
  std::vector<std::vector<int16_t>> a, b;
  for (int i = 0; i < 60; ++i) a.push_back(random_descriptor(random));
  for (int i = 59; i >= 0; --i) {
    b.push_back(a[static_cast<size_t>(i)]);
    b.back()[5] = static_cast<int16_t>(b.back()[5] + 3);
  }
  const std::vector<Match> matches = match_features(features_of(a), features_of(b), MatchOptions{});
  ASSERT_EQ(matches.size(), 60U);
  for (const Match& m : matches) {
    EXPECT_EQ(m.a + m.b, 59);
    EXPECT_EQ(m.distance, 9);
  }
}

TEST(MatchFeatures, APointWithATwinMatchesNothing) {
  std::mt19937 random(2);
  const std::vector<int16_t> one = random_descriptor(random), other = random_descriptor(random);
  EXPECT_TRUE(match_features(features_of({one}), features_of({one, one, other}), MatchOptions{}).empty());
}

// All against all, without tricks.
std::vector<Match> matches_by_hand(const Features& a, const Features& b, double ratio) {
  const auto nearest = [&](const Features& from, int i, const Features& to) {
    std::vector<std::pair<int, int>> found{{std::numeric_limits<int>::max(), -1}};
    for (int j = 0; j < to.size(); ++j) {
      int squared = 0;
      for (int k = 0; k < kDescriptorLength; ++k) {
        const int difference = from.descriptor(i)[k] - to.descriptor(j)[k];
        squared += difference * difference;
      }
      found.emplace_back(squared, j);
    }
    std::sort(found.begin(), found.end());
    const bool clear = found[0].first < ratio * ratio * found[1].first;
    return clear ? found[0] : std::pair(0, -1);
  };
  std::vector<Match> matches;
  for (int i = 0; i < a.size(); ++i) {
    const auto [distance, j] = nearest(a, i, b);
    if (j >= 0 && nearest(b, j, a).second == i) matches.push_back({i, j, distance});
  }
  return matches;
}

TEST(MatchFeatures, AgreesWithComparingAllByHandWhateverTheCounts) {
  std::mt19937 random(11);
  for (const auto& [count_a, count_b] : {std::pair(1, 2), {3, 65}, {130, 67}, {64, 128}}) {
    std::vector<std::vector<int16_t>> a, b;
    for (int i = 0; i < count_a; ++i) a.push_back(random_descriptor(random));
    for (int i = 0; i < count_b; ++i) {
      b.push_back(i % 3 == 0 ? random_descriptor(random) : a[static_cast<size_t>(7 * i % count_a)]);
      b.back()[static_cast<size_t>(i) % 128] = static_cast<int16_t>(random() % 90);
    }
    const Features fa = features_of(a), fb = features_of(b);
    EXPECT_EQ(match_features(fa, fb, MatchOptions{}), matches_by_hand(fa, fb, MatchOptions{}.ratio));
  }
}

TEST(DescriptorDistance, IsTheSameForEveryInstructionSet) {
  std::mt19937 random(12);
  constexpr int kCount = 71;
  std::vector<int16_t> one = random_descriptor(random), others;
  std::vector<int> squares, plain(kCount), best(kCount);
  for (int i = 0; i < kCount; ++i) {
    const std::vector<int16_t> d = random_descriptor(random);
    others.insert(others.end(), d.begin(), d.end());
    squares.push_back(static_cast<int>(random() % 100000));
  }
  descriptor_distance::plain().distances(one.data(), 77, others.data(), squares.data(), kCount, plain.data());
  descriptor_distance::best().distances(one.data(), 77, others.data(), squares.data(), kCount, best.data());
  EXPECT_EQ(plain, best);
  EXPECT_EQ(descriptor_distance::plain().minimum(plain.data(), kCount),
            descriptor_distance::best().minimum(plain.data(), kCount));
  std::vector<std::vector<int>> of_plain(3, std::vector<int>(kCount, 5000000)), of_best = of_plain;
  for (int candidate = 0; candidate < 5; ++candidate) {
    for (int& d : plain) d = static_cast<int>(random() % 1000);
    descriptor_distance::plain().update_nearest(plain.data(), candidate, kCount,
                                                {of_plain[0].data(), of_plain[1].data(), of_plain[2].data()});
    descriptor_distance::best().update_nearest(plain.data(), candidate, kCount,
                                               {of_best[0].data(), of_best[1].data(), of_best[2].data()});
  }
  EXPECT_EQ(of_plain, of_best);
}

// Pairs of points that look the same but stand at different heights, as repeated things do.
TEST(MatchGuided, TellsTwinsApartByTheirLinesOfSight) {
  std::mt19937 random(4);
  Bundle bundle;
  bundle.lens.focal_px = 500;
  bundle.cameras = {{Eigen::Matrix3d::Identity(), {0, 0, 1}}, {turn(0, 15, 0), turn(0, 15, 0).col(2)}};
  MatchedSweep sweep;
  sweep.features.resize(2, Features{800, 600, {}, {}});
  for (int i = 0; i < 40; ++i) {
    const std::vector<int16_t> look = random_descriptor(random);
    for (const double height : {-0.25, 0.25}) {
      const double depth = uniform(random, 2, 30);
      const Eigen::Vector3d x = depth * Eigen::Vector3d(uniform(random, -0.2, 0.4), height, 1);
      for (size_t frame = 0; frame < 2; ++frame) {
        Features& f = sweep.features[frame];
        const Projection p = project_point(bundle.cameras[frame], bundle.lens, {x.normalized(), 1 / x.norm()});
        f.positions.emplace_back(p.position_px + Eigen::Vector2d(400, 300));
        f.descriptors.insert(f.descriptors.end(), look.begin(), look.end());
      }
    }
  }
  EXPECT_TRUE(match_features(sweep.features[0], sweep.features[1], MatchOptions{}).empty());
  const std::vector<PairMatches> pairs = match_guided(sweep, bundle, {"", ""}, Job{});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].matches.size(), 80U);
  for (const Match& m : pairs[0].matches) EXPECT_EQ(m.a, m.b);
  EXPECT_TRUE(match_guided(sweep, bundle, {"", "dropped"}, Job{}).empty());
}

TEST(BuildTracks, JoinsMatchesAndLeavesOutContradictions) {
  std::mt19937 random(3);
  std::vector<std::vector<int16_t>> some;
  for (int i = 0; i < 5; ++i) some.push_back(random_descriptor(random));
  const std::vector<Features> features(3, features_of(some));
  // 0.1 - 1.1 - 2.1 is a track; the poor match 2.1 - 0.4 would put two places of frame 0 into it.
  const std::vector<Track> tracks =
      build_tracks(features, {{0, 1, {{1, 1, 5}}}, {1, 2, {{1, 1, 5}}}, {0, 2, {{4, 1, 50}}}});
  ASSERT_EQ(tracks.size(), 1U);
  ASSERT_EQ(tracks[0].size(), 3U);
  for (const Observation& o : tracks[0]) EXPECT_EQ(o.feature, 1);
}

TEST(TriangulatePoint, FindsNearFarAndInfinitelyFarPoints) {
  for (const double w : {1.5, 0.3, 0.01, 0.0}) {
    const InversePoint truth{Eigen::Vector3d(0.3, -0.1, 1).normalized(), w};
    std::vector<Sighting> sightings;
    for (int i = -1; i <= 1; ++i) {
      const Eigen::Vector3d centre(0.2 * i, 0.05, -0.1 * i * i);
      const Eigen::Matrix3d camera_from_world = turn(2 * i, -8 * i, i);
      sightings.push_back({camera_from_world, centre, (camera_from_world * truth.seen_from(centre)).hnormalized()});
    }
    const auto point = triangulate_point(sightings);
    ASSERT_TRUE(point.has_value());
    EXPECT_NEAR(point->inverse_distance, w, 1e-9);
    EXPECT_LT((point->direction - truth.direction).norm(), 1e-9);
  }
}

TEST(TriangulatePoint, LeavesOutTheSightingThatDisagrees) {
  const InversePoint truth{Eigen::Vector3d::UnitZ(), 0.5};
  std::vector<Sighting> sightings;
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d centre(0.1 * i, 0, 0);
    sightings.push_back({Eigen::Matrix3d::Identity(), centre, truth.seen_from(centre).hnormalized()});
  }
  sightings[2].position.y() += 0.1;
  std::vector<bool> used;
  const auto point = triangulate_point_robustly(sightings, 0.01, used);
  ASSERT_TRUE(point.has_value());
  EXPECT_EQ(used, (std::vector<bool>{true, true, false, true, true}));
  EXPECT_NEAR(point->inverse_distance, 0.5, 1e-9);
}

TEST(NormalisedError, IsInfiniteForAPointInTheCamera) {
  const Sighting sighting{Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 1), Eigen::Vector2d::Zero()};
  EXPECT_NEAR(normalised_error({Eigen::Vector3d::UnitZ(), 0.9}, sighting), 0, 1e-12);
  EXPECT_TRUE(std::isinf(normalised_error({Eigen::Vector3d::UnitZ(), 0.999}, sighting)));
}

std::vector<RayPair> spherical_pairs(const Eigen::Matrix3d& b_from_a, double nearest_w, double farthest_w) {
  std::mt19937 random(4);
  std::vector<RayPair> pairs;
  while (pairs.size() < 150) {
    const double x = uniform(random, -0.5, 0.5), y = uniform(random, -0.4, 0.4);
    const Eigen::Vector3d a(x, y, 1);
    const double w = uniform(random, farthest_w, nearest_w);
    const Eigen::Vector3d b = b_from_a * (a + w * Eigen::Vector3d::UnitZ()) - w * Eigen::Vector3d::UnitZ();
    if (b.z() > 0.1) pairs.push_back({a.hnormalized(), b.hnormalized()});
  }
  return pairs;
}

TEST(SphericalRotation, IsFoundForNearScenesAndForPureRotation) {
  const Eigen::Matrix3d truth = turn(1, 12, -2);
  for (const double near : {0.0, 0.1, 0.6}) {
    const RelativeRotation found = spherical_rotation(spherical_pairs(truth, near, 0), 0.002);
    EXPECT_LT(angle_deg(found.b_from_a, truth), 0.05) << "nearest inverse distance " << near;
  }
}

TEST(SphericalRotation, BearsAThirdOfWrongPairs) {
  const Eigen::Matrix3d truth = turn(1, 12, -2);
  std::vector<RayPair> pairs = spherical_pairs(truth, 0.5, 0);
  std::mt19937 random(5);
  for (size_t i = 0; i < pairs.size(); i += 3) {
    const double x = uniform(random, -0.5, 0.5), y = uniform(random, -0.4, 0.4);
    pairs[i].b = {x, y};
  }
  EXPECT_LT(angle_deg(spherical_rotation(pairs, 0.002).b_from_a, truth), 0.3);
}

TEST(SphericalRotation, StaysWithWhatThePicturesShowWhereLinesTellLittle) {
  // Twenty points of a view of 8 degrees, half a pixel of 800 off: hundreds of rotations fit their epipolar lines.
  const Eigen::Matrix3d truth = turn(0.3, 3, 0.2);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<RayPair> pairs;
    while (pairs.size() < 20) {
      const Eigen::Vector3d a(uniform(random, -0.07, 0.07), uniform(random, -0.05, 0.05), 1);
      const double w = uniform(random, 0, 0.2);
      const Eigen::Vector3d b = truth * (a + w * Eigen::Vector3d::UnitZ()) - w * Eigen::Vector3d::UnitZ();
      const Eigen::Vector2d off(uniform(random, -9e-5, 9e-5), uniform(random, -9e-5, 9e-5));
      pairs.push_back({a.hnormalized(), b.hnormalized() + off});
    }
    EXPECT_LT(angle_deg(spherical_rotation(pairs, 0.0007).b_from_a, truth), 1) << "seed " << seed;
  }
}

TEST(PureRotation, IsThatOfWhatIsFarAndNotHalfwayToWhatIsNear) {
  const Eigen::Matrix3d truth = turn(1, 12, -2);
  std::vector<RayPair> pairs = spherical_pairs(truth, 0, 0);
  const std::vector<RayPair> near = spherical_pairs(truth, 0.6, 0.4);
  pairs.insert(pairs.end(), near.begin(), near.begin() + 50);
  const RelativeRotation found = pure_rotation(pairs);
  EXPECT_LT(angle_deg(found.b_from_a, truth), 0.5);
  EXPECT_GT(found.cost, 0.1);
  pairs.resize(pairs.size() - 50);
  EXPECT_NEAR(pure_rotation(pairs).cost, 0, 1e-9);
}

TEST(AverageRotations, ClosesALoopAndIgnoresAFalseEdge) {
  std::vector<RotationEdge> edges;
  const Eigen::Matrix3d step = turn(0, 36, 0);  // b_from_a; ten of them are a full turn
  for (int i = 0; i < 10; ++i) edges.push_back({i, (i + 1) % 10, step, 100});
  edges.push_back({2, 7, turn(0, 60, 20), 20});
  std::vector<bool> reached;
  const std::vector<Eigen::Matrix3d> world = average_rotations(10, 0, edges, reached);
  for (size_t i = 0; i < 10; ++i) {
    EXPECT_TRUE(reached[i]);
    EXPECT_LT(angle_deg(world[(i + 1) % 10].transpose() * world[i], step), 0.5);
  }
}

Bundle true_bundle(MotionModel model) {
  std::mt19937 random(6);
  Bundle bundle;
  bundle.lens = {700, 0.02, -0.01};
  for (int i = 0; i < 8; ++i) {
    const Eigen::Matrix3d r = turn(i % 2, 8.0 * i, 0.5 * (i % 3));
    const double x = uniform(random, -0.03, 0.03), y = uniform(random, -0.03, 0.03);
    bundle.cameras.push_back({r, model == MotionModel::free ? Eigen::Vector3d(r.col(2) + Eigen::Vector3d(x, y, -x))
                                                            : Eigen::Vector3d(r.col(2))});
  }
  for (int i = 0; i < 400; ++i) {
    const double azimuth = uniform(random, -20, 76), elevation = uniform(random, -20, 20),
                 w = uniform(random, 0.05, 0.5);
    bundle.points.push_back({turn(elevation, azimuth, 0).col(2), model == MotionModel::rotation ? 0 : w});
    for (int c = 0; c < 8; ++c) {
      const Projection p = project_point(bundle.cameras[static_cast<size_t>(c)], bundle.lens, bundle.points.back());
      if (p.in_front && p.position_px.cwiseAbs().maxCoeff() < 400) bundle.observations.push_back({c, i, p.position_px});
    }
  }
  return bundle;
}

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

TEST(TriangulateInliers, LeavesOutATrackOfWhichOnlyHalfAgrees) {
  Bundle bundle = true_bundle(MotionModel::free);
  const auto track_of = [&](int point) {
    Track track;
    for (const BundleObservation& o : bundle.observations) {
      if (o.point == point && track.size() < 4) track.push_back({o.camera, -1, o.position_px});
    }
    return track;
  };
  std::vector<Track> tracks;
  for (int point = 0; tracks.size() < 3; ++point) {
    if (Track track = track_of(point); track.size() == 4) tracks.push_back(std::move(track));
  }
  tracks[1][0].position_px.y() += 40;  // three of four agree
  tracks[2][0].position_px.y() += 40, tracks[2][2].position_px.y() -= 60;
  const std::vector<Track> kept = triangulate_inliers(tracks, 3, false, bundle, Job{});
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].size(), 4U);
  EXPECT_EQ(kept[1].size(), 3U);
  EXPECT_EQ(bundle.points.size(), 2U);
}

// Whether a lens is found to bend by so many variances: pictures of one with this k1, points found to a third of a
// pixel.
bool bends(double k1) {
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
  const std::optional<Bundle> bent = adjust_with_distortion(bundle, options, straight.cost, Job{});
  if (bent) {
    EXPECT_NEAR(bent->lens.k1, k1, 0.02);
  }
  return bent.has_value();
}

TEST(AdjustWithDistortion, IsFreedWhereItExplainsClearlyMore) {
  EXPECT_TRUE(bends(-0.05));
  EXPECT_TRUE(bends(0.05));
}

TEST(AdjustWithDistortion, StaysStraightWhereItExplainsTheNoiseALittleBetter) { EXPECT_FALSE(bends(0)); }

// Points of a wall seen by the two cameras in the middle; the one amid them is at another inverse distance, and a third
// camera may see it.
std::vector<bool> depth_outliers_of_a_wall(double other, bool third) {
  Bundle bundle = true_bundle(MotionModel::free);
  bundle.points.clear();
  std::vector<Track> tracks;
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector3d direction =
        bundle.cameras[3].world_from_camera * Eigen::Vector3d(0.05 * (i % 5 - 2), 0.05 * (i / 5 - 2), 1).normalized();
    bundle.points.push_back({direction, i == 12 ? other : 0.2});
    Track track;
    for (int c = 3; c < (i == 12 && third ? 6 : 5); ++c) {
      const Projection p = project_point(bundle.cameras[static_cast<size_t>(c)], bundle.lens, bundle.points.back());
      track.push_back({c, -1, p.position_px});
    }
    tracks.push_back(std::move(track));
  }
  return depth_outliers(tracks, bundle, 5);
}

TEST(DepthOutliers, AreAsFarAsNothingAroundThem) {
  std::vector<bool> alone = depth_outliers_of_a_wall(0.6, false);
  EXPECT_TRUE(alone[12]);
  EXPECT_EQ(std::count(alone.begin(), alone.end(), true), 1);
  alone = depth_outliers_of_a_wall(0.21, false);
  EXPECT_EQ(std::count(alone.begin(), alone.end(), true), 0);
}

TEST(DepthOutliers, AreBelievedWhereAThirdPhotoSeesThem) { EXPECT_FALSE(depth_outliers_of_a_wall(0.6, true)[12]); }

TEST(DepthOutliers, BeyondInfinityAreNot) { EXPECT_TRUE(depth_outliers_of_a_wall(-0.09, true)[12]); }

TEST(DepthOutliers, AreNoneWhereTheCamerasAreWrong) {
  Bundle bundle = true_bundle(MotionModel::free);
  std::vector<Track> tracks;
  for (InversePoint& point : bundle.points) {
    tracks.push_back({{3, -1, Eigen::Vector2d::Zero()}, {4, -1, Eigen::Vector2d::Zero()}});
    point.inverse_distance = -0.5;
  }
  const std::vector<bool> alone = depth_outliers(tracks, bundle, 5);
  EXPECT_EQ(std::count(alone.begin(), alone.end(), true), 0);
}

TEST(MotionRoughness, IsThatOfTheStepsAndNotOfHowTheCameraIsHeld) {
  Bundle bundle = true_bundle(MotionModel::spherical);
  const std::vector<std::string> dropped(bundle.cameras.size());
  EXPECT_NEAR(motion_roughness(dropped, bundle), 0, 1e-12);
  Bundle shifted = bundle;
  for (Pose& pose : shifted.cameras) pose.centre += Eigen::Vector3d(0.3, 0.2, 0.1);
  EXPECT_NEAR(motion_roughness(dropped, shifted), 0, 1e-12);
  for (size_t i = 4; i < bundle.cameras.size(); ++i) bundle.cameras[i].centre.y() += 0.1;
  EXPECT_NEAR(motion_roughness(dropped, bundle), 0.1 / static_cast<double>(bundle.cameras.size() - 1), 1e-9);
}

// A sweep whose features and matches are those of a known bundle.
struct KnownSweep {
  MatchedSweep sweep;
  Reconstruction found;
  std::vector<std::string> names;

  KnownSweep() {
    found.bundle = true_bundle(MotionModel::free);
    const size_t frames = found.bundle.cameras.size();
    found.dropped.resize(frames);
    found.tracks.resize(found.bundle.points.size());
    sweep.features.resize(frames);
    for (size_t i = 0; i < frames; ++i) {
      sweep.features[i].width = sweep.features[i].height = 800;
      names.push_back("photo " + std::to_string(i));
    }
    for (const BundleObservation& o : found.bundle.observations) {
      Features& features = sweep.features[static_cast<size_t>(o.camera)];
      features.positions.emplace_back(o.position_px + Eigen::Vector2d(400, 400));
      found.tracks[static_cast<size_t>(o.point)].push_back({o.camera, features.size() - 1, o.position_px});
    }
    for (int b = 1; b < static_cast<int>(frames); ++b) sweep.pairs.push_back({b - 1, b, matches(b - 1, b)});
  }

  std::vector<Match> matches(int a, int b) const {
    std::vector<Match> result;
    for (const Track& track : found.tracks) {
      for (const Observation& p : track) {
        for (const Observation& q : track) {
          if (p.frame == a && q.frame == b) result.push_back({p.feature, q.feature, 0});
        }
      }
    }
    return result;
  }
  std::string doubted() const { return doubt(sweep, found, names, false).text; }
};

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
  EXPECT_THAT(known.doubted(), HasSubstr("points tie photo 3 and photo 4 together"));
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
  KnownSweep known;
  for (Track& track : known.found.tracks) std::erase_if(track, [](const Observation& o) { return o.frame == 4; });
  EXPECT_TRUE(is_ill_conditioned(known.found));
  known.found.dropped[4] = "it is left out";
  EXPECT_FALSE(is_ill_conditioned(known.found));
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
  known.found.dropped[5] = "it is left out";
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

TEST(IterativeRefinement, BelieveInAThoroughEndThatAHandLeavesItsCircleAsFarAsItSeemed) {
  KnownSweep known = wandering();
  const std::vector<Track> tracks = known.found.tracks;
  IterativeRefinement refinement(known.sweep, {}, Job{}), free = refinement;
  free.set_min_arc_sigma(kWideArcSigma);
  Reconstruction unheld = known.found;
  for (const double tolerance : kKltTolerances_px) free.iterate(tracks, tolerance, kArcSigma, unheld);
  const double scatter = scatter_about_arc(unheld);
  refinement.iterate(tracks, kKltTolerances_px[0], kArcSigma, known.found);
  const double held_back = scatter - scatter_about_arc(known.found);
  refinement.reweight_tracks_at_end();
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

class Photos : public FrameSource {
 public:
  explicit Photos(std::vector<RgbImage> images) : images_(std::move(images)) {}
  int size() const override { return static_cast<int>(images_.size()); }
  std::string name(int i) const override { return std::to_string(1000 + i) + ".png"; }
  RgbImage load(int i) const override { return images_[static_cast<size_t>(i)]; }
  std::optional<double> focal_hint(int) const override { return std::nullopt; }

 private:
  std::vector<RgbImage> images_;
};

struct Rendered {
  std::vector<Camera> cameras;
  std::vector<RgbImage> images;
};

SweepPath short_path(double radius) {
  SweepPath path;
  path.frames = 8;
  path.arc_rad = 70 * kDegree;
  path.radius = radius;
  path.width = 400, path.height = 300;
  path.position_jitter = radius > 0 ? 0.01 : 0;
  return path;
}

const Rendered& rendered(double radius) {
  const auto make = [](double r) {
    const Scene scene(make_scene("courtyard", 1));
    Rendered result{sweep_cameras(short_path(r)), {}};
    for (size_t i = 0; i < result.cameras.size(); ++i) {
      PictureOptions options;
      options.noise = 1;
      options.noise_seed = i;
      result.images.push_back(take_picture(scene, result.cameras[i], options, Job{}).colour);
      result.cameras[i].name = std::to_string(1000 + i) + ".png";
    }
    return result;
  };
  static const Rendered arc = make(0.65), spot = make(0);
  return radius > 0 ? arc : spot;
}

bool same_bytes(const Poses& a, const Poses& b) {
  if (a.cameras.size() != b.cameras.size() || a.points.size() != b.points.size()) return false;
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    if (a.cameras[i].pose.centre != b.cameras[i].pose.centre) return false;
    if (a.cameras[i].pose.world_from_camera != b.cameras[i].pose.world_from_camera) return false;
    if (a.cameras[i].intrinsics.fx != b.cameras[i].intrinsics.fx) return false;
  }
  return true;
}

const Poses& estimated() {
  static const Poses poses = estimate_poses(Photos(rendered(0.65).images), PosesOptions{}, Job{});
  return poses;
}

TEST(EstimatePoses, PosesEveryFrameOfASyntheticSweep) {
  const Poses& poses = estimated();
  ASSERT_EQ(poses.cameras.size(), 8U);
  EXPECT_EQ(poses.report.motion, Motion::arc);
  EXPECT_FALSE(poses.report.closed);
  EXPECT_LT(poses.report.reprojection_px, 1);
  const std::vector<Camera>& truth = rendered(0.65).cameras;
  EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.02);
  for (size_t i = 1; i < 8; ++i) {
    const Eigen::Matrix3d found =
        poses.cameras[i].pose.world_from_camera.transpose() * poses.cameras[0].pose.world_from_camera;
    const Eigen::Matrix3d wanted = truth[i].pose.world_from_camera.transpose() * truth[0].pose.world_from_camera;
    EXPECT_LT(angle_deg(found, wanted), 1);
  }
}

TEST(EstimatePoses, LeavesAStraightLensStraight) {
  EXPECT_EQ(estimated().cameras[0].intrinsics.k1, 0);
  EXPECT_EQ(estimated().cameras[0].intrinsics.k2, 0);
}

TEST(EstimatePoses, WorldIsUprightAndOfArmsLength) {
  double radius = 0;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const Camera& camera : estimated().cameras) {
    up -= camera.pose.world_from_camera.col(1) / 8;
    radius += camera.pose.centre.norm() / 8;
  }
  EXPECT_GT(up.normalized().z(), std::cos(1 * kDegree));
  EXPECT_NEAR(radius, 0.65, 0.15);
}

// Every pixel between the middles of the small one's, as a camera of so many times its pixels sees them.
RgbImage enlarged(const RgbImage& small, int times) {
  RgbImage big(small.width * times, small.height * times);
  for (int y = 0; y < big.height; ++y) {
    for (int x = 0; x < big.width; ++x) {
      const double u = std::clamp((x + 0.5) / times - 0.5, 0.0, small.width - 1.001),
                   v = std::clamp((y + 0.5) / times - 0.5, 0.0, small.height - 1.001);
      const int i = static_cast<int>(u), j = static_cast<int>(v);
      const auto blend = [&](uint8_t Rgb::*channel) {
        const auto at = [&](int p, int q) { return static_cast<double>(small.at(p, q).*channel); };
        const double top = at(i, j) + (u - i) * (at(i + 1, j) - at(i, j));
        const double bottom = at(i, j + 1) + (u - i) * (at(i + 1, j + 1) - at(i, j + 1));
        return static_cast<uint8_t>(std::lround(top + (v - j) * (bottom - top)));
      };
      big.at(x, y) = {blend(&Rgb::r), blend(&Rgb::g), blend(&Rgb::b)};
    }
  }
  return big;
}

TEST(EstimatePoses, OfPhotosShrunkForTheWorkAreInPixelsOfTheWholePhoto) {
  constexpr int kTimes = 3;  // 1200 x 900: more than is worked on
  std::vector<RgbImage> big;
  for (const RgbImage& image : rendered(0.65).images) big.push_back(enlarged(image, kTimes));
  const Poses poses = estimate_poses(Photos(std::move(big)), PosesOptions{}, Job{});
  ASSERT_EQ(poses.cameras.size(), 8U);
  const Intrinsics &k = poses.cameras[0].intrinsics, &small = rendered(0.65).cameras[0].intrinsics;
  EXPECT_EQ(k.width, kTimes * 400);
  EXPECT_EQ(k.height, kTimes * 300);
  EXPECT_EQ(k.cx, kTimes * 200);
  EXPECT_NEAR(k.fx / (kTimes * small.fx), 1, 0.02);
  double squared = 0, count = 0, rightmost = 0;
  for (size_t i = 0; i < poses.points.size(); ++i) {
    for (size_t j = 0; j < poses.sightings[i].size(); ++j) {
      const Pose& pose = poses.cameras[static_cast<size_t>(poses.points[i].cameras[j])].pose;
      const Eigen::Vector3d seen = pose.world_from_camera.transpose() * (poses.points[i].position - pose.centre);
      squared += (project(k, seen) - poses.sightings[i][j]).squaredNorm(), ++count;
      rightmost = std::max(rightmost, poses.sightings[i][j].x());
    }
  }
  EXPECT_LT(std::sqrt(squared / count), kTimes * 0.5);
  EXPECT_GT(rightmost, kTimes * 380);
}

TEST(EstimatePoses, GivesTheSameBytesAtAnyThreadCount) {
  for (const int threads : {1, 2, 4}) {
    Job job;
    job.threads = threads;
    EXPECT_TRUE(same_bytes(estimated(), estimate_poses(Photos(rendered(0.65).images), PosesOptions{}, job))) << threads;
  }
}

TEST(PoseEstimator, GivesTheSameBytesAsAllFramesAtOnceHoweverTheyArrive) {
  const Photos photos(rendered(0.65).images);
  PoseEstimator by_one{PosesOptions{}}, in_heaps{PosesOptions{}};
  for (int count = 1; count <= photos.size(); ++count) by_one.add_frames(photos, count, Job{});
  EXPECT_TRUE(same_bytes(estimated(), by_one.finish(Job{})));
  Job job;
  job.threads = 3;
  for (const int count : {0, 2, 2, 7}) in_heaps.add_frames(photos, count, job);
  EXPECT_EQ(in_heaps.size(), 7);
  EXPECT_TRUE(same_bytes(estimated(), estimate_poses(photos, std::move(in_heaps), job)));
}

TEST(PoseEstimator, BeginsAnewWhenItsFramesAreNotTheFirstOfTheSource) {
  class Renamed : public Photos {
   public:
    using Photos::Photos;
    std::string name(int i) const override { return "other_" + Photos::name(i); }
  };
  const std::vector<RgbImage>& images = rendered(0.65).images;
  PoseEstimator others{PosesOptions{}}, too_many{PosesOptions{}};
  others.add_frames(Renamed({images[4], images[1]}), 2, Job{});
  EXPECT_TRUE(same_bytes(estimated(), estimate_poses(Photos(images), std::move(others), Job{})));
  std::vector<RgbImage> more = images;
  more.push_back(images[0]);
  too_many.add_frames(Photos(more), 9, Job{});
  EXPECT_TRUE(same_bytes(estimated(), estimate_poses(Photos(images), std::move(too_many), Job{})));
}

TEST(EstimatePoses, RecognisesARotationOnTheSpot) {
  const Poses poses = estimate_poses(Photos(rendered(0).images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.report.motion, Motion::rotation);
  EXPECT_EQ(poses.cameras.size(), 8U);
}

// Narrow views, many steps and a lens that bends: a few degrees to the side would pass for a turn in every step, and
// half the focal length with them.
TEST(EstimatePoses, RecognisesARotationAllRoundThroughALensThatBends) {
  const Scene scene(make_scene("courtyard", 1));
  SweepPath path;
  path.frames = 18;
  path.arc_rad = 342 * kDegree;
  path.radius = path.position_jitter = 0;
  path.fov_rad = 36 * kDegree;
  path.width = 300, path.height = 400;
  path.k1 = -0.18;
  const std::vector<Camera> truth = sweep_cameras(path);
  std::vector<RgbImage> images;
  for (const Camera& camera : truth) images.push_back(take_picture(scene, camera, PictureOptions{}, Job{}).colour);
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.report.motion, Motion::rotation);
  EXPECT_EQ(poses.report.doubt, "");
  ASSERT_EQ(poses.cameras.size(), truth.size());
  EXPECT_NEAR(poses.cameras[0].intrinsics.fx / truth[0].intrinsics.fx, 1, 0.01);
}

TEST(EstimatePoses, DropsAPhotoOfNothingAndNamesIt) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images[3] = RgbImage(400, 300, Rgb{90, 90, 90});
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.cameras.size(), 7U);
  EXPECT_FALSE(poses.report.frames[3].posed);
  EXPECT_THAT(poses.report.frames[3].reason, HasSubstr("no texture"));
}

TEST(EstimatePoses, BearsAPhotoOfNothingInTheMiddle) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images[images.size() / 2] = RgbImage(400, 300, Rgb{90, 90, 90});
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.cameras.size(), images.size() - 1);
  EXPECT_EQ(poses.report.motion, Motion::arc);
}

TEST(EstimatePoses, DropsAPhotoOfAnotherSizeAndSaysSo) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images[7] = RgbImage(300, 400, Rgb{});
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_EQ(poses.cameras.size(), 7U);
  EXPECT_THAT(poses.report.frames[7].reason, HasSubstr("300x400"));
}

TEST(EstimatePoses, DropsAPhotoThatRepeatsTheOneBefore) {
  std::vector<RgbImage> images = rendered(0.65).images;
  images.insert(images.begin() + 4, 2, images[3]);
  const Poses poses = estimate_poses(Photos(images), PosesOptions{}, Job{});
  EXPECT_THAT(poses.report.frames[4].reason, HasSubstr("the same picture as 1003.png"));
  EXPECT_THAT(poses.report.frames[5].reason, HasSubstr("the same picture as 1004.png"));
  ASSERT_EQ(poses.cameras.size(), 8U);
  for (size_t i = 0; i < 8; ++i)
    EXPECT_LT((poses.cameras[i].pose.centre - estimated().cameras[i].pose.centre).norm(), 0.01) << i;
}

TEST(EstimatePoses, SaysWhyItIsImpossible) {
  const std::vector<RgbImage> two(rendered(0.65).images.begin(), rendered(0.65).images.begin() + 2);
  const auto words = [](const std::vector<RgbImage>& images) {
    try {
      estimate_poses(Photos(images), PosesOptions{}, Job{});
    } catch (const Impossible& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(words(two), HasSubstr("at least 3 photos"));
  const std::string blank = words(std::vector<RgbImage>(4, RgbImage(200, 150, Rgb{50, 60, 70})));
  EXPECT_THAT(blank, HasSubstr("only 1 of 4 photos connect with each other"));
  EXPECT_THAT(blank, HasSubstr("most show next to no texture"));
  EXPECT_THAT(words(std::vector<RgbImage>(4, two[0])),
              HasSubstr("none the same as the one before; 1001.png: it is the same picture as 1000.png"));
  std::mt19937 random(3);
  std::vector<RgbImage> noise(4, RgbImage(200, 150));
  for (RgbImage& image : noise) {
    for (Rgb& pixel : image.samples) pixel.r = pixel.g = pixel.b = static_cast<uint8_t>(random());
  }
  std::vector<RgbImage> repeated = noise;
  repeated.insert(repeated.begin() + 2, noise[1]);
  EXPECT_THAT(words(repeated), HasSubstr("of 5 photos connect with each other"));
  EXPECT_THAT(words(repeated), HasSubstr("; left out was 1002.png: it is the same picture as 1001.png"));
  EXPECT_THAT(words(noise), HasSubstr("sharp and free of noise"));
}

TEST(EstimatePoses, StopsWhenAsked) {
  std::stop_source stop;
  Job job;
  job.stop = stop.get_token();
  stop.request_stop();
  EXPECT_THROW(estimate_poses(Photos(rendered(0.65).images), PosesOptions{}, job), Cancelled);
}

TEST(Triangulate, FindsPointsAndLeavesGivenCamerasAlone) {
  const Rendered& r = rendered(0.65);
  const Poses poses = triangulate(Photos(r.images), r.cameras, PosesOptions{}, Job{});
  ASSERT_EQ(poses.cameras.size(), 8U);
  EXPECT_GT(poses.points.size(), 100U);
  EXPECT_LT(poses.report.reprojection_px, 0.7);
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(poses.cameras[i].pose.centre, r.cameras[i].pose.centre);
}

TEST(Triangulate, NamesFramesWithoutACamera) {
  const Rendered& r = rendered(0.65);
  const std::vector<Camera> some(r.cameras.begin(), r.cameras.begin() + 5);
  const Poses poses = triangulate(Photos(r.images), some, PosesOptions{}, Job{});
  EXPECT_FALSE(poses.report.frames[6].posed);
  EXPECT_THAT(poses.report.frames[6].reason, HasSubstr("no camera"));
  EXPECT_THROW(triangulate(Photos(r.images), {some[0], some[1]}, PosesOptions{}, Job{}), Impossible);
}

}  // namespace
}  // namespace ldp::sfm
