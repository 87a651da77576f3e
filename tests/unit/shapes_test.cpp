// Where rays meet shapes, against steps along the ray.
#include "sim/scene/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace ldp {
namespace {

using Eigen::Vector3d;

bool inside(Shape shape, const Vector3d& half, const Vector3d& p) {
  switch (shape) {
    case Shape::ellipsoid:
      return p.cwiseQuotient(half).squaredNorm() < 1;
    case Shape::box:
      return std::abs(p.x()) < half.x() && std::abs(p.y()) < half.y() && std::abs(p.z()) < half.z();
    case Shape::cylinder:
      return std::hypot(p.x(), p.y()) < half.x() && std::abs(p.z()) < half.z();
    case Shape::quad:
    case Shape::leaf:
      break;
  }
  return false;
}

// Distance at which steps along the ray first come inside; kNever where they do not.
double stepped(const LocalRay& ray, Shape shape, const Vector3d& half) {
  constexpr double kStep = 0.002;
  for (double t = kStep; t < 12; t += kStep)
    if (inside(shape, half, ray.origin + t * ray.direction)) return t;
  return kNever;
}

class Solids : public testing::TestWithParam<Shape> {};

TEST_P(Solids, AreMetWhereStepsAlongTheRayComeInside) {
  std::mt19937 random(4);
  const auto part = [&] { return static_cast<double>(random() % 2001) / 1000 - 1; };
  int met = 0;
  for (int i = 0; i < 150; ++i) {
    const Vector3d half(0.4 + 0.3 * std::abs(part()), 0.7, 0.5 + 0.4 * std::abs(part()));
    const Vector3d origin = 4 * Vector3d(part(), part(), part()).normalized();
    const LocalRay ray{origin, (Vector3d(part(), part(), part()) * 0.6 - origin).normalized()};
    const Meeting meeting = meet(ray, GetParam(), half, 0);
    const double wanted = stepped(ray, GetParam(), half);
    if (wanted == kNever) {
      EXPECT_FALSE(meeting.t < 12 && stepped(ray, GetParam(), 0.98 * half) < kNever);
      continue;
    }
    ++met;
    EXPECT_NEAR(meeting.t, wanted, 0.0021) << i;
    EXPECT_LT(meeting.normal.dot(ray.direction), 0) << "a normal faces where the ray comes from";
    const Vector3d at = ray.origin + meeting.t * ray.direction;
    EXPECT_FALSE(inside(GetParam(), half, at + 1e-6 * meeting.normal.normalized()));
    EXPECT_TRUE(inside(GetParam(), half, at - 1e-6 * meeting.normal.normalized()));
    EXPECT_EQ(meet(ray, GetParam(), half, meeting.t).t, kNever) << "solids are met where a ray enters them";
  }
  EXPECT_GT(met, 50);
}

INSTANTIATE_TEST_SUITE_P(OfEveryShape, Solids, testing::Values(Shape::ellipsoid, Shape::box, Shape::cylinder));

TEST(Shapes, AlongItsAxisOnlyTheLidsOfACylinderAreMet) {
  const Vector3d half(1, 1, 2);
  const Meeting lid = meet({{0.5, 0, 5}, {0, 0, -1}}, Shape::cylinder, half, 0);
  EXPECT_DOUBLE_EQ(lid.t, 3);
  EXPECT_EQ(lid.normal, Vector3d(0, 0, 1));
  EXPECT_EQ(meet({{1.5, 0, 5}, {0, 0, -1}}, Shape::cylinder, half, 0).t, kNever);
}

TEST(Shapes, FlatOnesAreMetFromBothSidesWithinTheirOutline) {
  const Vector3d half(1, 0.5, 0);
  for (const double side : {1.0, -1.0}) {
    const auto meeting = [&](Shape shape, double x, double y) {
      return meet({{x, y, 2 * side}, {0, 0, -side}}, shape, half, 0);
    };
    EXPECT_DOUBLE_EQ(meeting(Shape::quad, 0.99, 0.49).t, 2);
    EXPECT_EQ(meeting(Shape::quad, 1.01, 0).t, kNever);
    EXPECT_EQ(meeting(Shape::quad, 0, 0.51).t, kNever);
    EXPECT_EQ(meeting(Shape::quad, 0, 0).normal.z(), side);
    EXPECT_DOUBLE_EQ(meeting(Shape::leaf, 0, 0.49).t, 2);
    EXPECT_DOUBLE_EQ(meeting(Shape::leaf, 0.5, 0.32).t, 2);
    EXPECT_EQ(meeting(Shape::leaf, 0.5, 0.34).t, kNever);
    EXPECT_DOUBLE_EQ(meeting(Shape::leaf, -0.5, 0.41).t, 2) << "its base is wider than its tip";
    EXPECT_EQ(meeting(Shape::leaf, 0.99, 0.49).t, kNever) << "a leaf closes at its tips";
    EXPECT_EQ(meeting(Shape::leaf, -0.99, 0.49).t, kNever);
  }
  EXPECT_EQ(meet({{0, 0, 1}, {1, 0, 0}}, Shape::quad, half, 0).t, kNever) << "edge on";
}

TEST(Shapes, TheirBoxesHoldThem) {
  std::mt19937 random(6);
  const auto part = [&] { return static_cast<double>(random() % 2001) / 1000 - 1; };
  for (const Shape shape : {Shape::ellipsoid, Shape::box, Shape::cylinder, Shape::quad, Shape::leaf})
    for (int i = 0; i < 20; ++i) {
      Object object;
      object.shape = shape;
      object.half = {0.5, 0.9, 0.3};
      object.world_from_local =
          Eigen::AngleAxisd(3 * part(), Vector3d(part(), part(), part()).normalized()).toRotationMatrix();
      const Vector3d extent = extent_of(object);
      for (int k = 0; k < 200; ++k) {
        const Vector3d origin = 3 * Vector3d(part(), part(), part()).normalized();
        const LocalRay ray{origin, Vector3d(0.5 * part(), 0.5 * part(), 0.3 * part()) - origin};
        const Meeting meeting = meet(ray, shape, object.half, 0);
        if (meeting.t == kNever) continue;
        const Vector3d at = object.world_from_local * (ray.origin + meeting.t * ray.direction);
        for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(at[axis]), extent[axis] + 1e-9);
      }
    }
}

TEST(Shapes, FacesAreLaidOutInMetres) {
  Object object;
  object.shape = Shape::box;
  EXPECT_EQ(face_position(object, {0.1, 0.2, 0.3}, {1, 0, 0}), Eigen::Vector2d(0.2, 0.3));
  EXPECT_EQ(face_position(object, {0.1, 0.2, 0.3}, {0, -1, 0}), Eigen::Vector2d(0.1, 0.3));
  EXPECT_EQ(face_position(object, {0.1, 0.2, 0.3}, {0, 0, 1}), Eigen::Vector2d(0.1, 0.2));
  object.shape = Shape::cylinder;
  object.half = {2, 2, 1};
  EXPECT_NEAR(face_position(object, {0, 2, 0.5}, {0, 1, 0}).x(), 3.14159265, 1e-6) << "along the mantle";
  object.shape = Shape::leaf;
  EXPECT_EQ(face_position(object, {0.1, 0.2, 0}, {0, 0, 1}), Eigen::Vector2d(0.1, 0.2));
}

}  // namespace
}  // namespace ldp
