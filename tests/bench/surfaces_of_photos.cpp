#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bench/true_surfaces.h"

namespace ldp {
namespace {

// A sample of a surface: what a frame saw near a ray of the panorama.
struct Sample {
  float w;
  uint16_t frame, x, y;
  float off_axis;  // how far the frame's camera is from the ray, as an angle in columns
};

// Where in the panorama a frame's pixel is; y outside or behind the ray origins: x = -1.
struct Place {
  int x = -1, y = 0;
  float w = 0;
};
Place place(const PanoramaGrid& grid, const TrueView& frame, double x_px, double y_px, float z) {
  const Eigen::Vector3d ray = frame.camera.pose.world_from_camera * unproject(frame.camera.intrinsics, {x_px, y_px});
  const double far = 1e5;
  const PanoramaPosition p = locate(grid, frame.camera.pose.centre + ray * std::min(far, static_cast<double>(z)));
  Place out;
  if (p.inverse_depth <= 0 || p.inverse_depth > grid.w_near) return out;
  const int x = static_cast<int>(p.x_px), y = static_cast<int>(std::floor(p.y_px));
  if (x >= grid.width || y < 0 || y >= grid.height) return out;
  return {x, y, p.inverse_depth < 2 / far ? 0 : static_cast<float>(p.inverse_depth)};
}

// The depth at which ray (x, y) meets the surface that `frame` sees near inverse depth w; negative if it does not.
float refine(const PanoramaGrid& grid, const TrueView& frame, int x, int y, float w, Eigen::Vector2d& at_px) {
  const double theta = grid.theta(x + 0.5), v = grid.v(y + 0.5);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d q = grid.direction(theta, v) + w * (grid.origin(theta) - frame.camera.pose.centre);
    const Eigen::Vector3d c = frame.camera.pose.world_from_camera.transpose() * q;
    if (c.z() <= 1e-6) return -1;
    at_px = project(frame.camera.intrinsics, c);
    const int px = static_cast<int>(std::floor(at_px.x())), py = static_cast<int>(std::floor(at_px.y()));
    if (!frame.z.contains(px, py)) return -1;
    const float z = frame.z.at(px, py);
    const Eigen::Vector3d p = frame.camera.pose.centre +
                              frame.camera.pose.world_from_camera * (c / c.z()) * std::min(1e5, static_cast<double>(z));
    const double depth = 1 / locate(grid, p).inverse_depth;
    if (depth <= 0) return -1;
    const float next = depth > 5e4 ? 0 : static_cast<float>(1 / depth);
    const float change = std::abs(next - w);
    w = next;
    if (change < 1e-5F) return w;
    if (i == 3 && change > 0.01F * w + 1e-3F) return -1;
  }
  return w;
}

// Catmull-Rom weights of the samples at -1, 0, 1, 2 for position f in [0, 1).
std::array<double, 4> cubic_weights(double f) {
  return {((-0.5 * f + 1) * f - 0.5) * f, (1.5 * f - 2.5) * f * f + 1, ((-1.5 * f + 2) * f + 0.5) * f,
          (0.5 * f - 0.5) * f * f};
}

Rgb sample(const RgbImage& image, double x_px, double y_px) {
  const double x = x_px - 0.5, y = y_px - 0.5;
  const int xi = static_cast<int>(std::floor(x)), yi = static_cast<int>(std::floor(y));
  const auto wx = cubic_weights(x - xi), wy = cubic_weights(y - yi);
  double r = 0, g = 0, b = 0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const Rgb c = image.at(std::clamp(xi - 1 + i, 0, image.width - 1), std::clamp(yi - 1 + j, 0, image.height - 1));
      const double w = wx[static_cast<size_t>(i)] * wy[static_cast<size_t>(j)];
      r += w * c.r, g += w * c.g, b += w * c.b;
    }
  const auto byte = [](double value) { return static_cast<uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); };
  return {byte(r), byte(g), byte(b)};
}

// Is the frame's depth all of one surface around the pixel (so that its colour is no mixture)?
bool clean(const TrueView& frame, const Eigen::Vector2d& at_px) {
  const int px = static_cast<int>(std::floor(at_px.x())), py = static_cast<int>(std::floor(at_px.y()));
  const float z = frame.z.at(px, py);
  for (int y = std::max(0, py - 1); y <= std::min(frame.z.height - 1, py + 1); ++y)
    for (int x = std::max(0, px - 1); x <= std::min(frame.z.width - 1, px + 1); ++x)
      if (separate(1 / z, 1 / frame.z.at(x, y))) return false;
  return true;
}

struct Photographed {
  const PanoramaGrid& grid;
  const std::vector<TrueView>& frames;
};

std::vector<std::vector<Sample>> gather(const Photographed& scene) {
  std::vector<std::vector<Sample>> samples(static_cast<size_t>(scene.grid.width) *
                                           static_cast<size_t>(scene.grid.height));
  for (size_t f = 0; f < scene.frames.size(); ++f) {
    const TrueView& frame = scene.frames[f];
    const Eigen::Vector3d local =
        scene.grid.arc.world_from_arc.transpose() * (frame.camera.pose.centre - scene.grid.arc.centre);
    const double angle = std::atan2(local.y(), local.x());
    for (int y = 0; y < frame.z.height; ++y)
      for (int x = 0; x < frame.z.width; ++x) {
        const Place p = place(scene.grid, frame, x + 0.5, y + 0.5, frame.z.at(x, y));
        if (p.x < 0) continue;
        const double off = std::abs(std::remainder(scene.grid.theta(p.x + 0.5) - angle, 2 * std::numbers::pi));
        samples[static_cast<size_t>(p.y) * static_cast<size_t>(scene.grid.width) + static_cast<size_t>(p.x)].push_back(
            {p.w, static_cast<uint16_t>(f), static_cast<uint16_t>(x), static_cast<uint16_t>(y),
             static_cast<float>(off)});
      }
  }
  return samples;
}

// The surface of one cluster of samples: exact depth and colour from the frame nearest to the ray that agrees, one
// whose colour is no mixture if there is one.
TrueSurface resolve(const Photographed& scene, int x, int y, std::vector<Sample> cluster) {
  std::sort(cluster.begin(), cluster.end(), [](const Sample& a, const Sample& b) { return a.off_axis < b.off_axis; });
  TrueSurface best;
  for (const Sample& s : cluster) {
    Eigen::Vector2d at;
    const TrueView& frame = scene.frames[s.frame];
    const float w = refine(scene.grid, frame, x, y, s.w, at);
    if (w < 0 || separate(w, s.w)) continue;
    const bool good = clean(frame, at);
    if (best.w < 0 || good) best = {w, sample(frame.colour, at.x(), at.y())};
    if (good) break;
  }
  return best;
}

}  // namespace

std::vector<TrueSurfaces> surfaces_of_photos(const PanoramaGrid& grid, const std::vector<TrueView>& views) {
  const Photographed scene{grid, views};
  const auto samples = gather(scene);
  std::vector<TrueSurfaces> surfaces(samples.size());
  for (int y = 0; y < scene.grid.height; ++y)
    for (int x = 0; x < scene.grid.width; ++x) {
      const size_t i = static_cast<size_t>(y) * static_cast<size_t>(scene.grid.width) + static_cast<size_t>(x);
      std::vector<Sample> sorted;
      // A ray's surfaces are seen through the pixels around it as well: samples fall between the rays.
      for (int ny = std::max(0, y - 1); ny <= std::min(scene.grid.height - 1, y + 1); ++ny)
        for (int nx = std::max(0, x - 1); nx <= std::min(scene.grid.width - 1, x + 1); ++nx)
          for (const Sample& s :
               samples[static_cast<size_t>(ny) * static_cast<size_t>(scene.grid.width) + static_cast<size_t>(nx)])
            sorted.push_back(s);
      std::sort(sorted.begin(), sorted.end(), [](const Sample& a, const Sample& b) { return a.w > b.w; });
      int found = 0;
      for (size_t begin = 0; begin < sorted.size() && found < kTrueLayers;) {
        size_t end = begin + 1;
        while (end < sorted.size() && !separate(sorted[end - 1].w, sorted[end].w)) ++end;
        const TrueSurface surface = resolve(
            scene, x, y,
            {sorted.begin() + static_cast<std::ptrdiff_t>(begin), sorted.begin() + static_cast<std::ptrdiff_t>(end)});
        if (surface.w >= 0) surfaces[i][static_cast<size_t>(found++)] = surface;
        begin = end;
      }
    }
  return surfaces;
}

}  // namespace ldp
