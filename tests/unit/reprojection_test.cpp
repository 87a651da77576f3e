#include "core/poses/adjust/reprojection_error.h"

#include <gtest/gtest.h>

namespace ldp::sfm {
namespace {

using Matrix26 = Eigen::Matrix<double, 2, 6>;

// What Ceres sees of residuals that come scaled costs what Cauchy's loss does and has its gradient.
TEST(CorrectedCauchyLoss, CostAndGradientAreThoseOfTheLoss) {
  const double scale = 0.8, weight = 0.3;
  const Matrix26 derivatives = Matrix26::NullaryExpr([](auto i, auto j) { return std::sin(3.0 * double(i + 2 * j)); });
  for (const double share : {1.0, 0.65, 0.3}) {
    const CorrectedCauchyLoss loss(scale, weight, share);
    for (const double length : {0.0, 0.01, 0.1, 0.3, 0.5, 0.7, 0.8, 1.0, 2.0, 40.0}) {
      const Eigen::Vector2d residual = length * Eigen::Vector2d(0.6, -0.8);
      Eigen::Vector2d scaled = residual;
      const Matrix26 by = loss.apply(scaled) * derivatives;
      double rho[3];
      loss.Evaluate(scaled.squaredNorm(), rho);
      double of_ceres[3];
      ceres::CauchyLoss(scale).Evaluate(residual.squaredNorm(), of_ceres);
      EXPECT_NEAR(rho[0], weight * of_ceres[0], 1e-9) << share << " " << length;
      EXPECT_EQ(rho[1], 1);
      EXPECT_EQ(rho[2], 0);
      const Eigen::Matrix<double, 6, 1> gradient = weight * of_ceres[1] * derivatives.transpose() * residual;
      EXPECT_LT((by.transpose() * scaled - gradient).norm(), 1e-9) << share << " " << length;
      // Along the residual steps are as much longer as the share says, across it not at all.
      const Eigen::Matrix2d normal = by * derivatives.transpose() * (derivatives * derivatives.transpose()).inverse();
      const Eigen::Vector2d along(0.6, -0.8), across(0.8, 0.6);
      const double slope = std::sqrt(weight * of_ceres[1]);
      EXPECT_NEAR(across.dot(normal * across), slope, 1e-9);
      if (length >= scale) {
        EXPECT_NEAR(along.dot(normal * along), slope * std::sqrt(share), 1e-9);
      }
    }
  }
}

double numeric(const ceres::CostFunction& cost, std::vector<std::vector<double>> blocks, size_t block, size_t i,
               const std::function<void(const std::vector<double>&)>& turn, int residual) {
  double r[2][2];
  constexpr double kStep = 1e-6;
  for (const int side : {0, 1}) {
    std::vector<std::vector<double>> moved = blocks;
    moved[block][i] += side == 0 ? -kStep : kStep;
    turn(moved[0]);
    const double* p[] = {moved[0].data(), moved[1].data(), moved[2].data()};
    cost.Evaluate(p, r[side], nullptr);
  }
  turn(blocks[0]);
  return (r[1][residual] - r[0][residual]) / (2 * kStep);
}

// Where the loss does nothing: derivatives by turn, centre, lens and point.
template <MotionModel kModel>
void expect_true_derivatives() {
  constexpr size_t kBlock = kModel == MotionModel::free ? 6 : 3, kPoint = kModel == MotionModel::rotation ? 2 : 3;
  CameraRotation camera(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix());
  const DirectionFrame frame{camera.at_start.transpose() * Eigen::Vector3d(0.2, -0.1, 1).normalized(),
                             Eigen::Vector3d(0.1, 0.9, 0.3), Eigen::Vector3d(0.8, -0.2, 0.4)};
  const CorrectedCauchyLoss loss(1e9, 1, 1);
  const Reprojection<kModel> cost({0, 0, {11, -7}, 1.7}, camera, frame, loss);
  std::vector<double> pose{0.05, -0.1, 0.2, 0.3, -0.2, 0.5}, lens{std::log(600), -0.1, 0.03, 0, 0, 0},
      point{0.03, -0.02, 0.4};
  pose.resize(kBlock), lens.resize(kBlock), point.resize(kPoint);
  const auto turn = [&](const std::vector<double>& block) { camera.update({block[0], block[1], block[2]}); };
  turn(pose);
  double by_pose[12], by_lens[12], by_point[6], r[2];
  double* by[] = {by_pose, by_lens, by_point};
  const double* blocks[] = {pose.data(), lens.data(), point.data()};
  ASSERT_TRUE(cost.Evaluate(blocks, r, by));
  for (size_t block = 0; block < 3; ++block) {
    const size_t size = block == 2 ? kPoint : kBlock;
    for (size_t i = 0; i < size; ++i) {
      for (const int residual : {0, 1}) {
        EXPECT_NEAR(by[block][static_cast<size_t>(residual) * size + i],
                    numeric(cost, {pose, lens, point}, block, i, turn, residual), 2e-3)
            << block << " " << i;
      }
    }
  }
}

TEST(Reprojection, DerivativesAreTrue) {
  expect_true_derivatives<MotionModel::free>();
  expect_true_derivatives<MotionModel::spherical>();
  expect_true_derivatives<MotionModel::rotation>();
}

}  // namespace
}  // namespace ldp::sfm
