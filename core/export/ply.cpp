#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "core/export/export.h"

namespace ldp {
namespace {

struct CloudPoint {
  Eigen::Vector3f position;
  Rgb colour;
  uint8_t layer = 0;
};

constexpr size_t kPointBytes = 3 * 4 + 3 + 1;

std::string ply_header(size_t points) {
  return "ply\nformat binary_little_endian 1.0\ncomment layered-depth-panorama, written by ldp\nelement vertex " +
         std::to_string(points) +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
         "property uchar blue\nproperty uchar layer\nend_header\n";
}

void append(const CloudPoint& point, std::vector<uint8_t>& bytes) {
  for (const float coordinate : point.position) {
    const auto bits = std::bit_cast<uint32_t>(coordinate);
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(bits >> shift));
  }
  for (const uint8_t byte : {point.colour.r, point.colour.g, point.colour.b, point.layer}) bytes.push_back(byte);
}

// Calls use(point) for every present pixel of the layer that is not at infinity.
template <typename Use>
void for_each_point(const LayeredPanorama& panorama, size_t index, const Use& use) {
  const PanoramaGrid& grid = panorama.grid;
  const Layer& layer = panorama.layers[index];
  for (int x = 0; x < grid.width; ++x) {
    const double theta = grid.theta(x + 0.5);
    const Eigen::Vector3d origin = grid.origin(theta), outward = grid.direction(theta, 0), up = grid.arc.axis();
    for (int y = 0; y < grid.height; ++y) {
      if (!layer.coverage.at(x, y)) continue;
      const double w = grid.inverse_depth(layer.depth.disparity(x, y));
      if (!(w > 0)) continue;
      const Eigen::Vector3d position = origin + 1 / w * outward + grid.v(y + 0.5) / w * up;
      use(CloudPoint{position.cast<float>(), layer.colour.at(x, y), static_cast<uint8_t>(index + 1)});
    }
  }
}

}  // namespace

std::vector<uint8_t> export_ply(const LayeredPanorama& panorama, const Job& job) {
  size_t points = 0;
  for (size_t i = 0; i < panorama.layers.size(); ++i) for_each_point(panorama, i, [&](const CloudPoint&) { ++points; });
  job.check();
  const std::string header = ply_header(points);
  std::vector<uint8_t> bytes(header.begin(), header.end());
  bytes.reserve(header.size() + points * kPointBytes);
  for (size_t i = 0; i < panorama.layers.size(); ++i)
    for_each_point(panorama, i, [&](const CloudPoint& point) { append(point, bytes); });
  return bytes;
}

}  // namespace ldp
