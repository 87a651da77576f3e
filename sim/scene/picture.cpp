#include "sim/scene/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/scene/random.h"

namespace ldp {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

constexpr int kBandRows = 16;
constexpr float kEdgeContrast = 0.05F;  // in gamma-coded light, 0 .. 1

struct Sample {
  Vector3f colour = Vector3f::Zero();
  int object = 0;
  float depth = 0;
};

RayOf rays_of(const Camera& camera) {
  const Intrinsics& in = camera.intrinsics;
  const bool is_distorted = in.k1 != 0 || in.k2 != 0 || in.p1 != 0 || in.p2 != 0;
  return [&camera, is_distorted](const Eigen::Vector2d& at) {
    const Intrinsics& lens = camera.intrinsics;
    const Eigen::Vector3d direction =
        is_distorted ? unproject(lens, at)
                     : Eigen::Vector3d((at.x() - lens.cx) / lens.fx, (at.y() - lens.cy) / lens.fy, 1);
    return Ray{camera.pose.centre, camera.pose.world_from_camera * direction, 1 / lens.fx};
  };
}

class Eye {
 public:
  Eye(const Scene& scene, const RayOf& ray_of) : scene_(scene), ray_of_(ray_of) {}

  Sample look(double x, double y) const {
    const Hit hit = scene_.first_hit(ray_of_({x, y}));
    return {hit.colour, hit.object, static_cast<float>(hit.t)};
  }

 private:
  const Scene& scene_;
  const RayOf& ray_of_;
};

float gamma_of(float linear) { return std::sqrt(std::clamp(linear, 0.0F, 1.0F)); }

bool contrast(const Sample& a, const Sample& b) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(gamma_of(a.colour[i]) - gamma_of(b.colour[i])) > kEdgeContrast) return true;
  }
  return false;
}

// Rows y0 .. y1 of centres, and the corners around them.
struct Band {
  int y0 = 0, y1 = 0, width = 0;
  std::vector<Sample> centres, corners;

  const Sample& centre(int x, int y) const {
    return centres[static_cast<size_t>(y - y0) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
  const Sample& corner(int x, int y) const {
    return corners[static_cast<size_t>(y - y0) * static_cast<size_t>(width + 1) + static_cast<size_t>(x)];
  }

  // 0 = smooth, 1 = a contrast within one surface, 2 = an object's edge.
  uint8_t edge(int x, int y) const {
    const Sample& middle = centre(x, y);
    const Sample* around[] = {&corner(x, y), &corner(x + 1, y), &corner(x, y + 1), &corner(x + 1, y + 1)};
    if (std::any_of(std::begin(around), std::end(around), [&](const Sample* s) { return s->object != middle.object; }))
      return 2;
    return std::any_of(std::begin(around), std::end(around), [&](const Sample* s) { return contrast(*s, middle); }) ? 1
                                                                                                                    : 0;
  }
  Vector3f smooth(int x, int y) const {
    return 0.5F * centre(x, y).colour + 0.125F * (corner(x, y).colour + corner(x + 1, y).colour +
                                                  corner(x, y + 1).colour + corner(x + 1, y + 1).colour);
  }
};

Band sample_band(const Eye& eye, int width, int y0, int y1) {
  Band band{y0, y1, width, {}, {}};
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; ++x) band.centres.push_back(eye.look(x + 0.5, y + 0.5));
  }
  for (int y = y0; y <= y1; ++y) {
    for (int x = 0; x <= width; ++x) band.corners.push_back(eye.look(x, y));
  }
  return band;
}

Vector3f supersample(const Eye& eye, int x, int y, int samples) {
  Vector3f sum = Vector3f::Zero();
  const double step = 1.0 / samples;
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) sum += eye.look(x + (i + 0.5) * step, y + (j + 0.5) * step).colour;
  }
  return sum / static_cast<float>(samples * samples);
}

struct LinearPicture {
  Plane<Vector3f> light;
  Plane<float> depth;
  int edge_samples = 3;
};

// One row more on each side is sampled, so that a pixel beside an object's edge is refined too: thin things that fall
// between the samples of one pixel are caught by its neighbours.
void render_band(const Eye& eye, int y_begin, int y_end, const Job& job, LinearPicture& out) {
  const int width = out.light.width, height = out.light.height;
  const int y0 = std::max(0, y_begin - 1), y1 = std::min(height, y_end + 1);
  const Band band = sample_band(eye, width, y0, y1);
  Plane<uint8_t> edge(width, y1 - y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; ++x) edge.at(x, y - y0) = band.edge(x, y);
  }
  const auto near_edge = [&](int x, int y) {
    if (edge.at(x, y - y0) != 0) return true;
    for (int v = std::max(y0, y - 1); v <= std::min(y1 - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
        if (edge.at(u, v - y0) == 2) return true;
      }
    }
    return false;
  };
  for (int y = y_begin; y < y_end; ++y) {
    job.check();
    for (int x = 0; x < width; ++x) {
      out.depth.at(x, y) = band.centre(x, y).depth;
      out.light.at(x, y) = near_edge(x, y) ? supersample(eye, x, y, out.edge_samples) : band.smooth(x, y);
    }
  }
}

void smear_row(Vector3f* row, int width, double length_px) {
  const std::vector<Vector3f> source(row, row + width);
  const int reach = static_cast<int>(std::ceil(length_px / 2));
  for (int x = 0; x < width; ++x) {
    Vector3f sum = Vector3f::Zero();
    float weights = 0;
    for (int k = -reach; k <= reach; ++k) {
      // Share of the smear [-length/2, length/2] that falls on pixel x + k.
      const double covered = std::min(length_px / 2, k + 0.5) - std::max(-length_px / 2, k - 0.5);
      if (covered <= 0) continue;
      sum += static_cast<float>(covered) * source[static_cast<size_t>(std::clamp(x + k, 0, width - 1))];
      weights += static_cast<float>(covered);
    }
    row[x] = sum / weights;
  }
}

float srgb(float linear) {
  const float x = std::clamp(linear, 0.0F, 1.0F);
  return 255 * (x <= 0.0031308F ? 12.92F * x : 1.055F * std::pow(x, 1 / 2.4F) - 0.055F);
}

uint8_t rounded(double level) { return static_cast<uint8_t>(std::lround(std::clamp(level, 0.0, 255.0))); }

// Photon noise: in gamma-coded levels its deviation is nearly the same from shadow to light.
Rgb develop(const Vector3f& light, const PictureOptions& options, Random& random) {
  std::array<uint8_t, 3> levels{};
  for (size_t i = 0; i < 3; ++i) {
    const double level = srgb(light[static_cast<Eigen::Index>(i)] * static_cast<float>(options.exposure));
    levels[i] = rounded(options.noise > 0 ? level + options.noise * random.normal() : level);
  }
  return {levels[0], levels[1], levels[2]};
}

RgbImage develop(LinearPicture& picture, const PictureOptions& options, const Job& job) {
  RgbImage image(picture.light.width, picture.light.height);
  parallel_for(job, image.height, [&](int y) {
    if (options.motion_blur_px > 1) smear_row(picture.light.row(y), image.width, options.motion_blur_px);
    Random random(mix_bits(options.noise_seed) + static_cast<uint64_t>(y));
    for (int x = 0; x < image.width; ++x) image.at(x, y) = develop(picture.light.at(x, y), options, random);
  });
  return image;
}

// What brings the mean of logarithms of light to mid-grey.
double metered(const Plane<Vector3f>& light) {
  constexpr double kMidGrey = 0.18, kLeast = 1e-3;
  double sum = 0;
  for (const Vector3f& c : light.samples)
    sum += std::log(std::max(kLeast, static_cast<double>(0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2])));
  return kMidGrey / std::exp(sum / static_cast<double>(light.samples.size()));
}

void check(const Camera& camera) {
  const Intrinsics& in = camera.intrinsics;
  if (in.width < 1 || in.height < 1 || in.fx <= 0 || in.fy <= 0)
    throw std::logic_error("take_picture: camera needs a size and a focal length");
}

void check(const PictureOptions& options) {
  if (options.edge_samples < 1 || options.edge_samples > 8) {
    throw std::logic_error("take_picture: edge_samples " + std::to_string(options.edge_samples) + ", expected 1 .. 8");
  }
}

}  // namespace

Picture take_picture(const Scene& scene, const Camera& camera, const PictureOptions& options, const Job& job) {
  check(camera);
  return take_picture(scene, camera.intrinsics.width, camera.intrinsics.height, rays_of(camera), options, job);
}

Picture take_picture(const Scene& scene, int width, int height, const RayOf& ray_of, const PictureOptions& options,
                     const Job& job) {
  check(options);
  const Eye eye(scene, ray_of);
  LinearPicture picture{Plane<Vector3f>(width, height, Vector3f::Zero()), Plane<float>(width, height),
                        options.edge_samples};
  parallel_for(job, (height + kBandRows - 1) / kBandRows, [&](int band) {
    render_band(eye, band * kBandRows, std::min(height, (band + 1) * kBandRows), job, picture);
  });
  PictureOptions exposed = options;
  if (options.meters) exposed.exposure *= metered(picture.light);
  return {develop(picture, exposed, job), std::move(picture.depth), exposed.exposure};
}

Rgb developed(const Vector3f& light) {
  Random unused(0);
  return develop(light, {}, unused);
}

Plane<float> take_depth(const Scene& scene, const Camera& camera, const Job& job) {
  check(camera);
  const RayOf ray_of = rays_of(camera);
  const Eye eye(scene, ray_of);
  Plane<float> depth(camera.intrinsics.width, camera.intrinsics.height);
  parallel_for(job, depth.height, [&](int y) {
    for (int x = 0; x < depth.width; ++x) depth.at(x, y) = eye.look(x + 0.5, y + 0.5).depth;
  });
  return depth;
}

}  // namespace ldp
