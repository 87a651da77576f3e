#include "core/poses/start/rotation_averaging.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/poses/start/initialisation.h"
#include "core/poses/start/motion_model.h"
#include "core/poses/start/spherical_motion.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

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

Eigen::Matrix3d step_between(const Bundle& bundle, size_t a, size_t b) {
  return bundle.cameras[b].world_from_camera.transpose() * bundle.cameras[a].world_from_camera;
}

// Things that keep pace with the camera stand in one place of all photos, and so are tracked the longest.
TEST(InitialiseSpherical, IsNotLedByWhatKeepsPaceWithTheCamera) {
  const Bundle truth = true_bundle(MotionModel::spherical);
  KnownSweep known(truth);
  std::vector<Track> tracks = known.found.tracks;
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d place(uniform(random, -350, 350), uniform(random, -350, 350));
    Track& pacing = tracks.emplace_back();
    for (int frame = 0; frame < 8; ++frame) pacing.push_back({frame, 0, place});
  }
  RotationHypothesis near_truth;
  near_truth.focal_px = 720;
  for (const Pose& pose : truth.cameras) near_truth.world_from_camera.push_back(pose.world_from_camera);
  const Bundle found = initialise_spherical(known.sweep, tracks, {near_truth}, FocalPrior{720, 0.1}, Job{});
  for (size_t i = 1; i < truth.cameras.size(); ++i) {
    EXPECT_LT(angle_deg(step_between(found, i - 1, i), step_between(truth, i - 1, i)), 0.5);
  }
}

// Steps that all turn a little too little leave a gap where a full turn meets its beginning: what both ends see is no
// point there. Here nothing else holds both halves of the turn together.
TEST(InitialiseSpherical, IsClosedByWhatBothEndsOfAFullTurnSee) {
  const Bundle truth = full_turn_bundle(500);
  KnownSweep known(truth);
  std::erase_if(known.sweep.pairs, [](const PairMatches& pair) { return pair.a == 7; });
  std::vector<Track> tracks;
  for (size_t i = 0; i < known.found.tracks.size(); ++i) {
    const Track& track = known.found.tracks[i];
    std::vector<int> frames;
    for (const Observation& o : track) frames.push_back(o.frame);
    const auto first_half = std::count_if(frames.begin(), frames.end(), [](int frame) { return frame < 8; });
    const bool of_one_half = first_half == 0 || first_half == std::ssize(frames);
    if (of_one_half ? i % 4 == 0 : frames == std::vector{0, 1, 14, 15}) tracks.push_back(track);
  }
  RotationHypothesis drifted;
  drifted.focal_px = 500;
  for (int i = 0; i < 16; ++i) drifted.world_from_camera.push_back(turn(0, 21.5 * i, 0));
  const Bundle found = initialise_spherical(known.sweep, tracks, {drifted}, FocalPrior{500, 0.1}, Job{});
  EXPECT_LT(angle_deg(step_between(found, 15, 0), step_between(truth, 15, 0)), 0.5);
}

TEST(StepPrior, IsOfEachFrameAndTheNext) {
  const Bundle truth = true_bundle(MotionModel::spherical);
  const std::vector<StepPrior> priors = step_priors(KnownSweep(truth).sweep, truth.lens.focal_px);
  ASSERT_EQ(priors.size(), 7U);
  for (const StepPrior& prior : priors) {
    EXPECT_EQ(prior.b, prior.a + 1);
    const Eigen::Matrix3d wanted = truth.cameras[static_cast<size_t>(prior.b)].world_from_camera.transpose() *
                                   truth.cameras[static_cast<size_t>(prior.a)].world_from_camera;
    EXPECT_LT(angle_deg(prior.b_from_a, wanted), 1);
    EXPECT_NEAR(prior.sigma_rad / kDegree, 1.6, 0.2);
  }
}

TEST(MotionRoughness, IsThatOfTheStepsAndNotOfHowTheCameraIsHeld) {
  Bundle bundle = true_bundle(MotionModel::spherical);
  const std::vector<LeftOut> left_out(bundle.cameras.size());
  EXPECT_NEAR(motion_roughness(left_out, bundle), 0, 1e-12);
  Bundle shifted = bundle;
  for (Pose& pose : shifted.cameras) pose.centre += Eigen::Vector3d(0.3, 0.2, 0.1);
  EXPECT_NEAR(motion_roughness(left_out, shifted), 0, 1e-12);
  for (size_t i = 4; i < bundle.cameras.size(); ++i) bundle.cameras[i].centre.y() += 0.1;
  EXPECT_NEAR(motion_roughness(left_out, bundle), 0.1 / static_cast<double>(bundle.cameras.size() - 1), 1e-9);
}

}  // namespace
}  // namespace ldp::sfm
