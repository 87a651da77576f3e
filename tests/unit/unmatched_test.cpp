#include "unmatched.h"

#include <gtest/gtest.h>

namespace ldp {
namespace {

// Two cameras side by side; each has found features in a row, 20 pixels apart, and one point is known that both see, at
// inverse distance 0.5, where the first has its seventh feature.
struct OneKnown {
  MatchedSweep sweep;
  Bundle bundle;
  std::vector<Track> tracks;

  OneKnown() {
    for (int i = 0; i < 2; ++i) {
      Features features{800, 600, {}, {}};
      for (int k = 0; k < 15; ++k) features.positions.emplace_back(200.0 + 20 * k, 310);
      sweep.features.push_back(features);
    }
    bundle.lens.focal_px = 700;
    bundle.cameras.resize(2);
    bundle.cameras[1].centre = {0.3, 0, 0};
    Track track{{0, 6, sweep.features[0].from_middle(6)}};
    const Eigen::Vector3d ray = ray_of(track[0].position_px, bundle.lens).homogeneous().normalized();
    bundle.points.push_back({ray, 0.5});
    track.push_back({1, -1, project_point(bundle.cameras[1], bundle.lens, bundle.points[0]).position_px});
    tracks.push_back(track);
  }
};

TEST(Unmatched, FeaturesAreBelievedAsFarAsWhatIsKnownBesideThem) {
  const OneKnown known;
  const Guesses guesses = unmatched(known.sweep, known.tracks, known.bundle, 100);
  ASSERT_EQ(guesses.tracks.size(), guesses.points.size());
  int in_second = 0;
  for (size_t i = 0; i < guesses.tracks.size(); ++i) {
    ASSERT_EQ(guesses.tracks[i].size(), 1U);
    const Observation& o = guesses.tracks[i][0];
    const Pose& camera = known.bundle.cameras[static_cast<size_t>(o.frame)];
    const Projection there = project_point(camera, known.bundle.lens, guesses.points[i]);
    ASSERT_TRUE(there.in_front);
    EXPECT_LT((there.position_px - o.position_px).norm(), 1e-6);
    const auto from_camera = [&](const InversePoint& p) {
      return p.inverse_distance / p.seen_from(camera.centre).norm();
    };
    EXPECT_NEAR(from_camera(guesses.points[i]), from_camera(known.bundle.points[0]), 1e-9);
    in_second += o.frame;
  }
  EXPECT_GT(in_second, 3);
}

TEST(Unmatched, NothingIsGuessedWhereItIsKnownNorFarFromAll) {
  const OneKnown known;
  for (const Track& guess : unmatched(known.sweep, known.tracks, known.bundle, 100).tracks) {
    for (const Observation& o : known.tracks[0]) {
      if (o.frame != guess[0].frame) continue;
      const double apart = (o.position_px - guess[0].position_px).norm();
      EXPECT_GT(apart, 5);
      EXPECT_LT(apart, 90);
    }
  }
}

TEST(Unmatched, NoMoreIsGuessedThanIsWanted) {
  const OneKnown known;
  EXPECT_EQ(unmatched(known.sweep, known.tracks, known.bundle, 1).tracks.size(), 0U);
  EXPECT_EQ(unmatched(known.sweep, known.tracks, known.bundle, 2).tracks.size(), 4U) << "two for each, in two frames";
}

TEST(EmptyRepeated, OfTwoTracksOfOneThingTheEarlierStays) {
  const OneKnown known;
  std::vector<Track> tracks{known.tracks[0], {{0, -1, {0, 0}}, {1, -1, {0, 50}}}, {{0, -1, {80, 0}}}};
  tracks.push_back({{0, -1, {150, 0}}, {1, -1, known.tracks[0][1].position_px + Eigen::Vector2d(1, -1)}});
  tracks.push_back({{0, -1, {1, 1}}, {1, -1, {-40, 50}}});
  empty_repeated(known.sweep, 1, tracks);
  EXPECT_EQ(tracks[0].size(), 2U);
  EXPECT_EQ(tracks[1].size(), 2U);
  EXPECT_TRUE(tracks[2].empty()) << "seen once";
  EXPECT_TRUE(tracks[3].empty());
  EXPECT_TRUE(tracks[4].empty());
}

TEST(EmptyRepeated, WhatIsNotOfTheLastOnesStays) {
  const OneKnown known;
  std::vector<Track> tracks{known.tracks[0], known.tracks[0]};
  empty_repeated(known.sweep, 2, tracks);
  EXPECT_EQ(tracks[1].size(), 2U);
}

}  // namespace
}  // namespace ldp
