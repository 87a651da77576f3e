#include "core/view/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "core/geometry/disparity.h"
#include "core/view/camera_path.h"
#include "core/view/framing.h"

namespace ldp {
namespace {

constexpr double kPi = std::numbers::pi;

PanoramaGrid make_grid(Rays rays, bool wraps) {
  PanoramaGrid grid;
  grid.arc.centre = {0.3, -0.2, 1.5};
  grid.arc.world_from_arc = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  grid.arc.radius = 0.6;
  grid.rays = rays;
  grid.width = wraps ? 628 : 300;
  grid.height = 160;
  grid.theta_pitch = wraps ? 2 * kPi / grid.width : 0.01;
  grid.v_pitch = 0.01;
  grid.theta_left = 1.5;
  grid.v_top = 0.8;
  grid.wraps = wraps;
  grid.w_near = 2;
  return grid;
}

// A camera at `offset` from the arc's centre (arc axes) that looks along u(theta), turned down by `pitch`.
Camera make_camera(const PanoramaGrid& grid, double theta, const Eigen::Vector3d& offset, double pitch = 0) {
  Camera camera;
  camera.name = "view";
  camera.intrinsics = {120, 90, 100, 100, 60, 45};
  const Eigen::Vector3d forward = std::cos(pitch) * grid.arc.outward(theta) - std::sin(pitch) * grid.arc.axis();
  const Eigen::Vector3d right = forward.cross(grid.arc.axis()).normalized();
  camera.pose.world_from_camera << right, forward.cross(right), forward;
  camera.pose.centre = grid.arc.centre + grid.arc.world_from_arc * offset;
  return camera;
}

using WOfRay = std::function<double(double theta, double v)>;  // negative: absent
using ColourOfRay = std::function<Rgb(double theta, double v)>;

Layer make_layer(const PanoramaGrid& grid, const WOfRay& w_of_ray, const ColourOfRay& colour_of_ray, int block_px = 8) {
  Layer layer;
  DisparityMap disparity(grid.width, grid.height, kNoDisparity);
  layer.coverage = Plane<uint8_t>(grid.width, grid.height);
  layer.colour = RgbImage(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const double theta = grid.theta(x + 0.5), v = grid.v(y + 0.5), w = w_of_ray(theta, v);
      if (w < 0) continue;
      disparity.at(x, y) = static_cast<uint16_t>(std::lround(std::clamp(w / grid.w_near, 0.0, 1.0) * kDisparitySteps));
      layer.coverage.at(x, y) = 1;
      layer.colour.at(x, y) = colour_of_ray(theta, v);
    }
  layer.depth = encode_depth(disparity, block_px);
  return layer;
}

Rgb smooth_colour(double theta, double v) {
  return {static_cast<uint8_t>(128 + 100 * std::sin(3 * theta)), static_cast<uint8_t>(128 + 100 * std::cos(4 * v + 1)),
          static_cast<uint8_t>(128 + 100 * std::sin(2 * theta + 3 * v))};
}
Rgb white(double, double) { return {255, 255, 255}; }
Rgb black(double, double) { return {0, 0, 0}; }

LayeredPanorama one_layer(const PanoramaGrid& grid, const WOfRay& w, const ColourOfRay& colour = smooth_colour,
                          int block_px = 8) {
  return {grid, {make_layer(grid, w, colour, block_px)}, {}, {}, {}, {}};
}

// A near square of white before a black background at infinity that goes on behind it in layer 1.
constexpr double kFrontW = 1.0;
bool in_square(double theta, double v) { return std::abs(theta) < 0.2 && std::abs(v) < 0.2; }
LayeredPanorama square_before_background(const PanoramaGrid& grid) {
  const auto front = [](double theta, double v) { return in_square(theta, v) ? kFrontW : 0.0; };
  const auto behind = [](double theta, double v) { return in_square(theta, v) ? 0.0 : -1.0; };
  const auto colour = [](double theta, double v) { return in_square(theta, v) ? Rgb{255, 255, 255} : Rgb{0, 0, 0}; };
  return {grid, {make_layer(grid, front, colour), make_layer(grid, behind, black)}, {}, {}, {}, {}};
}

RenderOptions with_depth() {
  RenderOptions options;
  options.depth = true;
  return options;
}

int holes(const View& view) {
  return static_cast<int>(std::count(view.alpha.samples.begin(), view.alpha.samples.end(), 0));
}

class RenderOfBothRays : public testing::TestWithParam<Rays> {};
INSTANTIATE_TEST_SUITE_P(Rays, RenderOfBothRays, testing::Values(Rays::pushbroom, Rays::central));

TEST_P(RenderOfBothRays, shows_a_world_at_infinity_by_direction_alone_wherever_the_camera_is) {
  const PanoramaGrid grid = make_grid(GetParam(), false);
  const LayeredPanorama panorama = one_layer(grid, [](double, double) { return 0.0; });
  const Renderer renderer(panorama);
  for (const Eigen::Vector3d& offset : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(5, -3, 2)}) {
    const Camera camera = make_camera(grid, 0.1, offset, 0.1);
    const View view = renderer.render(camera, with_depth());
    for (int y = 0; y < 90; ++y)
      for (int x = 0; x < 120; ++x) {
        const Eigen::Vector3d d = grid.arc.world_from_arc.transpose() * camera.pose.world_from_camera *
                                  unproject(camera.intrinsics, {x + 0.5, y + 0.5});
        const Rgb expected = smooth_colour(std::atan2(d.y(), d.x()), d.z() / std::hypot(d.x(), d.y()));
        const Rgb got = view.colour.at(x, y);
        ASSERT_EQ(view.alpha.at(x, y), 255);
        ASSERT_NEAR(got.r, expected.r, 2);
        ASSERT_NEAR(got.g, expected.g, 2);
        ASSERT_NEAR(got.b, expected.b, 2);
        ASSERT_EQ(view.depth.at(x, y), INFINITY);
      }
  }
}

// Where a ray from `origin` along `direction` meets the plane n.x = c, in multiples of `direction`.
std::optional<double> meet(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const Eigen::Vector3d& n,
                           double c) {
  const double along = n.dot(direction), t = (c - n.dot(origin)) / along;
  if (std::abs(along) < 1e-9 || t <= 0) return std::nullopt;
  return t;
}

// World of one plane (in arc axes): every ray's inverse depth is exact, and so is every view's depth.
void expect_plane(const PanoramaGrid& grid, const Eigen::Vector3d& n, double c, const Camera& camera,
                  double tolerance) {
  const auto w = [&](double theta, double v) {
    const Eigen::Vector3d d(std::cos(theta), std::sin(theta), v);
    const auto t = meet(grid.ray_radius() * Eigen::Vector3d(d.x(), d.y(), 0), d, n, c);
    return t ? 1 / *t : 0.0;
  };
  const View view = Renderer(one_layer(grid, w)).render(camera, with_depth());
  const Eigen::Matrix3d arc_from_world = grid.arc.world_from_arc.transpose();
  int compared = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      const Eigen::Vector3d d =
          arc_from_world * camera.pose.world_from_camera * unproject(camera.intrinsics, {x + 0.5, y + 0.5});
      const auto z = meet(arc_from_world * (camera.pose.centre - grid.arc.centre), d, n, c);
      if (!z || *z > 10) continue;
      ASSERT_EQ(view.alpha.at(x, y), 255) << "crack at " << x << ", " << y;
      ASSERT_NEAR(1 / view.depth.at(x, y), 1 / *z, tolerance) << x << ", " << y;
      ++compared;
    }
  EXPECT_GT(compared, 2000);
}

TEST_P(RenderOfBothRays, has_no_cracks_and_exact_depth_on_a_slanted_wall_seen_from_inside_the_arc) {
  const PanoramaGrid grid = make_grid(GetParam(), false);
  expect_plane(grid, Eigen::Vector3d(1, 0.8, 0.1).normalized(), 2, make_camera(grid, 0.2, {0.1, 0, 0}), 0.01);
}

TEST_P(RenderOfBothRays, has_no_cracks_and_exact_depth_on_the_ground_seen_from_outside_the_arc) {
  const PanoramaGrid grid = make_grid(GetParam(), false);
  expect_plane(grid, {0, 0, 1}, -1.2, make_camera(grid, 0, {0.9, 0.1, 0.3}, 0.15), 0.01);
}

TEST_P(RenderOfBothRays, keeps_its_surface_whole_when_sixteen_uniform_codes_make_steps_of_it) {
  const PanoramaGrid grid = make_grid(GetParam(), false);
  const auto w = [&](double theta, double v) { return 0.6 * std::cos(theta) + 0.2 * v + 0.3; };
  const View view = Renderer(one_layer(grid, w, smooth_colour, 0)).render(make_camera(grid, 0, {0.3, 0.1, 0.05}), {});
  EXPECT_EQ(holes(view), 0);
}

TEST(Render, takes_the_steps_out_of_a_slanted_surface_in_blocks_that_an_edge_crosses) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const auto slanted = [](double theta, double v) { return 0.5 + 0.3 * theta + 0.1 * v; };
  const auto w = [&](double theta, double v) { return in_square(theta, v) ? 1.9 : slanted(theta, v); };
  const Camera camera = make_camera(grid, 0, {0.6, 0, 0});
  const View view = Renderer(one_layer(grid, w, smooth_colour, 16)).render(camera, with_depth());
  double mean = 0;
  for (int x = 25; x < 95; ++x) {
    const double theta = -std::atan((x + 0.5 - 60) / 100), v = 0.215 / std::cos(theta);  // just above the square
    const int y = static_cast<int>(45 - 100 * 0.215);
    const double depth = view.depth.at(x, y) / std::cos(theta);
    mean += std::abs(1 / depth - slanted(theta, v)) / 70;
  }
  EXPECT_LT(mean, 0.022);  // without: 0.026
}

TEST_P(RenderOfBothRays, closes_the_full_circle_without_a_seam) {
  const PanoramaGrid grid = make_grid(GetParam(), true);
  const auto colour = [](double theta, double v) { return smooth_colour(std::remainder(theta, 2 * kPi), v); };
  const LayeredPanorama panorama = one_layer(
      grid, [](double, double) { return 0.8; }, colour);
  const View view = Renderer(panorama).render(make_camera(grid, grid.theta_left, {0.1, 0.2, 0}), {});
  EXPECT_EQ(holes(view), 0);
  for (int x = 1; x < 120; ++x)
    EXPECT_NEAR(view.colour.at(x, 45).r, view.colour.at(x - 1, 45).r, 8) << "seam at column " << x;
}

// A post before a far wall, both cut off where the photo on the arc that shows them ends.
LayeredPanorama post_cut_by_frames(const std::vector<Camera>& photos) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  const auto post = [](double theta, double) { return std::abs(theta) < 0.1; };
  LayeredPanorama panorama = one_layer(
      grid, [&](double theta, double v) { return std::abs(v) > 0.45 ? -1
                                                 : post(theta, v)   ? 2
                                                                    : 0.01; },
      [&](double theta, double v) {
        return post(theta, v) ? white(theta, v) : Rgb{40, 40, 40};
      });
  panorama.cameras = photos;
  panorama.limits = {0.2, 0.6, 0};
  return panorama;
}

// From the arc, and a little aside on it.
std::vector<Camera> two_photos() {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  return {make_camera(grid, 0, {0.6, 0, 0}), make_camera(grid, 0.05, {0.6 * std::cos(0.05), 0.6 * std::sin(0.05), 0})};
}

View from_further_back(const std::vector<Camera>& photos) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  return Renderer(post_cut_by_frames(photos)).render(make_camera(grid, 0, {0.3, 0, 0}), with_depth());
}

TEST(Render, continues_near_surfaces_where_no_photo_could_show_their_end) {
  const View view = from_further_back(two_photos());
  for (int y = 0; y < view.colour.height; ++y) {
    EXPECT_EQ(view.colour.at(60, y), (Rgb{255, 255, 255})) << y;
    EXPECT_NEAR(view.depth.at(60, y), 0.8, 0.02) << y;
  }
}

TEST(Render, ends_near_surfaces_where_a_photo_would_have_shown_more) {
  std::vector<Camera> photos = two_photos();
  photos.push_back(make_camera(make_grid(Rays::pushbroom, true), 0, {0.6, 0, 0}, -0.4));
  const View view = from_further_back(photos);
  EXPECT_NE(view.colour.at(60, 2), (Rgb{255, 255, 255}));                       // a photo looked there
  EXPECT_EQ(view.colour.at(60, view.colour.height - 2), (Rgb{255, 255, 255}));  // none did
}

TEST(Render, ends_near_surfaces_that_one_photo_alone_shows) {
  const View view = from_further_back({two_photos().front()});
  EXPECT_NE(view.colour.at(60, 2), (Rgb{255, 255, 255}));
}

TEST(Render, shows_the_background_beside_an_edge_and_nothing_stretched_between) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const LayeredPanorama panorama = square_before_background(grid);
  const View view = Renderer(panorama).render(make_camera(grid, 0, {0.4, 0.3, 0}), with_depth());
  int front = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      ASSERT_GE(view.alpha.at(x, y), 254) << x << ", " << y;
      const float z = view.depth.at(x, y);
      ASSERT_TRUE(z == INFINITY || (z > 1.0F && z < 1.4F)) << "depth " << z << " at " << x << ", " << y;
      front += z != INFINITY ? 1 : 0;
    }
  EXPECT_GT(front, 500);
}

TEST(Render, leaves_a_hole_where_no_layer_is) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const LayeredPanorama panorama = square_before_background(grid);
  RenderOptions options = with_depth();
  options.layers = 1;
  const View view = Renderer(panorama).render(make_camera(grid, 0, {0.4, 0.3, 0}), options);
  EXPECT_GT(holes(view), 300);
  for (size_t i = 0; i < view.alpha.samples.size(); ++i)
    ASSERT_TRUE(view.alpha.samples[i] != 0 || view.depth.samples[i] == 0);
}

// Steps aside so that the edge of a near pillar moves by `parallax_px` against the background, which one layer shows.
int holes_beside_pillar(double parallax_px, bool wraps, double pillar_theta) {
  const PanoramaGrid grid = make_grid(Rays::central, wraps);
  const auto off = [&](double theta) { return std::remainder(theta - pillar_theta, 2 * kPi); };
  const LayeredPanorama panorama =
      one_layer(grid, [&](double theta, double) { return std::abs(off(theta)) < 0.4 ? kFrontW : 0.0; });
  const Eigen::Vector3d aside(-std::sin(pillar_theta), std::cos(pillar_theta), 0);
  const Camera camera = make_camera(grid, pillar_theta, parallax_px * grid.theta_pitch / kFrontW * aside);
  return holes(Renderer(panorama).render(camera, {}));
}

TEST(Render, a_step_aside_opens_no_cracks_and_a_longer_one_shows_a_hole) {
  for (const auto& [wraps, theta] : {std::pair(false, 0.0), {true, 0.0}, {true, 1.3}, {true, 1.5}}) {
    EXPECT_EQ(holes_beside_pillar(4, wraps, theta), 0) << wraps << " " << theta;
    const int hole_px = holes_beside_pillar(40, wraps, theta);  // the view is 90 pixels high
    EXPECT_GT(hole_px, 90 * (40 - 24)) << wraps << " " << theta;
    EXPECT_LT(hole_px, 90 * (40 - 18)) << wraps << " " << theta;
  }
}

// A wall that steps back by `step_px` of parallax over one arc radius, in colours `levels` apart, seen from so far
// aside that no underlay fills the gap.
int holes_in_a_stepped_wall(double step_px, int levels) {
  const PanoramaGrid grid = make_grid(Rays::central, false);
  const double near_w = 0.05 + step_px * grid.v_pitch / grid.arc.radius;
  const LayeredPanorama panorama = one_layer(
      grid, [&](double theta, double) { return theta < 0 ? near_w : 0.05; },
      [&](double theta, double) {
        return theta < 0 ? Rgb{90, 20, 20} : Rgb{static_cast<uint8_t>(90 + levels), 20, 20};
      });
  return holes(Renderer(panorama).render(make_camera(grid, 0, {0, 3 * grid.arc.radius, 0}), {}));
}

TEST(Render, tears_what_looks_alike_from_more_parallax_on) {
  EXPECT_GT(holes_in_a_stepped_wall(14, 20), 90 * 3);
  EXPECT_EQ(holes_in_a_stepped_wall(14, 0), 0);
  EXPECT_GT(holes_in_a_stepped_wall(32, 0), 90 * 3);
}

TEST(Render, fills_holes_with_the_background_and_says_how_much_it_invented) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const LayeredPanorama panorama = square_before_background(grid);
  const Camera camera = make_camera(grid, 0, {0.4, 0.3, 0});
  RenderOptions options = with_depth();
  const View truth = Renderer(panorama).render(camera, options);
  options.layers = 1;
  const View open = Renderer(panorama).render(camera, options);
  options.fill = Fill::background;
  const View view = Renderer(panorama).render(camera, options);
  EXPECT_EQ(std::count(view.alpha.samples.begin(), view.alpha.samples.end(), 255), 120 * 90);
  const auto below_half =
      std::count_if(open.alpha.samples.begin(), open.alpha.samples.end(), [](uint8_t a) { return a < 128; });
  EXPECT_DOUBLE_EQ(view.invented_share, static_cast<double>(below_half) / (120 * 90));
  EXPECT_GT(view.invented_share, 0.03);
  for (size_t i = 0; i < view.colour.samples.size(); ++i) {
    ASSERT_NEAR(view.colour.samples[i].r, truth.colour.samples[i].r, 12) << "the white square bleeds into its hole";
    ASSERT_EQ(view.depth.samples[i], open.depth.samples[i]) << "an invented pixel has no depth";
  }
}

TEST(Render, fills_a_view_of_nothing_with_grey) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  RenderOptions options;
  options.fill = Fill::background;
  const View view =
      Renderer(one_layer(grid, [](double, double) { return 0.5; })).render(make_camera(grid, kPi, {0, 0, 0}), options);
  EXPECT_EQ(view.invented_share, 1);
  EXPECT_EQ(view.colour.at(3, 3), (Rgb{127, 127, 127}));
}

TEST(Render, softens_silhouettes) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const Renderer renderer(square_before_background(grid));
  const auto between = [&](bool outlines) {
    const View view = renderer.render(make_camera(grid, 0, {0.613, 0.017, 0.003}), {.outlines = outlines});
    return std::count_if(view.colour.samples.begin(), view.colour.samples.end(),
                         [](Rgb c) { return c.r > 20 && c.r < 235; });
  };
  EXPECT_GT(between(false), 60);   // the square's outline is about 160 pixels long
  EXPECT_LT(between(false), 250);  // and no wider than a pixel
  EXPECT_GT(between(true), between(false));
  EXPECT_LT(between(true), 480);  // mixed, at most three
}

TEST(Render, lets_the_layer_behind_through_by_the_alpha_of_the_one_before) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const auto at = [](double w) { return [w](double, double) { return w; }; };
  LayeredPanorama panorama{grid, {make_layer(grid, at(1), white), make_layer(grid, at(0.2), black)}, {}, {}, {}, {}};
  panorama.layers[0].alpha = Plane<uint8_t>(grid.width, grid.height, 64);
  const Camera camera = make_camera(grid, 0, {0.5, 0.1, 0});
  const View view = Renderer(panorama).render(camera, with_depth());
  EXPECT_NEAR(view.colour.at(60, 45).r, 64, 2);
  EXPECT_EQ(view.alpha.at(60, 45), 255);
  EXPECT_GT(view.depth.at(60, 45), 4);  // what is seen through three quarters of it lies behind
  panorama.layers.pop_back();
  const View alone = Renderer(panorama).render(camera, {});
  EXPECT_NEAR(alone.alpha.at(60, 45), 64, 1);
  EXPECT_EQ(alone.colour.at(60, 45).r, 255);
}

TEST(Render, honours_the_distortion_of_the_camera) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const Renderer renderer(
      one_layer(grid, [](double theta, double v) { return 0.5 + 0.2 * std::sin(2 * theta) + 0.1 * v; }));
  Camera camera = make_camera(grid, 0, {0.5, 0, 0});
  const View straight = renderer.render(camera, {});
  Camera bent = camera;
  bent.intrinsics.k1 = -0.15, bent.intrinsics.k2 = 0.02, bent.intrinsics.p1 = 0.003, bent.intrinsics.p2 = -0.002;
  const View view = renderer.render(bent, {});
  int compared = 0;
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      const Eigen::Vector2d p = project(camera.intrinsics, unproject(bent.intrinsics, {x + 0.5, y + 0.5}));
      const int px = static_cast<int>(p.x()), py = static_cast<int>(p.y());
      if (px < 0 || py < 0 || px >= 120 || py >= 90) continue;
      ASSERT_NEAR(view.colour.at(x, y).r, straight.colour.at(px, py).r, 5) << x << ", " << y;
      ++compared;
    }
  EXPECT_GT(compared, 8000);
  EXPECT_EQ(holes(view), 0);
}

TEST(Render, gives_the_same_bytes_at_any_thread_count) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  const Renderer renderer(square_before_background(grid));
  Camera camera = make_camera(grid, 0, {0.4, 0.3, 0.1}, 0.05);
  camera.intrinsics = {601, 333, 480, 480, 300, 160};
  RenderOptions options = with_depth();
  options.fill = Fill::background;
  Job threads;
  const View one = renderer.render(camera, options, threads);
  threads.threads = 3;
  const View three = renderer.render(camera, options, threads);
  EXPECT_EQ(one.colour, three.colour);
  EXPECT_EQ(one.alpha, three.alpha);
  EXPECT_EQ(one.depth, three.depth);
}

// Two wavy walls with holes through each other, before a far one.
LayeredPanorama wavy_walls() {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  const auto near = [](double theta, double v) {
    return std::sin(9 * theta) + std::cos(11 * v) < -0.5 ? -1 : 1.2 + 0.05 * std::sin(40 * theta);
  };
  const auto middle = [](double theta, double v) {
    return std::sin(7 * theta + 4 * v) < -0.5 ? -1 : 1.2 + 0.05 * std::cos(30 * v + theta);
  };
  const auto far = [](double, double v) { return 0.1 + 0.05 * v; };
  return {grid,
          {make_layer(grid, near, smooth_colour), make_layer(grid, middle, smooth_colour),
           make_layer(grid, far, smooth_colour)},
          {},
          {},
          {},
          {}};
}

TEST(Render, skips_nothing_that_shows) {
  const LayeredPanorama panorama = wavy_walls();
  const PanoramaGrid& grid = panorama.grid;
  const Renderer renderer(panorama);
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d offset = 0.1 * i * Eigen::Vector3d(std::cos(i), std::sin(i), 0.2);
    Camera camera = make_camera(grid, 0.7 * i, offset, 0.05 * i);
    camera.intrinsics = {450, 330, 250, 250, 220, 160};
    const View view = renderer.render(camera, with_depth());
    camera.intrinsics.k1 = 1e-12;  // a lens that moves nothing, but with lenses nothing is skipped
    const View all = renderer.render(camera, with_depth());
    ASSERT_EQ(view.colour, all.colour) << i;
    ASSERT_EQ(view.alpha, all.alpha) << i;
    ASSERT_EQ(view.depth, all.depth) << i;
  }
}

TEST(Render, shows_the_same_whatever_was_prepared_before_and_by_whom) {
  LayeredPanorama panorama = wavy_walls();
  const PanoramaGrid& grid = panorama.grid;
  std::vector<Camera> cameras;
  for (int i = 0; i < 12; ++i) {
    Camera& camera = cameras.emplace_back(
        make_camera(grid, 0.55 * i, 0.06 * i * Eigen::Vector3d(std::cos(i), std::sin(i), 0.2), 0.04 * i));
    // Every third looks at a few columns and rows alone, between others.
    camera.intrinsics = i % 3 == 0 ? Intrinsics{90, 60, 3000, 3000, 45, 30} : Intrinsics{120, 90, 100, 100, 60, 45};
  }
  panorama.cameras = cameras;  // surfaces go on beyond their frames
  panorama.limits = {0.3, 0.8, 0.2};
  Renderer ready(panorama);
  ready.prepare({});
  const Renderer shared(panorama);
  Job job;
  job.threads = 4;
  std::vector<View> together(cameras.size());
  parallel_for(job, static_cast<int>(cameras.size()), [&](int i) {
    together[static_cast<size_t>(i)] = shared.render(cameras[static_cast<size_t>(i)], with_depth());
  });
  const Renderer given_away((LayeredPanorama(panorama)));
  for (size_t i = 0; i < cameras.size(); ++i) {
    const View expected = ready.render(cameras[i], with_depth());
    EXPECT_LT(holes(expected), 90 * 60) << i;
    for (const View& view : {Renderer(panorama).render(cameras[i], with_depth()), together[i],
                             given_away.render(cameras[i], with_depth())}) {
      EXPECT_EQ(view.colour, expected.colour) << i;
      EXPECT_EQ(view.alpha, expected.alpha) << i;
      EXPECT_EQ(view.depth, expected.depth) << i;
    }
  }
}

TEST(Render, survives_cameras_inside_behind_and_beyond_every_surface) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  const Renderer renderer(square_before_background(grid));
  for (int i = 0; i < 60; ++i) {
    const double a = i * 2.4;
    const Eigen::Vector3d offset = 0.1 * i * Eigen::Vector3d(std::cos(3 * a), std::sin(3 * a), 0.3 * std::sin(a));
    const View view = renderer.render(make_camera(grid, a, offset, 1.5 * std::sin(a)), with_depth());
    for (size_t k = 0; k < view.depth.samples.size(); ++k) ASSERT_GE(view.depth.samples[k], 0);
  }
}

TEST(Render, refuses_a_view_without_size_or_focal_length_in_words) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const Renderer renderer(one_layer(grid, [](double, double) { return 0.5; }));
  Camera camera = make_camera(grid, 0, {0, 0, 0});
  camera.intrinsics.width = 0;
  EXPECT_THAT([&] { renderer.render(camera, {}); }, testing::ThrowsMessage<std::runtime_error>(testing::AllOf(
                                                        testing::HasSubstr("view"), testing::HasSubstr("0x90"))));
  camera.intrinsics.width = 120;
  camera.intrinsics.fx = 0;
  EXPECT_THAT([&] { renderer.render(camera, {}); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("fl_x")));
}

TEST(Render, refuses_a_layer_of_another_size_than_the_panorama) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  LayeredPanorama panorama = one_layer(grid, [](double, double) { return 0.5; });
  panorama.layers[0].colour = RgbImage(3, 3);
  EXPECT_THROW(Renderer{panorama}, std::logic_error);
}

TEST(Render, stops_when_asked) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, false);
  const Renderer renderer(one_layer(grid, [](double, double) { return 0.5; }));
  std::stop_source stop;
  stop.request_stop();
  Job job;
  job.stop = stop.get_token();
  EXPECT_THROW(renderer.render(make_camera(grid, 0, {0, 0, 0}), {}, job), Cancelled);
}

TEST(ViewingLimits, WhatIsFartherThanTheyAreWideIsFarButNothingIsWhereTheCameraMovedAlongNoArc) {
  const ViewingLimits limits{0.2, 0.8, 0.1};
  EXPECT_FALSE(limits.are_far_from(1.5, 0.8));
  EXPECT_TRUE(limits.are_far_from(1.7, 0));
  EXPECT_TRUE(limits.are_far_from(0, -1));
  EXPECT_FALSE((ViewingLimits{0, 0, 0.1}.are_far_from(1, 2)));
}

TEST(CameraPath, stays_upright_smooth_and_within_its_limits_and_ends_where_it_begins) {
  const PanoramaGrid base = make_grid(Rays::pushbroom, false);
  LayeredPanorama panorama = one_layer(base, [](double, double) { return 0.5; });
  panorama.grid.arc.theta_begin = -0.8, panorama.grid.arc.theta_end = 0.8;
  panorama.limits = {0.2, 0.9, 0.3};
  for (const auto kind : {CameraPath::sway, CameraPath::dolly, CameraPath::walk}) {
    CameraPathOptions options;
    options.kind = kind;
    const std::vector<Camera> path = camera_path(panorama, options);
    ASSERT_EQ(path.size(), 90U);
    EXPECT_EQ(path[7].name, "frame_007");
    for (size_t i = 0; i < path.size(); ++i) {
      const Eigen::Vector3d p =
          panorama.grid.arc.world_from_arc.transpose() * (path[i].pose.centre - panorama.grid.arc.centre);
      EXPECT_LE(p.head<2>().norm(), 0.9 + 1e-9);
      EXPECT_GE(p.head<2>().norm(), 0.2 - 1e-9);
      EXPECT_NEAR(path[i].pose.world_from_camera.col(0).dot(panorama.grid.arc.axis()), 0, 1e-12);
      EXPECT_NEAR(path[i].pose.world_from_camera.determinant(), 1, 1e-9);
      const size_t next = (i + 1) % path.size();
      if (kind != CameraPath::walk || next != 0) {
        EXPECT_LT((path[next].pose.centre - path[i].pose.centre).norm(), 0.04);
      }
    }
  }
}

TEST(CameraPath, shows_no_rows_beyond_the_panorama) {
  const PanoramaGrid grid = make_grid(Rays::pushbroom, true);
  LayeredPanorama panorama = one_layer(grid, [](double, double) { return 0.2; });
  panorama.grid.arc.closed = true;
  panorama.grid.arc.theta_end = 2 * kPi;
  const Renderer renderer(panorama);
  for (const auto kind : {CameraPath::sway, CameraPath::walk}) {
    CameraPathOptions options{kind, 5, 160, 160, 2.0};
    for (const Camera& camera : camera_path(panorama, options)) EXPECT_EQ(holes(renderer.render(camera, {})), 0);
  }
}

// A panorama of which all is seen but a margin on the left, and rows below.
LayeredPanorama with_margins(const PanoramaGrid& grid) {
  LayeredPanorama panorama = one_layer(grid, [](double, double) { return 0.2; });
  panorama.grid.arc.theta_begin = -0.3, panorama.grid.arc.theta_end = 0.3;
  panorama.limits = {0.2, 0.9, 0.3};
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      if (x < grid.width / 3 || y > 3 * grid.height / 4) panorama.layers[0].coverage.at(x, y) = 0;
  return panorama;
}

double worst_holes(const LayeredPanorama& panorama, const Renderer& renderer, const CameraPathOptions& path) {
  double worst = 0;
  for (const Camera& camera : camera_path(panorama, path))
    worst = std::max(worst, static_cast<double>(holes(renderer.render(camera, {}))) / (path.width * path.height));
  return worst;
}

TEST(Framing, KeepsBordersOutOfViewByTurningZoomingAndShorterWays) {
  const LayeredPanorama panorama = with_margins(make_grid(Rays::pushbroom, false));
  const Renderer renderer(panorama);
  for (const auto kind : {CameraPath::sway, CameraPath::walk, CameraPath::dolly}) {
    const CameraPathOptions wanted{kind, 12, 160, 120};
    const CameraPathOptions framed = framed_inside(panorama, renderer, wanted);
    EXPECT_GT(worst_holes(panorama, renderer, wanted), 0.02);
    EXPECT_LT(worst_holes(panorama, renderer, framed), 0.01);
    EXPECT_EQ(framed.frames, 12);
    EXPECT_EQ(framed.width, 160);
  }
}

TEST(Framing, LeavesAFieldOfViewThatWasAskedForAndAPathWithoutHolesAlone) {
  LayeredPanorama panorama = with_margins(make_grid(Rays::pushbroom, false));
  CameraPathOptions wanted{CameraPath::sway, 4, 160, 120, 0.9};
  EXPECT_EQ(framed_inside(panorama, Renderer(panorama), wanted).zoom, 1);
  for (uint8_t& covered : panorama.layers[0].coverage.samples) covered = 1;
  wanted.view_rad = 0.3;
  const CameraPathOptions same = framed_inside(panorama, Renderer(panorama), wanted);
  EXPECT_EQ(same.reach, 1);
  EXPECT_EQ(same.turn_rad, 0);
  EXPECT_EQ(same.rise, 0);
}

TEST(CameraPath, refuses_nonsense_in_words) {
  EXPECT_THAT([] { camera_path_from_name("fly"); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("sway, walk, dolly")));
  CameraPathOptions options;
  options.frames = 0;
  EXPECT_THAT([&] { camera_path({}, options); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("frames")));
}

}  // namespace
}  // namespace ldp
