#include "core/export/around.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/view/inpainting.h"

namespace ldp {
namespace {

// Within a slit the eye stands still: at most 0.16 mm from where it belongs, for eyes 64 mm apart.
constexpr double kSlit_rad = 0.01;

// Where an equirectangular picture of the panorama's own resolution lies on the sphere.
FlatPanorama frame_of(const PanoramaGrid& grid) {
  FlatPanorama flat;
  flat.full_width = 2 * std::max(1, static_cast<int>(std::lround(std::numbers::pi / grid.theta_pitch)));
  flat.full_height = flat.full_width / 2;
  const double pitch = 2 * std::numbers::pi / flat.full_width;
  const double top = std::atan(grid.v_top), bottom = std::atan(grid.v(grid.height));
  // Even, so that its middle is the sphere's.
  const int width = grid.wraps ? flat.full_width : std::max(2, std::min(grid.width, flat.full_width) / 2 * 2);
  const int height = std::clamp(static_cast<int>(std::lround((top - bottom) / pitch)), 1, flat.full_height);
  flat.image = RgbImage(width, height);
  flat.left = (flat.full_width - width) / 2;
  const int top_px = static_cast<int>(std::lround((std::numbers::pi / 2 - top) / pitch));
  flat.top = std::clamp(top_px, 0, flat.full_height - height);
  return flat;
}

struct Seen {
  Rgb colour;
  uint8_t alpha = 0;
  double inverse_z = -1;  // negative: nothing
};

// Between four pixels, each by its share of what is there.
Seen sample(const View& view, const Eigen::Vector2d& at) {
  const double x = std::clamp(at.x() - 0.5, 0.0, view.colour.width - 1.0);
  const double y = std::clamp(at.y() - 0.5, 0.0, view.colour.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), view.colour.width - 2);
  const int y0 = std::min(static_cast<int>(y), view.colour.height - 2);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double alpha = 0;
  for (const int dy : {0, 1})
    for (const int dx : {0, 1}) {
      const double share = (1 - std::abs(x - x0 - dx)) * (1 - std::abs(y - y0 - dy)) * view.alpha.at(x0 + dx, y0 + dy);
      const Rgb colour = view.colour.at(x0 + dx, y0 + dy);
      sum += share * Eigen::Vector3d(colour.r, colour.g, colour.b);
      alpha += share;
    }
  if (alpha < 0.5) return {};
  const auto channel = [&](int i) { return static_cast<uint8_t>(std::lround(sum[i] / alpha)); };
  const float z = view.depth.at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
  return {{channel(0), channel(1), channel(2)}, static_cast<uint8_t>(std::lround(alpha)), z > 0 ? 1.0 / z : -1};
}

class AroundView {
 public:
  // `aside`: of the eye, along the right hand of whoever looks at a column.
  AroundView(const LayeredPanorama& panorama, const Renderer& renderer, const Eigen::Vector3d& at, double aside)
      : grid_(panorama.grid), renderer_(renderer), aside_(aside), flat_(frame_of(panorama.grid)) {
    pitch_ = 2 * std::numbers::pi / flat_.full_width;
    middle_ = grid_.theta(grid_.width / 2.0);
    const Eigen::Vector3d n = grid_.arc.axis(), out = grid_.arc.outward(middle_);
    centre_ = grid_.arc.centre + at.x() * out + at.y() * n.cross(out) + at.z() * n;
  }

  FlatPanorama run(const Job& job) {
    const int columns = std::max(1, static_cast<int>(kSlit_rad / pitch_));
    for (int begin = 0; begin < flat_.image.width; begin += columns) {
      job.report("rendering", static_cast<double>(begin) / flat_.image.width);
      add_slit(begin, std::min(begin + columns, flat_.image.width), job);
    }
    flat_.inverse_distance = view::background_behind_holes(inverse_distance_, alpha_);
    view::fill_background(inverse_distance_, flat_.image, alpha_);
    return std::move(flat_);
  }

 private:
  double angle(double column) const { return middle_ + (flat_.image.width / 2.0 - column) * pitch_; }
  double elevation(int row) const { return std::numbers::pi / 2 - (flat_.top + row + 0.5) * pitch_; }

  Camera camera_at(double theta, int columns) const {
    const Eigen::Vector3d forward = grid_.arc.outward(theta), up = grid_.arc.axis(), right = forward.cross(up);
    Camera camera;
    camera.pose.world_from_camera << right, -up, forward;
    camera.pose.centre = centre_ + aside_ * right;
    Intrinsics& lens = camera.intrinsics;
    lens.fx = lens.fy = 1 / pitch_;
    const double cosine = std::cos(columns * pitch_ / 2);
    const double top = std::tan(elevation(0)) / cosine, bottom = std::tan(elevation(flat_.image.height - 1)) / cosine;
    lens.width = columns + 4;
    lens.height = static_cast<int>(std::ceil((top - bottom) * lens.fy)) + 4;
    lens.cx = lens.width / 2.0;
    lens.cy = top * lens.fy + 2;
    return camera;
  }

  void add_slit(int begin, int end, const Job& job) {
    const double theta = angle((begin + end) / 2.0);
    const Camera camera = camera_at(theta, end - begin);
    const View view = renderer_.render(camera, {.depth = true}, job);
    for (int y = 0; y < flat_.image.height; ++y)
      for (int x = begin; x < end; ++x) {
        const double turn = theta - angle(x + 0.5);  // to the right
        const Eigen::Vector3d ray(std::tan(turn), -std::tan(elevation(y)) / std::cos(turn), 1);
        const Seen seen = sample(view, project(camera.intrinsics, ray));
        flat_.image.at(x, y) = seen.colour;
        alpha_.at(x, y) = seen.alpha;
        inverse_distance_.at(x, y) = static_cast<float>(seen.inverse_z / ray.norm());
      }
  }

  const PanoramaGrid& grid_;
  const Renderer& renderer_;
  double aside_, pitch_ = 0, middle_ = 0;
  Eigen::Vector3d centre_;
  FlatPanorama flat_;
  Plane<uint8_t> alpha_{flat_.image.width, flat_.image.height};
  Plane<float> inverse_distance_{flat_.image.width, flat_.image.height};
};

}  // namespace

FlatPanorama see_around(const LayeredPanorama& panorama, const Renderer& renderer, const Eigen::Vector3d& at,
                        const Job& job) {
  return AroundView(panorama, renderer, at, 0).run(job);
}

std::pair<FlatPanorama, FlatPanorama> see_around_in_stereo(const LayeredPanorama& panorama, const Renderer& renderer,
                                                           const Viewer& viewer, const Job& job) {
  return {AroundView(panorama, renderer, viewer.at, -viewer.eyes / 2).run(job),
          AroundView(panorama, renderer, viewer.at, viewer.eyes / 2).run(job)};
}

RgbImage top_bottom(const FlatPanorama& left, const FlatPanorama& right) {
  RgbImage both(left.full_width, 2 * left.full_height);
  for (const auto& [eye, begin] : {std::pair{&left, 0}, {&right, left.full_height}})
    for (int y = 0; y < eye->image.height; ++y)
      for (int x = 0; x < eye->image.width; ++x) both.at(eye->left + x, begin + eye->top + y) = eye->image.at(x, y);
  return both;
}

}  // namespace ldp
