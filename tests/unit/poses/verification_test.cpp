// Matches of two frames that agree with one epipolar geometry, and those that do not.
#include "core/poses/tracks/geometric_verification.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/poses/known_sweep.h"

namespace ldp::sfm {
namespace {

constexpr int kWidth = 800, kHeight = 600;

// What two cameras, one a step aside of the other, see of random points; `wrong` of them are elsewhere in the second.
struct TwoViews {
  TwoViews(int points, int wrong, unsigned seed) : random(seed) {
    for (int i = 0; i < points; ++i) {
      const Eigen::Vector3d p(uniform(random, -2, 2), uniform(random, -1.5, 1.5), uniform(random, 3, 9));
      const Eigen::Vector3d q = turn(0, 4, 1).transpose() * (p - Eigen::Vector3d(0.5, 0.05, 0));
      const Eigen::Vector2d in_b =
          i < wrong ? Eigen::Vector2d(uniform(random, 0, kWidth), uniform(random, 0, kHeight)) : on_picture(q);
      std::vector<int16_t> looks(kDescriptorLength);
      for (int16_t& value : looks) value = static_cast<int16_t>(random() % 90);
      add(a, on_picture(p), looks);
      add(b, in_b, looks);
    }
  }
  static Eigen::Vector2d on_picture(const Eigen::Vector3d& p) {
    return {kWidth / 2.0 + 600 * p.x() / p.z(), kHeight / 2.0 + 600 * p.y() / p.z()};
  }
  static void add(Features& features, const Eigen::Vector2d& at, const std::vector<int16_t>& looks) {
    features.positions.push_back(at);
    features.descriptors.insert(features.descriptors.end(), looks.begin(), looks.end());
  }
  std::vector<Match> verified(bool neighbours, const TwoViewOptions& options = {}) const {
    return match_and_verify(a, b, neighbours, options);
  }

  std::mt19937 random;
  Features a{kWidth, kHeight, {}, {}}, b{kWidth, kHeight, {}, {}};
};

TEST(GeometricVerification, KeepsWhatAgreesAndDropsWhatDoesNot) {
  const TwoViews views(200, 60, 1);
  const std::vector<Match> kept = views.verified(true);
  EXPECT_GE(kept.size(), 138U);
  int wrong = 0;
  for (const Match& match : kept) {
    EXPECT_EQ(match.a, match.b);
    wrong += match.a < 60 ? 1 : 0;
  }
  EXPECT_LE(wrong, 4) << "a few lie on their epipolar lines by chance";
}

TEST(GeometricVerification, FewAgreeingMatchesAreChance) {
  EXPECT_TRUE(TwoViews(12, 0, 2).verified(true).empty());
  EXPECT_EQ(TwoViews(20, 0, 3).verified(true).size(), 20U);
  EXPECT_TRUE(TwoViews(20, 0, 3).verified(false).empty()) << "of frames far apart more are asked for";
  EXPECT_EQ(TwoViews(60, 0, 4).verified(false).size(), 60U);
}

TEST(GeometricVerification, WhereMostDisagreeNothingIsKept) {
  EXPECT_TRUE(TwoViews(200, 160, 5).verified(true).empty());
  TwoViewOptions lenient;
  lenient.min_inlier_ratio = 0.1;
  EXPECT_FALSE(TwoViews(200, 160, 5).verified(true, lenient).empty());
}

TEST(GeometricVerification, GivesTheSameForTheSameSeed) {
  const TwoViews views(150, 50, 6);
  const std::vector<Match> once = views.verified(true), again = views.verified(true);
  ASSERT_EQ(once.size(), again.size());
  for (size_t i = 0; i < once.size(); ++i) EXPECT_EQ(once[i].a, again[i].a);
}

}  // namespace
}  // namespace ldp::sfm
