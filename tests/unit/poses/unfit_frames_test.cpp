// Which photos can be part of a sweep, and that no more pairs of them are matched than that takes.
#include "core/poses/unfit_frames.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/poses/poses.h"
#include "core/poses/poses_tuning.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

constexpr int kWidth = 800, kHeight = 600;

// Things near and far, passed by in steps of so many pixels in the mean.
class Passing {
 public:
  explicit Passing(double step_px, int things = 200) : step_px_(step_px) {
    std::mt19937 random(5);
    for (int i = 0; i < things; ++i) {
      things_.emplace_back(uniform(random, 0, kWidth), uniform(random, 0, kHeight), uniform(random, 0.6, 1.4));
      for (int k = 0; k < kDescriptorLength; ++k) looks_.push_back(static_cast<int16_t>(random() % 90));
    }
  }

  void add(int count, const std::function<double(int)>& sharpness) {
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<double>(frames_.size());
      Frame frame;
      frame.name = std::to_string(frames_.size());
      frame.features = {kWidth, kHeight, {}, looks_};
      for (const Eigen::Vector3d& thing : things_)
        frame.features.positions.emplace_back(thing.x() - at * step_px_ * thing.z(),
                                              thing.y() + 0.03 * at * step_px_ * thing.z());
      frame.picture.grey = GreyImage(4, 4, 90);
      frame.picture.grey.at(1, 1) = static_cast<uint8_t>(frames_.size());
      frame.sharpness = sharpness(static_cast<int>(frames_.size()));
      frames_.push_back(std::move(frame));
    }
  }
  void add(int count) {
    add(count, [](int) { return 1; });
  }

  std::vector<std::string> left_out() {
    std::vector<std::string> names;
    const std::vector<LeftOut> unfit = this->unfit();
    for (size_t i = 0; i < unfit.size(); ++i) {
      if (!unfit[i]) continue;
      EXPECT_EQ(unfit[i].cause, LeftOutCause::needless) << i;
      names.push_back(frames_[i].name + " for " + unfit[i].original);
    }
    return names;
  }
  std::vector<LeftOut> unfit() { return unfit_frames(frames_, pairs_, Job{}); }
  void match_all() { pairs_.match_all(frames_, unfit(), Job{}); }
  const std::vector<PairMatches>& pairs() const { return pairs_.all(); }

 private:
  double step_px_;
  std::vector<Eigen::Vector3d> things_;
  std::vector<int16_t> looks_;
  std::vector<Frame> frames_;
  FramePairs pairs_{TwoViewOptions{}};
};

TEST(UnfitFrames, OfNotTooManyPhotosEachIsTakenHoweverLittleItMoves) {
  Passing hardly_moving(1);
  hardly_moving.add(static_cast<int>(kManyFrames));
  EXPECT_TRUE(hardly_moving.left_out().empty());
  EXPECT_TRUE(hardly_moving.pairs().empty()) << "no pair had to be matched for that";
}

TEST(UnfitFrames, OfManyTheSharpestOfThoseThatShowTheSameIsTaken) {
  Passing slow(3.3);  // two of them move by more than .005 of the picture, one by less
  slow.add(static_cast<int>(kManyFrames) + 2, [](int i) { return i % 2 == 0 ? 20 : 120; });
  std::vector<std::string> wanted;
  for (size_t i = 0; i < kManyFrames + 2; i += 2) wanted.push_back(std::to_string(i) + " for " + std::to_string(i + 1));
  EXPECT_EQ(slow.left_out(), wanted);
}

TEST(UnfitFrames, AsFewAreLeftOutAsWillDo) {
  Passing very_slow(1.1);  // each second moves by .0025 of the picture, each fourth by .005
  very_slow.add(70);
  EXPECT_EQ(very_slow.left_out().size(), 35U);
}

TEST(UnfitFrames, WhatMovesIsTakenHoweverManyThereAre) {
  Passing moving(44);
  moving.add(static_cast<int>(kManyFrames) + 8);
  EXPECT_TRUE(moving.left_out().empty());
}

TEST(UnfitFrames, OfACameraThatStandsStillMoreThanTwoAreTaken) {
  Passing still(0);
  still.add(static_cast<int>(kManyFrames) + 1);
  EXPECT_TRUE(still.left_out().empty());
}

// Twenty things are enough for neighbours to match, but not for frames far apart, as which they are counted at first.
TEST(UnfitFrames, AreTheSameHoweverTheFramesArrive) {
  Passing at_once(0.35, 20), one_by_one(0.35, 20);
  at_once.add(60);
  for (int i = 0; i < 60; ++i) {
    one_by_one.add(1);
    one_by_one.match_all();
  }
  at_once.match_all();
  EXPECT_EQ(at_once.left_out(), one_by_one.left_out());
  ASSERT_EQ(at_once.pairs().size(), one_by_one.pairs().size());
  const std::vector<LeftOut> unfit = at_once.unfit();
  for (size_t i = 0; i < at_once.pairs().size(); ++i) {
    const PairMatches &pair = at_once.pairs()[i], &other = one_by_one.pairs()[i];
    if (unfit[static_cast<size_t>(pair.a)] || unfit[static_cast<size_t>(pair.b)]) continue;
    EXPECT_EQ(pair.matches, other.matches) << pair.a << " and " << pair.b;
  }
}

TEST(LeaveOut, TakesCamerasOutAndPointsThatTooFewOfTheOthersSee) {
  Poses poses;
  poses.report.frames.resize(6);
  for (const int frame : {0, 2, 3, 5}) {
    poses.frame_of_camera.push_back(frame);
    poses.cameras.emplace_back().name = std::to_string(frame);
    poses.report.frames[static_cast<size_t>(frame)].posed = true;
  }
  const std::vector<std::vector<int>> seen_by = {{0, 1, 2}, {1, 2}, {0, 3}, {0, 1, 2, 3}};
  for (const std::vector<int>& cameras : seen_by) {
    poses.points.push_back({{1.0 * static_cast<double>(poses.points.size()), 0, 0}, cameras});
    poses.sightings.emplace_back();
    for (const int camera : cameras) poses.sightings.back().emplace_back(camera, 0);
  }
  std::vector<LeftOut> why(4);
  why[1].cause = LeftOutCause::up_or_down;
  leave_out(why, poses);
  EXPECT_EQ(poses.frame_of_camera, (std::vector{0, 3, 5}));
  ASSERT_EQ(poses.cameras.size(), 3U);
  EXPECT_EQ(poses.cameras[1].name, "3");
  for (const size_t frame : {0U, 3U, 5U}) EXPECT_TRUE(poses.report.frames[frame].posed) << frame;
  EXPECT_FALSE(poses.report.frames[2].posed);
  EXPECT_EQ(poses.report.frames[2].left_out.cause, LeftOutCause::up_or_down);
  ASSERT_EQ(poses.points.size(), 3U);
  EXPECT_EQ(poses.report.points, 3);
  const std::vector<std::vector<int>> left = {{0, 1}, {0, 2}, {0, 1, 2}}, were = {{0, 2}, {0, 3}, {0, 2, 3}};
  const double where[] = {0, 2, 3};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(poses.points[i].cameras, left[i]);
    EXPECT_EQ(poses.points[i].position.x(), where[i]);
    ASSERT_EQ(poses.sightings[i].size(), were[i].size());
    for (size_t k = 0; k < were[i].size(); ++k) EXPECT_EQ(poses.sightings[i][k].x(), were[i][k]);
  }
}

}  // namespace
}  // namespace ldp::sfm
