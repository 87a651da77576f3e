#include "tests/bench/depth_truth.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

namespace ldp {
namespace {

float from_half(uint16_t half) {
  const uint32_t sign = static_cast<uint32_t>(half >> 15) << 31, exponent = (half >> 10) & 31u, mantissa = half & 1023u;
  if (exponent == 31) return std::bit_cast<float>(sign | 0x7F800000u | mantissa << 13);
  if (exponent == 0) return std::ldexp(static_cast<float>(mantissa), -24);
  return std::bit_cast<float>(sign | (exponent + 112) << 23 | mantissa << 13);
}

struct Sight {  // a camera and how a column's ray of unit v meets it
  size_t camera = 0;
  double facing = 0;
};

// Inverse z-depth of the surface the camera sees at the point less that of the point itself; NaN outside the image.
double surface_behind(const Camera& camera, const Plane<float>& depth, const Eigen::Vector3d& point_times_w, double w) {
  const Eigen::Vector3d q = camera.pose.world_from_camera.transpose() * (point_times_w - w * camera.pose.centre);
  if (q.z() < 1e-6) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector2d at = project(camera.intrinsics, q);
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  if (!depth.contains(x, y)) return std::numeric_limits<double>::quiet_NaN();
  return 1 / static_cast<double>(depth.at(x, y)) - w / q.z();
}

}  // namespace

Plane<float> read_npy(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  char head[10];
  if (!in.read(head, 10) || std::memcmp(head, "\x93NUMPY", 6) != 0)
    throw std::runtime_error("'" + file.string() + "' is no .npy file");
  std::string header(static_cast<uint8_t>(head[8]) + 256u * static_cast<uint8_t>(head[9]), ' ');
  in.read(header.data(), static_cast<std::streamsize>(header.size()));
  const bool half = header.find("<f2") != std::string::npos;
  int height = 0, width = 0;
  if (std::sscanf(header.c_str() + header.find("'shape'"), "'shape': (%d, %d)", &height, &width) != 2)
    throw std::runtime_error("shape");
  Plane<float> plane(width, height);
  for (float& value : plane.samples) {
    uint16_t bits = 0;
    if (half && in.read(reinterpret_cast<char*>(&bits), 2)) value = from_half(bits);
    if (!half) in.read(reinterpret_cast<char*>(&value), 4);
  }
  if (!in) throw std::runtime_error("'" + file.string() + "' ends early");
  return plane;
}

DisparityMap true_disparity(const PanoramaGrid& grid, const std::vector<Camera>& cameras,
                            const std::vector<Plane<float>>& depths, const Job& job) {
  constexpr int kStep = 8;            // disparity steps between two looks
  constexpr double kTolerance = 0.4;  // labels of 16 by which surface and ray may miss at the crossing
  constexpr size_t kCameras = 5;
  DisparityMap truth(grid.width, grid.height, kNoDisparity);
  const double tolerance = kTolerance * (grid.w_near - grid.w_far) / 15;
  parallel_for(job, grid.width, [&](int x) {
    const double theta = grid.theta(x + 0.5);
    std::vector<Sight> sights;
    for (size_t i = 0; i < cameras.size(); ++i)
      sights.push_back({i, cameras[i].pose.world_from_camera.col(2).dot(grid.arc.outward(theta))});
    std::sort(sights.begin(), sights.end(), [](const Sight& a, const Sight& b) { return a.facing > b.facing; });
    sights.resize(std::min(sights.size(), kCameras));
    for (int y = 0; y < grid.height; ++y) {
      const Eigen::Vector3d origin = grid.origin(theta), direction = grid.direction(theta, grid.v(y + 0.5));
      std::vector<double> before(sights.size(), std::numeric_limits<double>::quiet_NaN());
      for (int d = kDisparitySteps + 1024; d >= -kStep && truth.at(x, y) == kNoDisparity; d -= kStep) {
        const double w = std::max(grid.inverse_depth(std::max(d, 0)), 0.0);
        for (size_t k = 0; k < sights.size(); ++k) {
          const size_t i = sights[k].camera;
          double gap = surface_behind(cameras[i], depths[i], w * origin + direction, w);
          if (d <= 0 && gap < tolerance) gap = tolerance / 2;  // the sky, or farther than the range
          // In front of the surface before, on or behind it now.
          if (before[k] < 0 && gap >= 0 && gap <= tolerance)
            truth.at(x, y) = static_cast<uint16_t>(std::clamp(d, 0, kDisparitySteps));
          before[k] = gap;
        }
      }
    }
  });
  return truth;
}

}  // namespace ldp
