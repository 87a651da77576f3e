#include "core/poses/features/descriptor_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/poses/features/descriptor_distance.h"
#include "core/poses/tracks/guided_matching.h"
#include "core/poses/tracks/tracks.h"
#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

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
  const std::vector<PairMatches> pairs = match_guided(sweep, bundle, {{}, {}}, Job{});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].matches.size(), 80U);
  for (const Match& m : pairs[0].matches) EXPECT_EQ(m.a, m.b);
  EXPECT_TRUE(match_guided(sweep, bundle, {{}, {LeftOutCause::unmatched}}, Job{}).empty());
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

// A hundred things seen in three photos stand in one cell of them, and one of two photos in every cell.
TEST(LongestTracks, ComeEvenlyFromAllCellsWhereAsked) {
  Features photo;
  photo.width = 600, photo.height = 300;
  const auto track_at = [](int frames, double x, double y) {
    Track track;
    for (int frame = 0; frame < frames; ++frame) track.push_back({frame, 0, {x, y}});
    return track;
  };
  std::vector<Track> tracks;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) tracks.push_back(track_at(2, -250 + 100 * column, -125 + 50 * row));
  }
  for (int i = 0; i < 100; ++i) tracks.push_back(track_at(3, 210 + 0.8 * i, 101 + 0.4 * i));
  const auto of_three_photos = [](const Track& track) { return track.size() == 3; };
  const std::vector<Features> photos(3, photo);
  const std::vector<Track> longest = longest_tracks(tracks, photos, 72, 1);
  EXPECT_EQ(longest.size(), 72U);
  EXPECT_TRUE(std::all_of(longest.begin(), longest.end(), of_three_photos));
  const std::vector<Track> spread = longest_tracks(tracks, photos, 72, 6);
  EXPECT_EQ(std::count_if(spread.begin(), spread.end(), of_three_photos), 2);
  EXPECT_EQ(spread.size(), 2U + 35U);
}

}  // namespace
}  // namespace ldp::sfm
