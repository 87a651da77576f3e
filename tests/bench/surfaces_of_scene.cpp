#include <algorithm>
#include <cmath>

#include "sim/scene/picture.h"
#include "tests/bench/true_surfaces.h"

namespace ldp {
namespace {

constexpr int kSubrays = 4;    // per axis of a pixel
constexpr int kMostHits = 24;  // of one ray: what lies deeper no view sees
constexpr double kFar = 1e5;

// Views whose depth maps tell whether a point is seen at all.
class Witnesses {
 public:
  explicit Witnesses(const std::vector<TrueView>& views) : views_(views) {}

  // `at` is the point times its inverse depth w, so that w = 0 is a direction. Starts with the view that saw the last
  // one.
  bool see(const Eigen::Vector3d& at, double w, size_t& last) const {
    for (size_t i = 0; i < views_.size(); ++i) {
      const size_t view = (last + i) % views_.size();
      if (!sees(views_[view], at, w)) continue;
      last = view;
      return true;
    }
    return false;
  }

 private:
  static bool sees(const TrueView& view, const Eigen::Vector3d& at, double w) {
    const Eigen::Vector3d q = view.camera.pose.world_from_camera.transpose() * (at - w * view.camera.pose.centre);
    if (q.z() <= 1e-6) return false;
    const Eigen::Vector2d px = project(view.camera.intrinsics, q);
    const int x = static_cast<int>(std::floor(px.x())), y = static_cast<int>(std::floor(px.y()));
    if (!view.z.contains(x, y)) return false;
    const double inverse_z = w / q.z(), slack = 0.01 * inverse_z + 1e-4;
    for (int v = std::max(0, y - 1); v <= std::min(view.z.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(view.z.width - 1, x + 1); ++u)
        if (1 / static_cast<double>(view.z.at(u, v)) <= inverse_z + slack) return true;
    return false;
  }

  const std::vector<TrueView>& views_;
};

struct Met {
  float w;
  int subray;
  Eigen::Vector3f colour;
};

class PixelTracer {
 public:
  PixelTracer(const PanoramaGrid& grid, const Scene& scene, const Witnesses& witnesses)
      : grid_(grid), scene_(scene), witnesses_(witnesses) {}

  TrueSurfaces trace(int x, int y) {
    met_.clear();
    for (int k = 0; k < kSubrays * kSubrays; ++k)
      follow(x + (k % kSubrays + 0.5) / kSubrays, y + (k / kSubrays + 0.5) / kSubrays, k);
    std::sort(met_.begin(), met_.end(), [](const Met& a, const Met& b) { return a.w > b.w; });
    TrueSurfaces surfaces;
    size_t found = 0;
    for (auto begin = met_.begin(); begin != met_.end() && found < surfaces.size();) {
      auto end = begin + 1;
      while (end != met_.end() && !separate((end - 1)->w, end->w)) ++end;
      surfaces[found++] = surface(begin, end);
      begin = end;
    }
    return surfaces;
  }

 private:
  using MetIterator = std::vector<Met>::const_iterator;

  void follow(double x_px, double y_px, int subray) {
    const double theta = grid_.theta(x_px), v = grid_.v(y_px);
    const Ray ray{grid_.origin(theta), grid_.direction(theta, v), grid_.v_pitch};
    double t_min = 1 / grid_.w_near;
    for (int i = 0; i < kMostHits; ++i) {
      const Hit hit = scene_.first_hit(ray, t_min);
      const double w = hit.t < kFar ? 1 / hit.t : 0;
      if (witnesses_.see(ray.direction + w * ray.origin, w, last_witness_))
        met_.push_back({static_cast<float>(w), subray, hit.colour});
      if (w == 0) return;
      t_min = hit.t * (1 + 1e-9) + 1e-9;
    }
  }

  // What the nearest meeting of each ray shows, front to back in [begin, end).
  static TrueSurface surface(MetIterator begin, MetIterator end) {
    Eigen::Vector3f light = Eigen::Vector3f::Zero();
    float w = 0;
    uint32_t rays = 0;
    int count = 0;
    for (auto m = begin; m != end; ++m) {
      const uint32_t bit = 1U << m->subray;
      if ((rays & bit) != 0) continue;
      rays |= bit;
      light += m->colour, w += m->w, ++count;
    }
    const auto n = static_cast<float>(count);
    const double share = n / (kSubrays * kSubrays);
    return {w / n, developed(light / n), static_cast<uint8_t>(std::lround(255 * share))};
  }

  const PanoramaGrid& grid_;
  const Scene& scene_;
  const Witnesses& witnesses_;
  std::vector<Met> met_;
  size_t last_witness_ = 0;
};

}  // namespace

std::vector<TrueSurfaces> surfaces_of_scene(const PanoramaGrid& grid, const Scene& scene,
                                            const std::vector<TrueView>& views, const Job& job) {
  std::vector<TrueSurfaces> surfaces(static_cast<size_t>(grid.width) * static_cast<size_t>(grid.height));
  const Witnesses witnesses(views);
  parallel_for(job, grid.height, [&](int y) {
    PixelTracer tracer(grid, scene, witnesses);
    for (int x = 0; x < grid.width; ++x)
      surfaces[static_cast<size_t>(y) * static_cast<size_t>(grid.width) + static_cast<size_t>(x)] = tracer.trace(x, y);
  });
  return surfaces;
}

}  // namespace ldp
