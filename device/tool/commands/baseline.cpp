#include "device/tool/commands/baseline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ldp {
namespace {

constexpr int kPlanes = 32;
constexpr int kStride = 4;  // of the pixels by which planes are compared

using Eigen::Vector2d;
using Eigen::Vector3d;

// Colour of the photo at a continuous position; false outside of it.
bool sample(const RgbImage& photo, const Vector2d& at, Rgb& colour) {
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  if (!(x >= -0.5 && y >= -0.5 && x <= photo.width - 0.5 && y <= photo.height - 0.5)) return false;
  const double cx = std::clamp(x, 0.0, photo.width - 1.0), cy = std::clamp(y, 0.0, photo.height - 1.0);
  const int x0 = std::min(static_cast<int>(cx), std::max(0, photo.width - 2)),
            y0 = std::min(static_cast<int>(cy), std::max(0, photo.height - 2));
  const int x1 = std::min(x0 + 1, photo.width - 1), y1 = std::min(y0 + 1, photo.height - 1);
  const double u = cx - x0, v = cy - y0;
  const auto mix = [&](auto channel) {
    const double top = (1 - u) * channel(photo.at(x0, y0)) + u * channel(photo.at(x1, y0));
    const double bottom = (1 - u) * channel(photo.at(x0, y1)) + u * channel(photo.at(x1, y1));
    return static_cast<uint8_t>(std::lround((1 - v) * top + v * bottom));
  };
  colour = {mix([](const Rgb& p) { return 1.0 * p.r; }), mix([](const Rgb& p) { return 1.0 * p.g; }),
            mix([](const Rgb& p) { return 1.0 * p.b; })};
  return true;
}

class Warp {
 public:
  Warp(const RgbImage& photo, const Camera& camera, const Camera& target) : photo_(photo), camera_(camera) {
    rotation_ = camera.pose.world_from_camera.transpose() * target.pose.world_from_camera;
    shift_ = camera.pose.world_from_camera.transpose() * (target.pose.centre - camera.pose.centre);
    const Intrinsics& in = target.intrinsics;
    rays_ = Plane<Vector3d>(in.width, in.height, Vector3d::Zero());
    for (int y = 0; y < in.height; ++y) {
      for (int x = 0; x < in.width; ++x) rays_.at(x, y) = rotation_ * unproject(in, {x + 0.5, y + 0.5});
    }
  }
  bool colour(int x, int y, double inverse_depth, Rgb& result) const {
    const Vector3d point = rays_.at(x, y) + inverse_depth * shift_;
    return point.z() > 1e-6 && sample(photo_, project(camera_.intrinsics, point), result);
  }
  double squared_error(const RgbImage& truth, double inverse_depth) const {
    double sum = 0;
    for (int y = kStride / 2; y < truth.height; y += kStride) {
      for (int x = kStride / 2; x < truth.width; x += kStride) {
        Rgb p{127, 127, 127};
        colour(x, y, inverse_depth, p);
        const Rgb& t = truth.at(x, y);
        for (const int difference : {p.r - t.r, p.g - t.g, p.b - t.b}) sum += difference * difference;
      }
    }
    return sum;
  }

 private:
  const RgbImage& photo_;
  const Camera& camera_;
  Eigen::Matrix3d rotation_;
  Vector3d shift_;
  Plane<Vector3d> rays_;
};

}  // namespace

int nearest_camera(const std::vector<Camera>& cameras, const Camera& target, double nearest_depth) {
  int best = -1;
  double best_distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < cameras.size(); ++i) {
    const double cosine = cameras[i].pose.world_from_camera.col(2).dot(target.pose.world_from_camera.col(2));
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    const double distance = (cameras[i].pose.centre - target.pose.centre).norm() / nearest_depth + angle;
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = static_cast<int>(i);
  }
  return best;
}

BaselineView baseline_view(const RgbImage& photo, const Camera& camera, const Camera& target, const RgbImage& truth,
                           double nearest_depth) {
  const Warp warp(photo, camera, target);
  double best_error = std::numeric_limits<double>::infinity(), best = 0;
  for (int i = 0; i < kPlanes; ++i) {
    const double inverse_depth = i / (nearest_depth * (kPlanes - 1)), error = warp.squared_error(truth, inverse_depth);
    if (error >= best_error) continue;
    best_error = error;
    best = inverse_depth;
  }
  BaselineView view{RgbImage(truth.width, truth.height), Plane<uint8_t>(truth.width, truth.height), 1 / best};
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) view.alpha.at(x, y) = warp.colour(x, y, best, view.colour.at(x, y)) ? 255 : 0;
  }
  return view;
}

}  // namespace ldp
