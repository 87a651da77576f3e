#include "core/poses/tracks/klt_tracking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ldp::sfm {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
}

// What is noisy: the picture of the anchor of all tracks, or every picture. What is displaced: all, or only islands of
// 13 x 13 pixels about the points, while what is around them stays.
enum class Noisy { anchor, all };
enum class Displaced { all, islands };

// Five cameras in one place see a smooth pattern, each of them displaced by a fraction of a pixel.
struct ShiftedPictures {
  static constexpr int kFrames = 5, kAnchor = 2, kSize = 200;
  std::vector<GreyPhoto> pictures;
  std::vector<Track> tracks;
  Bundle bundle;

  explicit ShiftedPictures(double noise, Noisy noisy = Noisy::anchor, Displaced displaced = Displaced::all) {
    std::mt19937 random(5);
    const auto on_island = [](const Eigen::Vector2d& p) {  // relative to where the points are
      const auto off = [](double x, double first) { return std::abs(std::remainder(x - first, 15)) > 6.5; };
      return !off(p.x(), 100 - 67.3) && !off(p.y(), 100 - 66.8);
    };
    for (int i = 0; i < kFrames; ++i) {
      GreyImage grey(kSize, kSize);
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
          Eigen::Vector2d p = Eigen::Vector2d(x + 0.5, y + 0.5) - shift(i);
          if (displaced == Displaced::islands && !on_island(p)) p += shift(i);
          const double value = 128 + 16 * std::sin(0.5 * p.x() + 0.3 * p.y()) +
                               12 * std::sin(0.4 * p.y() - 0.35 * p.x()) + 8 * std::sin(0.23 * p.x() + 0.6 * p.y()) +
                               (i == kAnchor || noisy == Noisy::all ? uniform(random, -noise, noise) : 0);
          grey.at(x, y) = static_cast<uint8_t>(std::lround(value));
        }
      }
      pictures.push_back({grey, Eigen::Vector2d::Ones(), kSize, kSize});
    }
    bundle.lens.focal_px = 300;
    bundle.cameras.resize(kFrames);
    for (int i = 0; i < 100; ++i) {
      const Eigen::Vector2d place(15.0 * (i % 10) - 67.3, 15.0 * (i / 10) - 66.8);
      Track track;
      for (int c = 0; c < kFrames; ++c) track.push_back({c, -1, place + shift(c)});
      bundle.points.push_back({(place / bundle.lens.focal_px).homogeneous().normalized(), 0});
      tracks.push_back(track);
    }
  }

  static Eigen::Vector2d shift(int frame) { return frame * Eigen::Vector2d(0.37, -0.23); }

  std::vector<Track> tracked() const { return track_points(pictures, tracks, bundle, KltOptions{}, Job{}); }
};

TEST(TrackPoints, FindsAllFramesToAFractionOfAPixel) {
  const std::vector<Track> tracks = ShiftedPictures(0).tracked();
  int found = 0;
  for (const Track& track : tracks) {
    for (size_t i = 1; i < track.size(); ++i) {
      const Eigen::Vector2d wanted = ShiftedPictures::shift(track[i].frame) - ShiftedPictures::shift(track[0].frame);
      EXPECT_LT((track[i].position_px - track[0].position_px - wanted).norm(), 0.06);
    }
    found += track.size() == ShiftedPictures::kFrames ? 1 : 0;
  }
  EXPECT_GT(found, 60);
}

// Root mean square of how far a point is from where it should be, against the anchor.
double error_of(const std::vector<Track>& tracks) {
  double sum = 0;
  int count = 0;
  for (const Track& track : tracks) {
    for (size_t i = 1; i < track.size(); ++i) {
      const Eigen::Vector2d wanted = ShiftedPictures::shift(track[i].frame) - ShiftedPictures::shift(track[0].frame);
      sum += (track[i].position_px - track[0].position_px - wanted).squaredNorm();
      ++count;
    }
  }
  EXPECT_GT(count, 200);
  return std::sqrt(sum / count);
}

TEST(TrackPoints, MoreOfAPlaneEvensOutItsNoise) {
  EXPECT_LT(error_of(ShiftedPictures(20, Noisy::all).tracked()), 0.34);
}

TEST(TrackPoints, OnlyWhatMovesAlikeIsFollowed) {
  EXPECT_LT(error_of(ShiftedPictures(0, Noisy::all, Displaced::islands).tracked()), 0.05);
}

TEST(TrackPoints, AnAnchorIsNoSurerThanWhatIsFound) {
  int followed = 0;
  for (const Track& track : ShiftedPictures(12).tracked()) {
    if (track.size() != ShiftedPictures::kFrames) continue;
    ++followed;
    for (const Observation& o : track) EXPECT_GE(o.weight, track[ShiftedPictures::kAnchor].weight);
  }
  EXPECT_GT(followed, 60);
}

}  // namespace
}  // namespace ldp::sfm
