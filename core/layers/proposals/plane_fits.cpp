// Planes fitted to squares of a depth map, by consensus (Fischler and Bolles 1981).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/layers/layers_tuning.h"
#include "core/layers/neighbours.h"
#include "core/layers/simpler_maps.h"

namespace ldp {
namespace {

using namespace layers;
using namespace tuning;

constexpr int kStride = kPlaneSquarePx / 2;  // of squares: every pixel lies in four

struct Sample {
  int x, y;  // from the square's corner
  int disparity;
};

// Disparity over columns and rows from a square's corner, and the share of the square's samples that lie on it.
struct DisparityPlane {
  double corner = 0, by_column = 0, by_row = 0, share = 0;

  double at(int x, int y) const { return corner + by_column * x + by_row * y; }
  double off(const Sample& sample) const { return std::abs(at(sample.x, sample.y) - sample.disparity); }
};

// Through three samples; false where they lie nearly in a line.
bool through(const Sample& a, const Sample& b, const Sample& c, DisparityPlane& plane) {
  const int ab_x = b.x - a.x, ab_y = b.y - a.y, ac_x = c.x - a.x, ac_y = c.y - a.y;
  const int area = ab_x * ac_y - ac_x * ab_y;
  if (std::abs(area) < kLeastPlaneArea) return false;
  const double ab = b.disparity - a.disparity, ac = c.disparity - a.disparity;
  plane.by_column = (ab * ac_y - ac * ab_y) / area;
  plane.by_row = (ac * ab_x - ab * ac_x) / area;
  plane.corner = a.disparity - plane.by_column * a.x - plane.by_row * a.y;
  return true;
}

int64_t on_plane(const std::vector<Sample>& samples, double tolerance, const DisparityPlane& plane) {
  return std::count_if(samples.begin(), samples.end(),
                       [&](const Sample& sample) { return plane.off(sample) <= tolerance; });
}

// Moves the plane to where the samples on it lie on average.
void settle(const std::vector<Sample>& samples, double tolerance, DisparityPlane& plane) {
  double count = 0, x = 0, y = 0, d = 0, xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;
  for (const Sample& sample : samples) {
    if (plane.off(sample) > tolerance) continue;
    count += 1;
    x += sample.x, y += sample.y, d += sample.disparity;
    xx += sample.x * sample.x, xy += sample.x * sample.y, yy += sample.y * sample.y;
    xd += sample.x * sample.disparity, yd += sample.y * sample.disparity;
  }
  if (count == 0) return;
  xx -= x * x / count, xy -= x * y / count, yy -= y * y / count, xd -= x * d / count, yd -= y * d / count;
  const double area = xx * yy - xy * xy;
  if (area < count * count) return;  // nearly in a line
  plane.by_column = (xd * yy - yd * xy) / area;
  plane.by_row = (xx * yd - xy * xd) / area;
  plane.corner = (d - plane.by_column * x - plane.by_row * y) / count;
}

// What most of the samples lie on; of share 0 where there is nothing of the kind.
DisparityPlane plane_of(const std::vector<Sample>& samples, double tolerance) {
  DisparityPlane best;
  if (samples.size() < kLeastPlaneSamples) return best;
  std::minstd_rand random;  // the same for every square
  const auto any = [&] { return samples[random() % samples.size()]; };
  int64_t most = 0;
  for (int i = 0; i < kPlaneTries; ++i) {
    DisparityPlane plane;
    const Sample a = any(), b = any(), c = any();
    if (!through(a, b, c, plane)) continue;
    const int64_t count = on_plane(samples, tolerance, plane);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  if (most == 0) return best;
  for (int round = 0; round < 2; ++round) settle(samples, tolerance, best);
  best.share = static_cast<double>(on_plane(samples, tolerance, best)) / static_cast<double>(samples.size());
  return best;
}

// The planes of all squares. That of square (i, j) begins at column (i - 1) kStride and row (j - 1) kStride: the first
// ones begin outside.
class Planes {
 public:
  Planes(const PanoramaGrid& grid, const DisparityMap& layer, const Job& job)
      : grid_(grid),
        layer_(layer),
        tolerance_(parallax_steps(grid, kOnPlanePx)),
        planes_(layer.height / kStride + 2, layer.width / kStride + 2) {
    parallel_for(job, planes_.height, [&](int across) {
      std::vector<Sample> samples;
      for (int down = 0; down < planes_.width; ++down) {
        collect(corner(across), corner(down), samples);
        planes_.row(across)[down] = plane_of(samples, tolerance_);
      }
    });
  }

  // The disparity of the pixel on the plane that holds most of its square; its own where there is none.
  double at(int x, int y) const {
    double share = kLeastPlaneShare, disparity = layer_.at(x, y);
    for (int across = x / kStride; across <= x / kStride + 1; ++across)
      for (int down = y / kStride; down <= y / kStride + 1; ++down) {
        const DisparityPlane& plane = planes_.row(across)[down];
        if (plane.share < share) continue;
        share = plane.share;
        disparity = plane.at(x - corner(across), y - corner(down));
      }
    return disparity;
  }

 private:
  static int corner(int index) { return (index - 1) * kStride; }

  // Every fourth pixel of the square.
  void collect(int left, int top, std::vector<Sample>& samples) const {
    samples.clear();
    for (int x = 0; x < kPlaneSquarePx; x += 2) {
      const int column = neighbour_column(grid_, left + x);
      if (column < 0) continue;
      for (int y = x / 2 % 2; y < kPlaneSquarePx; y += 2)
        if (layer_.contains(column, top + y) && layer_.at(column, top + y) != kNoDisparity)
          samples.push_back({x, y, layer_.at(column, top + y)});
    }
  }

  const PanoramaGrid& grid_;
  const DisparityMap& layer_;
  double tolerance_;              // disparity steps
  Plane<DisparityPlane> planes_;  // column by column
};

}  // namespace

void put_onto_planes(const PanoramaGrid& grid, const Job& job, DisparityMap& layer) {
  const DisparityMap before = layer;
  const Planes planes(grid, before, job);
  const double farthest = parallax_steps(grid, kOtherPlanePx);
  parallel_for(job, layer.height, [&](int y) {
    for (int x = 0; x < layer.width; ++x) {
      if (before.at(x, y) == kNoDisparity) continue;
      const double disparity = std::clamp<double>(planes.at(x, y), 0, kDisparitySteps);
      if (std::abs(disparity - before.at(x, y)) <= farthest)
        layer.at(x, y) = static_cast<uint16_t>(std::lround(disparity));
    }
  });
}

}  // namespace ldp
